"""A map proposed from the names that topics, joints, fields and columns bear."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass

from .map import MAPPED, MappedSignal, SignalMap, TimeColumn
from .mapped import contract_map
from .survey import FieldSurvey, Survey, TopicSurvey
from .units import UNITS, dimension_of, in_si, plain

# Words in names -> what they speak of. Whole words: `pos`, not `composite`.
_QUANTITY = {
    "position": "position",
    "positions": "position",
    "pos": "position",
    "angle": "position",
    "theta": "position",
    "displacement": "position",
    "stroke": "position",
    "q": "position",
    "qm": "position",
    "qg": "position",
    "x": "position",
    "velocity": "velocity",
    "velocities": "velocity",
    "vel": "velocity",
    "speed": "velocity",
    "omega": "velocity",
    "rpm": "velocity",
    "dq": "velocity",
    "effort": "effort",
    "efforts": "effort",
    "torque": "effort",
    "torques": "effort",
    "trq": "effort",
    "tau": "effort",
    "force": "effort",
    "current": "current_q",
    "iq": "current_q",
    "id": "current_d",
    "voltage": "voltage_q",
    "uq": "voltage_q",
    "vq": "voltage_q",
    "ud": "voltage_d",
    "vd": "voltage_d",
}
_ASKED = {
    "reference",
    "ref",
    "desired",
    "des",
    "setpoint",
    "sp",
    "command",
    "commands",
    "commanded",
    "cmd",
    "target",
    "goal",
    "demand",
    "set",
    "control",
    "qg",
}
_ROTOR = {"rotor", "motor", "mot", "servo", "encoder", "enc"}
_ROD = {"rod", "cylinder", "piston", "slider", "carriage", "stage", "linear", "ram", "axis"}
_FORCE = {"force"}
_NOT = {"error", "err", "covariance", "timestamp", "time", "stamp", "acceleration", "acc"}
_UNIT_IN_NAME = re.compile(r"[\[(]\s*([^\])]+?)\s*[\])]\s*$|_([A-Za-z]+(?:_per_[A-Za-z]+)?)$")
_SLASHED = {"rad_per_s": "rad/s", "m_per_s": "m/s", "mm_per_s": "mm/s", "deg_per_s": "deg/s"}
_CASED = {"ma": "mA", "mv": "mV", "nm": "N m", "kn": "kN", "n": "N", "a": "A", "v": "V"}
_MEASURED = {
    "length": "position",
    "angle": "position",
    "speed": "velocity",
    "angular speed": "velocity",
    "torque": "effort",
    "force": "effort",
    "current": "current_q",
    "voltage": "voltage_q",
}
_LONGEST_ROD_M = 20.0


@dataclass(frozen=True)
class _Candidate:
    topic: TopicSurvey
    field: FieldSurvey
    joint: str
    words: frozenset[str]

    @property
    def place(self) -> str:
        """Which of several joints it is of: the name, else the index; empty for neither."""
        found = re.search(r"\[(\d+)\]$", self.field.path)
        return self.joint or (found[1] if found else "")

    @property
    def path(self) -> str:
        """The field as a map writes it: by joint where it has one."""
        return re.sub(r"\[\d+\]$", "", self.field.path) if self.joint else self.field.path


@dataclass(frozen=True)
class Proposal:
    """A map, or None where nothing could be recognised, and remarks on what to check."""

    map: SignalMap | None
    remarks: tuple[str, ...]


def propose(survey: Survey) -> Proposal:
    """The map that names suggest. What they leave open is taken as most recordings have it, and
    stands among the remarks."""
    own = _contract(survey)
    if own:
        return Proposal(SignalMap(survey.path, own), ("the topics are those of this project",))
    remarks: list[str] = []
    candidates = [one for topic in survey.topics for one in _candidates(topic)]
    candidates, remark = _one_joint(candidates)
    remarks += remark
    chosen: dict[str, MappedSignal] = {}
    scores: dict[str, float] = {}
    for one in candidates:
        found = _signal(one)
        if found is None:
            continue
        signal, score = found
        if score > scores.get(signal.name, 0.0):
            chosen[signal.name], scores[signal.name] = signal, score
    _follow_the_measured(chosen, candidates)
    if "effort" in chosen and "current_q" in chosen and chosen["effort"].unit == "A":
        del chosen["effort"]
    targets: dict[str, str] = {}
    for name in [name for name in MAPPED if name in chosen]:
        if chosen[name].target in targets:
            del chosen[name]
            continue
        targets[chosen[name].target] = name
    if not chosen:
        return Proposal(None, ("no field has a name that says which signal it is",))
    remarks += _against(chosen, candidates)
    for name in MAPPED:
        if name in chosen:
            remarks += _remarks(chosen[name], candidates)
    if not any(name.startswith("reference_") for name in chosen):
        remarks.append("no reference: without one the controller's part cannot be replayed")
    time = None
    if survey.kind in ("CSV", "MAT"):
        if survey.time is None:
            remarks.append("no column is called as one of instants: time or rate has to be given")
        else:
            name, unit_s = survey.time
            units = {value: unit for unit, value in UNITS["time"].items()}
            time = TimeColumn(name, units.get(unit_s, "s"))
            if survey.time_guessed:
                remarks.append(f"time: {time.unit} is guessed from the steps of {name}")
    ordered = tuple(chosen[name] for name in MAPPED if name in chosen)
    return Proposal(SignalMap(survey.path, ordered, time), tuple(remarks))


def _one_joint(candidates: list[_Candidate]) -> tuple[list[_Candidate], list[str]]:
    """Of several joints the one that moves most: a drive is diagnosed by itself."""
    moved: dict[str, float] = {}
    for one in candidates:
        if one.place and one.words & _QUANTITY.keys():
            moved[one.place] = moved.get(one.place, 0.0) + one.field.std
    # A rotor and a rod are two joints of one drive.
    if len(moved) < 2 or any(_words(place) & (_ROTOR | _ROD) for place in moved):
        return candidates, []
    best = max(moved, key=lambda place: moved[place])
    remark = f"joint {best} moves most of {', '.join(sorted(moved)[:12])}: the others are left out"
    return [one for one in candidates if one.place in ("", best)], [remark]


def _follow_the_measured(chosen: dict[str, MappedSignal], candidates: list[_Candidate]) -> None:
    """A reference without a unit is in that of what is measured: a rotary drive's is an angle."""
    for quantity in ("position", "velocity"):
        reference = chosen.get(f"reference_{quantity}")
        rotary = any(f"rotor_{one}" in chosen for one in ("position", "velocity"))
        if reference is None or not rotary:
            continue
        if any(f"rod_{one}" in chosen for one in ("position", "velocity")):
            continue
        if _unit(_candidate(reference, candidates)):
            continue
        unit = "rad" if quantity == "position" else "rad/s"
        target = MAPPED[reference.name][dimension_of(unit) or ""]
        chosen[reference.name] = dataclasses.replace(reference, unit=unit, target=target)


def _against(chosen: dict[str, MappedSignal], candidates: list[_Candidate]) -> list[str]:
    """Turn the sign of a measured position whose range mirrors the reference's."""
    out = []
    for body in ("rod", "rotor"):
        reference, measured = chosen.get("reference_position"), chosen.get(f"{body}_position")
        if reference is None or measured is None:
            continue
        if dimension_of(reference.unit) != dimension_of(measured.unit):
            continue
        asked, found = (
            (in_si(one.unit) * own.low, in_si(one.unit) * own.high)
            for one in (reference, measured)
            for own in (_candidate(one, candidates).field,)
        )
        straight = abs(found[0] - asked[0]) + abs(found[1] - asked[1])
        mirrored = abs(found[0] + asked[1]) + abs(found[1] + asked[0])
        if mirrored < 0.2 * straight:
            chosen[measured.name] = dataclasses.replace(measured, sign=-1)
            out.append(f"{measured.name}: its range mirrors the reference's, hence sign -1")
    return out


def _candidate(signal: MappedSignal, candidates: list[_Candidate]) -> _Candidate:
    return next(
        one
        for one in candidates
        if (one.topic.name, one.path, one.joint) == (signal.topic, signal.field, signal.joint)
    )


def _contract(survey: Survey) -> tuple[MappedSignal, ...]:
    topics = {topic.name: topic for topic in survey.topics}
    kept = []
    for one in contract_map().signals:
        topic = topics.get(one.topic)
        if topic is None or (one.joint and one.joint not in topic.names.get("name", ())):
            continue
        index = topic.names["name"].index(one.joint) if one.joint else 0
        path = f"{one.field}[{index}]" if one.joint else one.field
        if any(field.path == path and field.count for field in topic.fields):
            kept.append(one)
    return tuple(kept)


def _candidates(topic: TopicSurvey) -> list[_Candidate]:
    out = []
    for field in topic.fields:
        if not field.count:
            continue
        joint = _joint_of(topic, field.path)
        words = _words(topic.name) | _words(_bare(field.path)) | _words(joint)
        out.append(_Candidate(topic, field, joint, frozenset(words)))
    return out


def _joint_of(topic: TopicSurvey, path: str) -> str:
    found = re.search(r"\[(\d+)\]$", path)
    if not found:
        return ""
    array = path[: found.start()]
    sizes = sum(
        1 for f in topic.fields if re.sub(r"\[\d+\]$", "", f.path) == array and f.path != array
    )
    for names in topic.names.values():
        # An array that never held a finite value has no fields; one with names has as many.
        if len(names) >= sizes and int(found[1]) < len(names):
            return names[int(found[1])]
    return ""


def _bare(name: str) -> str:
    return re.sub(r"[\[(][^\])]*[\])]\s*$", "", name)


def _words(name: str) -> set[str]:
    spaced = re.sub(r"([a-z0-9])([A-Z])", r"\1 \2", name)
    return {word.lower() for word in re.split(r"[^A-Za-z]+", spaced) if word}


def _unit(one: _Candidate) -> str:
    """The unit that a line of units or a name gives; empty for none that is known."""
    told = one.field.unit
    if not told:
        name = re.sub(r"\[\d+\]$", "", one.field.path)
        found = _UNIT_IN_NAME.search(one.topic.name if name == "data" else name)
        told = (found[1] or found[2] or "") if found else ""
    told = _SLASHED.get(told, told)
    spellings = {told, told.lower(), _CASED.get(told.lower(), told)}
    for spelling in (told, *sorted(spellings)):
        unit = plain(spelling)
        if unit and dimension_of(unit) not in (None, "time", "number"):
            return unit
    return ""


def _signal(one: _Candidate) -> tuple[MappedSignal, float] | None:
    words = one.words
    if words & _NOT:
        return None
    asked = bool(words & _ASKED)
    if one.field.equal == 1.0 and not asked:  # never changes: not connected
        return None
    own = _words(_bare(one.field.path))
    unit = _unit(one)
    # What stands last says most: `motor_position`, `reference.positions`, `/joint/torque` `data`.
    said = [*_ordered(one.field.path), *_ordered(one.topic.name)]
    quantity = next((_QUANTITY[word] for word in said if word in _QUANTITY), None)
    if quantity is None and unit:
        quantity = _MEASURED.get(dimension_of(unit) or "")
    if quantity is None:
        return None
    score = 1.0 + 0.5 * bool(unit) + 0.5 * (one.field.equal < 1.0) + 0.2 * bool(one.joint)
    name: str
    if quantity in ("position", "velocity"):
        if asked:
            name = f"reference_{quantity}"
            score += 0.5 * bool(own & _ASKED)
        else:
            name = f"{_body(one, unit)}_{quantity}"
            score += 0.3 * bool(words & (_ROTOR | _ROD))
    else:
        name = quantity
        # What the drive measured of its effort says more than what it was told.
        score += 0.3 * (not asked)
    dimensions = MAPPED[name]
    if unit and dimension_of(unit) not in dimensions:
        return None
    if not unit:
        unit = _usual_unit(name, one)
    target = dimensions[dimension_of(unit) or next(iter(dimensions))]
    return MappedSignal(name, target, one.path, one.topic.name, one.joint, unit), score


def _ordered(path: str) -> list[str]:
    spaced = re.sub(r"([a-z0-9])([A-Z])", r"\1 \2", _bare(path))
    return [word.lower() for word in re.split(r"[^A-Za-z]+", spaced) if word][::-1]


def _body(one: _Candidate, unit: str) -> str:
    """Whether a measured motion is the rotor's or the rod's."""
    dimension = dimension_of(unit) if unit else None
    if dimension in ("length", "speed"):
        return "rod"
    if dimension in ("angle", "angular speed") or one.words & _ROTOR:
        return "rotor"
    if one.words & _ROD:
        return "rod"
    # A turn counter runs into many rad; a rod does not travel that far.
    far = max(abs(one.field.low), abs(one.field.high)) > 3.0
    return "rotor" if far else "rod"


def _usual_unit(name: str, one: _Candidate) -> str:
    if name == "effort":
        return "N" if one.words & _FORCE else "N m"
    return next(iter(UNITS[next(iter(MAPPED[name]))]))


def _in_si(kind: str) -> bool:
    """Whether a message's type says what its numbers are, and so, by REP 103, their unit."""
    return "/msg/" in kind and not kind.startswith(("std_msgs/", "example_interfaces/"))


def _remarks(signal: MappedSignal, candidates: list[_Candidate]) -> list[str]:
    out = []
    own = _candidate(signal, candidates)
    if not _unit(own) and not _in_si(own.topic.type):
        low, high = own.field.low, own.field.high
        said = f"{signal.name}: {signal.unit} is assumed; it ranges from {low:.4g} to {high:.4g}"
        if signal.unit == "m" and max(abs(low), abs(high)) > _LONGEST_ROD_M:
            said += " (mm?)"
        out.append(said)
    plain_motion = not own.words & (_ROTOR | _ROD) and not _unit(own)
    if signal.name.startswith(("rod_", "rotor_")) and plain_motion:
        other = signal.name.replace("rod_", "rotor_")
        if other == signal.name:
            other = signal.name.replace("rotor_", "rod_")
        out.append(f"{signal.name}: the name leaves open whether it is {other}")
    if own.field.equal == 1.0:  # of references alone
        out.append(f"{signal.name}: never changes")
    return out
