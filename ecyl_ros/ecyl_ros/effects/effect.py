"""What an effect is: a name, a block, parameters, and what it changes in the drive."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..arrays import FloatArray
from ..drive.parameters import DriveParameters
from .passed import Passed

BLOCKS = (
    "motor_electrical",
    "motor_mechanical",
    "transmission",
    "load",
    "sensor",
    "timing",
    "controller",
)


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """One parameter of an effect.

    Attributes:
        name: as in drive files and diagnoses, with its unit.
        unit: SI.
        low, high: what is physically possible, both ends included; fits stay within.
        meaning: a few words.
        default: value where a drive file gives none; None where it must.
        nuisance: has to be fitted but says nothing of the machine (a phase).
    """

    name: str
    unit: str
    low: float
    high: float
    meaning: str
    default: float | None = None
    nuisance: bool = False


class Evidence(Protocol):
    """What a recording offers to effects that look for a start of their fit; SI units.

    Every array is float64[n] on one grid; NaN where unknown.
    """

    @property
    def drive(self) -> DriveParameters:
        """The nominal model."""

    @property
    def time_s(self) -> FloatArray:
        """From the first sample, s."""

    @property
    def rotor_angle_rad(self) -> FloatArray:
        """Recorded."""

    @property
    def rotor_speed_rad_s(self) -> FloatArray:
        """Recorded, or from the angle."""

    @property
    def current_a(self) -> FloatArray:
        """Recorded i_q."""

    @property
    def voltage_v(self) -> FloatArray:
        """Recorded u_q."""

    @property
    def torque_nm(self) -> FloatArray:
        """Torque on rotor and load together that the model does not explain.

        NaN where the flanks are apart.
        """

    @property
    def torque_over_angle(self) -> Passed:
        """What the filter of `torque_nm` leaves of a line over the rotor angle."""

    @property
    def current_error_a(self) -> FloatArray:
        """Recorded less replayed i_q."""

    @property
    def rotor_speed_error_rad_s(self) -> FloatArray:
        """Recorded less replayed rotor speed."""

    @property
    def rod_error_rad(self) -> FloatArray:
        """Rod position that rotor and transmission do not explain, as rotor angle."""


Start = Mapping[str, float]


def no_starts(evidence: Evidence) -> Sequence[Start]:
    """No start known: an effect that cannot be fitted from a recording."""
    return ()


def _to_none(values: Start, drive: DriveParameters) -> Sequence[Mapping[str, Start]]:
    """Most effects act like no others."""
    return ()


def _zero(drive: DriveParameters) -> float:
    """Most effects vanish at zero."""
    return 0.0


def _not_stiff(values: Mapping[str, float]) -> float:
    """Most effects leave the winding's equation as slow as it is."""
    return 0.0


@dataclass(frozen=True, kw_only=True)
class Effect:
    """One unmodelled effect.

    Attributes:
        name: as in the drive file and the diagnosis.
        block: where it acts, one of `BLOCKS`.
        title: what a drive engineer calls it.
        summary: what it is and what it looks like in a recording.
        excitation: what a recording must contain for it to be seen.
        separated_by: what of a cylinder's motion, beside that, separates it from its like.
        parameters: what describes it.
        starts: values to begin a fit at, several where the fit may get stuck.
        shown: parameters that a recording shows as they are, and their values: these are not
            fitted. Empty where it does not; None where none does.
        modify: changes the packed record of the drive (see `drive.packed`), for effects that are
            another value of something the model has. Effects with a port of their own (see
            `ports`) have their parameters in the record under `field_name` and need none.
        refines: effects that this one contains as a special case. It is named in their place only
            where it removes clearly more.
        gives_way: to sets of others that act nearly alike, as they do at its values; one takes its
            place where it removes clearly more.
        sized: parameters that the size of the effect is in proportion to; the first one unless
            given, none where there is no such thing (a limit).
        neutral: the value of those at which the effect vanishes.
        constant: key of the drive file's constant that it gives another value, None where it is
            something that the nominal model does not have. on_top: its parameter is what comes on
            top of the nominal value, not the value.
        current_span: current over which it bends the winding's equation, A, where it makes that
            stiff; it then has a port `inverter_resistance`. 0: it does not.
        form: half width that no interval of its parameters falls below, in their unit, as far as
            drives differ in how they have it.
        place: part of the rod's stroke that it is confined to at its values, from and to, m; None
            where it is not. It is named where the motion goes beyond both ends.
        period_m: travel of the rod after which it repeats at its values, m; None where it is no
            wave along the stroke. one_curve_with: effects that act at the same place along the
            stroke: beside one of them it is named where the motion shows that it repeats.
        rarity: 0 of what most machines have, one more for every third of those before: where two
            do nearly as well, what is common goes first.
        cylinder: whether a full cylinder may have it.
    """

    name: str
    block: str
    title: str
    summary: str
    excitation: str
    parameters: tuple[Quantity, ...]
    starts: Callable[[Evidence], Sequence[Start]] = no_starts
    shown: Callable[[Evidence], Start] | None = None
    modify: Callable[[np.ndarray, Mapping[str, float], DriveParameters], None] | None = None
    refines: tuple[str, ...] = ()
    gives_way: Callable[[Start, DriveParameters], Sequence[Mapping[str, Start]]] = _to_none
    sized: tuple[str, ...] | None = None
    neutral: Callable[[DriveParameters], float] = _zero
    constant: str | None = None
    on_top: bool = False
    current_span: Callable[[Mapping[str, float]], float] = _not_stiff
    form: Callable[[DriveParameters], float] = _zero
    place: Callable[[Start], tuple[float, float]] | None = None
    period_m: Callable[[Start, DriveParameters], float] | None = None
    one_curve_with: tuple[str, ...] = ()
    rarity: int = 0
    cylinder: bool = True
    separated_by: str = ""

    def __post_init__(self) -> None:
        if self.block not in BLOCKS:
            raise ValueError(f"{self.name}: block {self.block!r}, expected one of {BLOCKS}")

    @property
    def needed(self) -> str:
        """What a recording of a cylinder must contain for it to be seen, and told from its like."""
        return "; ".join(one for one in (self.excitation, self.separated_by) if one)

    @property
    def reported(self) -> tuple[Quantity, ...]:
        """The parameters that say something of the machine."""
        return tuple(one for one in self.parameters if not one.nuisance)

    def scaled(
        self, values: Mapping[str, float], size: float, drive: DriveParameters
    ) -> dict[str, float]:
        """`values` for an effect `size` times as large, within what is possible."""
        names = (self.parameters[0].name,) if self.sized is None else self.sized
        neutral = self.neutral(drive)
        result = dict(values)
        for one in self.parameters:
            if one.name in names:
                value = neutral + size * (values[one.name] - neutral)
                result[one.name] = min(max(value, one.low), one.high)
        return result

    def field_name(self, parameter: str) -> str:
        """Name of a parameter in the packed record."""
        return f"{self.name}_{parameter}"

    def complete(self, values: Mapping[str, float]) -> dict[str, float]:
        """`values` with defaults filled in, in the order of `parameters`.

        Raises KeyError for a parameter that is missing or that the effect does not have.
        """
        unknown = set(values) - {one.name for one in self.parameters}
        if unknown:
            raise KeyError(sorted(unknown)[0])
        full: dict[str, float] = {}
        for one in self.parameters:
            value = values.get(one.name, one.default)
            if value is None:
                raise KeyError(one.name)
            full[one.name] = float(value)
        return full


def phase(meaning: str = "at angle or time zero") -> Quantity:
    """The phase of a periodic effect: fitted, but of no interest."""
    return Quantity(
        name="phase_rad",
        unit="rad",
        low=-4.0 * math.pi,
        high=4.0 * math.pi,
        meaning=meaning,
        default=0.0,
        nuisance=True,
    )


def bristle(side: str) -> tuple[Quantity, Quantity]:
    """How the contact of a friction effect gives before it slips; `side`: rotor or load."""
    return (
        Quantity(
            name="breakaway_rad",
            unit="rad",
            low=1e-6,
            high=1e-1,
            meaning=f"deflection of the {side} at which it slips",
            default=1e-4,
            nuisance=True,
        ),
        Quantity(
            name="bristle_damping_s",
            unit="s",
            low=0.0,
            high=1e-1,
            meaning="damping torque of the deflection over friction level x its rate",
            default=2e-4,
            nuisance=True,
        ),
    )


def put_bristle(record: np.ndarray, side: str, values: Mapping[str, float]) -> None:
    """Put the parameters of `bristle` into a packed record."""
    record[f"{side}_breakaway"] = values["breakaway_rad"]
    record[f"{side}_bristle_damping"] = values["bristle_damping_s"]
