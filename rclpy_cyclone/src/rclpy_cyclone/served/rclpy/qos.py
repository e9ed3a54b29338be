"""Quality of service: profiles, policies, presets."""

from __future__ import annotations

import warnings
from enum import Enum, IntEnum
from typing import Any

from rclpy._rclpy_pybind11 import QoSCompatibility
from rclpy.duration import Duration, Infinite

_BEST_AVAILABLE_NS = 9223372036854775806


class QoSPolicyKind(IntEnum):
    """Kinds of policies, as bits."""

    INVALID = 1 << 0
    DURABILITY = 1 << 1
    DEADLINE = 1 << 2
    LIVELINESS = 1 << 3
    RELIABILITY = 1 << 4
    HISTORY = 1 << 5
    LIFESPAN = 1 << 6
    DEPTH = 1 << 7
    LIVELINESS_LEASE_DURATION = 1 << 8
    AVOID_ROS_NAMESPACE_CONVENTIONS = 1 << 9


def qos_policy_name_from_kind(policy_kind: QoSPolicyKind | int) -> str:
    """Return the name of a kind of policy."""
    return QoSPolicyKind(policy_kind).name


class InvalidQoSProfileException(Exception):
    """A profile is made from arguments that do not make one."""

    def __init__(self, *args: Any) -> None:
        Exception.__init__(self, "Invalid QoSProfile", *args)


class QoSPolicyEnum(IntEnum):
    """Base of the policies' enumerations."""

    @classmethod
    def short_keys(cls) -> list[str]:
        """Return the values as short lower-case words."""
        return [k.lower() for k in cls.__members__ if not k.startswith("RMW")]

    @classmethod
    def get_from_short_key(cls, name: str) -> int:
        """Return the value of a short word, in any case.

        :raises KeyError: if there is none.
        """
        return cls[name.upper()].value

    @property
    def short_key(self) -> str:
        """The value as a short lower-case word."""
        return self.name.lower()


class HistoryPolicy(QoSPolicyEnum):
    """Which samples are kept."""

    SYSTEM_DEFAULT = 0
    KEEP_LAST = 1
    KEEP_ALL = 2
    UNKNOWN = 3


class ReliabilityPolicy(QoSPolicyEnum):
    """Whether lost samples are sent again."""

    SYSTEM_DEFAULT = 0
    RELIABLE = 1
    BEST_EFFORT = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class DurabilityPolicy(QoSPolicyEnum):
    """Whether late subscribers get earlier samples."""

    SYSTEM_DEFAULT = 0
    TRANSIENT_LOCAL = 1
    VOLATILE = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class LivelinessPolicy(QoSPolicyEnum):
    """How a publisher shows that it is alive."""

    SYSTEM_DEFAULT = 0
    AUTOMATIC = 1
    MANUAL_BY_TOPIC = 3
    UNKNOWN = 4
    BEST_AVAILABLE = 5


QoSHistoryPolicy = HistoryPolicy
QoSReliabilityPolicy = ReliabilityPolicy
QoSDurabilityPolicy = DurabilityPolicy
QoSLivelinessPolicy = LivelinessPolicy


class _Deprecated:
    """An old name of a policy value, which warns and gives the new one."""

    def __init__(self, old: str, new: str) -> None:
        self.old, self.new = old, new

    def __get__(self, obj: Any, owner: Any) -> Any:
        warnings.warn(
            f"{owner.__name__}.{self.old} is deprecated. Use {owner.__name__}.{self.new} instead.",
            stacklevel=2,
        )
        return owner[self.new]


for _policy, _word in (
    (HistoryPolicy, "HISTORY"),
    (ReliabilityPolicy, "RELIABILITY"),
    (DurabilityPolicy, "DURABILITY"),
    (LivelinessPolicy, "LIVELINESS"),
):
    for _key in list(_policy.__members__):
        if _key != "BEST_AVAILABLE":
            _old = f"RMW_QOS_POLICY_{_word}_{_key}"
            type.__setattr__(_policy, _old, _Deprecated(_old, _key))

DeadlineBestAvailable = Duration(nanoseconds=_BEST_AVAILABLE_NS)
LivelinessLeaseDurationeBestAvailable = Duration(nanoseconds=_BEST_AVAILABLE_NS)


_DEFAULTS: dict[str, Any] = {
    "history": HistoryPolicy.KEEP_LAST,
    "depth": 10,
    "reliability": ReliabilityPolicy.RELIABLE,
    "durability": DurabilityPolicy.VOLATILE,
    "lifespan": Duration(),
    "deadline": Duration(),
    "liveliness": LivelinessPolicy.SYSTEM_DEFAULT,
    "liveliness_lease_duration": Duration(),
    "avoid_ros_namespace_conventions": False,
}


class QoSProfile:
    """A set of policies for a publisher, subscription, client or service.

    :param history: :class:`HistoryPolicy`; ``KEEP_LAST`` if only a depth is given.
    :param depth: how many samples ``KEEP_LAST`` keeps.
    :param reliability: :class:`ReliabilityPolicy`, default ``RELIABLE``.
    :param durability: :class:`DurabilityPolicy`, default ``VOLATILE``.
    :param lifespan: :class:`.Duration` after which a sample is dropped.
    :param deadline: longest :class:`.Duration` between two samples.
    :param liveliness: :class:`LivelinessPolicy`.
    :param liveliness_lease_duration: :class:`.Duration` within which to show life.
    :param avoid_ros_namespace_conventions: whether the topic name is used as it is.
    :raises InvalidQoSProfileException: if neither history nor depth is given, or
        ``KEEP_LAST`` without a depth.
    """

    __slots__ = [  # noqa: RUF023  (in the order they are printed in)
        "_history",
        "_depth",
        "_reliability",
        "_durability",
        "_lifespan",
        "_deadline",
        "_liveliness",
        "_liveliness_lease_duration",
        "_avoid_ros_namespace_conventions",
    ]

    def __init__(self, **kwargs: Any) -> None:
        assert all("_" + key in self.__slots__ for key in kwargs), (
            f"Invalid arguments passed to constructor: {kwargs.keys()!r}"
        )
        if "history" not in kwargs and "depth" not in kwargs:
            raise InvalidQoSProfileException("History and/or depth settings are required.")
        chosen = {**_DEFAULTS, **kwargs}
        last = HistoryPolicy.KEEP_LAST
        if chosen["history"] == last and "depth" not in kwargs:
            raise InvalidQoSProfileException("History set to KEEP_LAST without a depth setting.")
        for name in _DEFAULTS:  # history first: the check of the depth looks at it
            setattr(self, name, chosen[name])

    def __eq__(self, other: Any) -> bool:
        if not isinstance(other, QoSProfile):
            return False
        return all(getattr(self, slot) == getattr(other, slot) for slot in self.__slots__)

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        parts = (f"{slot[1:]}={getattr(self, slot)}" for slot in self.__slots__)
        return f"{type(self).__name__}({', '.join(parts)})"

    @property
    def depth(self) -> int:
        """How many samples ``KEEP_LAST`` keeps."""
        return self._depth

    @depth.setter
    def depth(self, value: int) -> None:
        assert isinstance(value, int)
        if getattr(self, "history") == HistoryPolicy.KEEP_LAST and value == 0:  # noqa: B009
            warnings.warn(
                "A zero depth with KEEP_LAST doesn't make sense; no data could be stored. "
                "This will be interpreted as SYSTEM_DEFAULT",
                stacklevel=2,
            )
        self._depth = value

    def get_c_qos_profile(self) -> QoSProfile:
        """Return the profile itself; there is no compiled representation."""
        return self


def _policy_property(name: str, kind: Any) -> property:
    def put(self: QoSProfile, value: Any) -> None:
        assert isinstance(value, (kind, int)), f"{name} must be a {kind.__name__}"
        setattr(self, f"_{name}", kind(value))

    return property(lambda self: getattr(self, f"_{name}"), put, doc=f"A :class:`{kind.__name__}`.")


def _plain_property(name: str, kind: Any, what: str) -> property:
    def put(self: QoSProfile, value: Any) -> None:
        assert isinstance(value, kind), f"{name} must be a {kind.__name__}"
        setattr(self, f"_{name}", value)

    return property(lambda self: getattr(self, f"_{name}"), put, doc=what)


for _name, _kind in (
    ("history", HistoryPolicy),
    ("reliability", ReliabilityPolicy),
    ("durability", DurabilityPolicy),
    ("liveliness", LivelinessPolicy),
):
    setattr(QoSProfile, _name, _policy_property(_name, _kind))
for _name, _plain, _what in (
    ("lifespan", Duration, "Age at which a sample is dropped."),
    ("deadline", Duration, "Longest time between two samples."),
    ("liveliness_lease_duration", Duration, "Time within which a publisher shows life."),
    ("avoid_ros_namespace_conventions", bool, "Whether the topic name is used as it is."),
):
    setattr(QoSProfile, _name, _plain_property(_name, _plain, _what))
qos_profile_unknown = QoSProfile(
    history=HistoryPolicy.UNKNOWN,
    depth=0,
    reliability=ReliabilityPolicy.UNKNOWN,
    durability=DurabilityPolicy.UNKNOWN,
    liveliness=LivelinessPolicy.UNKNOWN,
)
qos_profile_default = QoSProfile(depth=10)
qos_profile_system_default = QoSProfile(
    history=HistoryPolicy.SYSTEM_DEFAULT,
    depth=0,
    reliability=ReliabilityPolicy.SYSTEM_DEFAULT,
    durability=DurabilityPolicy.SYSTEM_DEFAULT,
)
qos_profile_sensor_data = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
qos_profile_services_default = QoSProfile(depth=10)
qos_profile_parameters = QoSProfile(depth=1000)
qos_profile_parameter_events = QoSProfile(depth=1000)
qos_profile_best_available = QoSProfile(
    depth=10,
    reliability=ReliabilityPolicy.BEST_AVAILABLE,
    durability=DurabilityPolicy.BEST_AVAILABLE,
    deadline=DeadlineBestAvailable,
    liveliness=LivelinessPolicy.BEST_AVAILABLE,
    liveliness_lease_duration=LivelinessLeaseDurationeBestAvailable,
)
qos_profile_action_status_default = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_qos_profile_rosout = QoSProfile(
    depth=1000,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
    lifespan=Duration(seconds=10),
)


class QoSPresetProfiles(Enum):
    """The predefined profiles."""

    UNKNOWN = qos_profile_unknown
    DEFAULT = qos_profile_default
    SYSTEM_DEFAULT = qos_profile_system_default
    SENSOR_DATA = qos_profile_sensor_data
    SERVICES_DEFAULT = qos_profile_services_default
    PARAMETERS = qos_profile_parameters
    PARAMETER_EVENTS = qos_profile_parameter_events
    ACTION_STATUS_DEFAULT = qos_profile_action_status_default
    BEST_AVAILABLE = qos_profile_best_available

    @classmethod
    def short_keys(cls) -> list[str]:
        """Return the names as short lower-case words."""
        return [k.lower() for k in cls.__members__ if not k.startswith("RMW")]

    @classmethod
    def get_from_short_key(cls, name: str) -> QoSProfile:
        """Return the profile of a short word, in any case."""
        return cls[name.upper()].value


def qos_check_compatible(
    publisher_qos: QoSProfile, subscription_qos: QoSProfile
) -> tuple[QoSCompatibility, str]:
    """Say whether a publisher and a subscription with these profiles would match.

    :return: the verdict, and the reasons if it is not ``OK``.
    """
    errors: list[str] = []
    warns: list[str] = []
    pub, sub = publisher_qos, subscription_qos
    for policy, weak, strong, words in (
        ("reliability", "BEST_EFFORT", "RELIABLE", ("Best effort", "Reliable")),
        ("durability", "VOLATILE", "TRANSIENT_LOCAL", ("Volatile", "Transient local")),
    ):
        offered, wanted = getattr(pub, policy), getattr(sub, policy)
        given, asked = offered.name.lower(), wanted.name.lower()
        if offered.name == weak and wanted.name == strong:
            errors.append(f"{words[0]} publisher and {words[1].lower()} subscription")
        elif offered.name == weak and _unclear(wanted):
            warns.append(f"{words[0]} publisher, but subscription is {asked}")
        elif _unclear(offered) and wanted.name == strong:
            warns.append(f"{words[1]} subscription, but publisher is {given}")
        elif _unclear(offered) and _unclear(wanted):
            warns.append(f"Publisher {policy} is {given} and subscription {policy} is {asked}")
    for name, what, less in (
        ("deadline", "a deadline", "deadline is less than publisher deadline"),
        (
            "liveliness_lease_duration",
            "a liveliness lease duration",
            "liveliness lease duration is less than publisher",
        ),
    ):
        longest, limit = getattr(pub, name).nanoseconds, getattr(sub, name).nanoseconds
        none = (0, Infinite.nanoseconds, _BEST_AVAILABLE_NS)
        if limit not in none and longest in none[:2]:
            errors.append(f"Subscription has {what}, but publisher does not")
        elif limit not in none and longest not in none and limit < longest:
            errors.append(f"Subscription {less}")
    _check_liveliness(publisher_qos, subscription_qos, errors, warns)
    if errors:
        return QoSCompatibility.ERROR, "".join(f"ERROR: {e};" for e in errors)
    verdict = QoSCompatibility.WARNING if warns else QoSCompatibility.OK
    return verdict, "".join(f"WARNING: {w};" for w in warns)


def _unclear(policy: Any) -> bool:
    return policy.name in ("SYSTEM_DEFAULT", "UNKNOWN")


def _check_liveliness(pub: Any, sub: Any, errors: list[str], warns: list[str]) -> None:
    pub, sub = pub.liveliness, sub.liveliness
    given, asked = pub.name.lower(), sub.name.lower()
    if pub.name == "AUTOMATIC" and sub.name == "MANUAL_BY_TOPIC":
        errors.append("Publisher's liveliness is automatic and subscription's is manual by topic")
    elif pub.name == "AUTOMATIC" and _unclear(sub):
        warns.append(f"Publisher's liveliness is automatic, but subscription's is {asked}")
    elif _unclear(pub) and sub.name == "MANUAL_BY_TOPIC":
        warns.append(f"Subscription's liveliness is manual by topic, but publisher's is {given}")
    elif _unclear(pub) and _unclear(sub):
        warns.append(f"Publisher liveliness is {given} and subscription liveliness is {asked}")
