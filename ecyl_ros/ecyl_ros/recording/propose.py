"""A map proposed from the names that topics, joints, fields and columns bear."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

from .axis import Axis, axis_of, open_to_doubt
from .candidates import (
    Candidate,
    candidates_of,
    counted,
    in_si,
    quantity_of,
    told_of,
    unit_told,
)
from .headers import bare, ending
from .map import MAPPED, MappedSignal, SignalMap
from .mapped import contract_map
from .names import (
    ASKED,
    ENCODERS,
    FORCE,
    INJECTED,
    MEASURED,
    NO_SIGNAL,
    QUANTITY,
    ROD,
    ROTOR,
    SUPPLY,
    TIMED,
    TORQUE,
)
from .names import words as words_of
from .survey import Survey
from .units import UNITS, dimension_of, plain, unknown_unit

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
_ENCODER_BITS = range(10, 25)
_SHOWN = 6  # names in one remark


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
    candidates = [one for topic in survey.topics for one in candidates_of(topic)]
    candidates, remark = _one_joint(candidates)
    remarks += remark
    candidates, remark = _without_raw(candidates)
    remarks += remark
    axis = axis_of(candidates)
    chosen: dict[str, MappedSignal] = {}
    scores: dict[str, float] = {}
    doubts: dict[str, list[str]] = {}
    for one in candidates:
        found = _signal(one, axis)
        if found is None:
            continue
        signal, score = found
        doubt, signal = _counts(one, signal)
        unknown = told_of(one)
        if unknown and dimension_of(plain(unknown)) is None:
            doubt = f"{one.path} is left out: {unknown_unit(unknown)}"
        if doubt:
            doubts.setdefault(signal.name, []).append(doubt)
            continue
        if score > scores.get(signal.name, 0.0):
            chosen[signal.name], scores[signal.name] = signal, score
    remarks += _without_supply(chosen, candidates)
    if "effort" in chosen and "current_q" in chosen and chosen["effort"].unit == "A":
        del chosen["effort"]
    targets: dict[str, str] = {}
    for name in [name for name in MAPPED if name in chosen]:
        if chosen[name].target in targets:
            del chosen[name]
            continue
        targets[chosen[name].target] = name
    remarks += [doubt for name, own in doubts.items() if name not in chosen for doubt in own[:3]]
    if not chosen:
        return Proposal(None, tuple(remarks) if doubts else (_by_hand(survey, candidates),))
    remarks += _against(chosen, candidates)
    for name in MAPPED:
        if name in chosen:
            remarks += _remarks(chosen[name], candidates, axis)
    remarks += _unread(chosen, candidates, survey)
    if not any(name.startswith("reference_") for name in chosen):
        remarks.append("no reference: without one the controller's part cannot be replayed")
    time = None
    if survey.kind in ("CSV", "MAT"):
        if survey.time is None:
            remarks.append("no column has a name of time: time or rate has to be added")
        else:
            time = survey.time
            remarks += survey.time_remarks
    ordered = tuple(chosen[name] for name in MAPPED if name in chosen)
    return Proposal(SignalMap(survey.path, ordered, time), tuple(remarks))


def _by_hand(survey: Survey, candidates: list[Candidate]) -> str:
    """What to write where names say nothing; a field that moves stands for a position."""
    text = "no field has a name that says which signal it is"
    clock = survey.time
    moves = [
        one
        for one in candidates
        if one.field.equal < 1.0 and (clock is None or one.path != clock.field)
    ]
    if not moves:
        return text
    first = moves[0]
    where = f"topic: {first.topic.name}, " if first.topic.name else ""
    time = f"time: {{field: {clock.field}, unit: {clock.unit}}}, " if clock is not None else ""
    return (
        f"{text}. Write a map that does, as {{schema: ecyl.map/1, {time}signals: {{rotor_position: "
        f"{{{where}field: {first.path}, unit: rad}}}}}}, and try it with --map"
    )


def _unread(
    chosen: dict[str, MappedSignal], candidates: list[Candidate], survey: Survey
) -> list[str]:
    """Fields beside the chosen signals that change and whose names say nothing: one of them may
    be the effort."""
    clock = survey.time.field if survey.time is not None else ""
    topics = {one.topic for one in chosen.values()}
    unread = [
        one.path
        for one in candidates
        if one.topic.name in topics
        and one.field.equal < 1.0
        and one.path != clock
        and quantity_of(one) is None
        and not one.words & (NO_SIGNAL | TIMED | ENCODERS)
        and dimension_of(unit_told(one)) not in _MEASURED
    ]
    if not unread:
        return []
    more = f" and {len(unread) - _SHOWN} more" if len(unread) > _SHOWN else ""
    return [
        f"{', '.join(unread[:_SHOWN])}{more}: the name says no signal; if one is, as an effort "
        "may be, add it to the map by hand"
    ]


def _one_joint(candidates: list[Candidate]) -> tuple[list[Candidate], list[str]]:
    """Of several joints the one that moves most, of those with an effort if any has one: a drive
    is diagnosed by itself."""
    spread: dict[str, dict[str, float]] = {}  # of each quantity, at each place
    driven: set[str] = set()
    for one in candidates:
        if one.place and one.words & QUANTITY.keys():
            quantity = quantity_of(one) or ""
            at = spread.setdefault(quantity, {})
            at[one.place] = max(at.get(one.place, 0.0), one.field.std)
            if quantity in ("effort", "current_q"):
                driven.add(one.place)
    places = {place for at in spread.values() for place in at}
    # A rotor and a rod are two joints of one drive.
    if len(places) < 2 or any(words_of(place) & (ROTOR | ROD) for place in places):
        return candidates, []
    moved = dict.fromkeys(places, 0.0) | _travelled(spread)
    best = max(moved, key=lambda place: (place in driven, moved[place]))
    others = f"{', '.join(sorted(moved)[:12])}: the others are left out"
    remark = f"joint {best} moves most of {others}"
    if moved[best] < max(moved.values()):
        remark = f"joint {best} moves most of those with an effort, of {others}"
    return [one for one in candidates if one.place in ("", best)], [remark]


def _travelled(spread: Mapping[str, dict[str, float]]) -> dict[str, float]:
    """How much each joint moves, in the one quantity that most have; a position before a speed, and
    these before what is no travel.

    spread: standard deviations by quantity and joint.
    """
    travel = [spread[name] for name in ("position", "velocity") if name in spread]
    return max([*travel, *spread.values()], key=len)


def _without_raw(candidates: list[Candidate]) -> tuple[list[Candidate], list[str]]:
    """Leave out the volts of a sensor whose reading stands beside them under the same
    name: `laser_V` beside `laser_mm`."""
    read = {
        _stem(one): one
        for one in candidates
        if dimension_of(unit_told(one)) not in (None, "voltage")
    }
    raw = {
        one.path: read[_stem(one)].path
        for one in candidates
        if dimension_of(unit_told(one)) == "voltage" and _stem(one) in read
    }
    remarks = [f"{path} is left out: {read} is the same in its unit" for path, read in raw.items()]
    return [one for one in candidates if one.path not in raw], remarks


def _stem(one: Candidate) -> tuple[str, str]:
    """What a field is called without its unit, and the topic it is of."""
    name = bare(one.path)
    if name == one.path and "_" in name and ending(name):
        name = name.rpartition("_")[0]
    return one.topic.name, name.lower()


def _without_supply(chosen: dict[str, MappedSignal], candidates: list[Candidate]) -> list[str]:
    """Leave out a voltage that stays while the motor stops or turns back: a supply's."""
    speeds = [chosen[name] for name in ("rotor_velocity", "rod_velocity") if name in chosen]
    if "voltage_q" not in chosen or not speeds:
        return []
    speed = _candidate(speeds[0], candidates).field
    supplied = _candidate(chosen["voltage_q"], candidates)
    low, high = sorted((abs(supplied.field.low), abs(supplied.field.high)))
    same_sign = supplied.field.low * supplied.field.high > 0.0
    if not (speed.low <= 0.0 <= speed.high and same_sign and low > 0.5 * high):
        return []
    del chosen["voltage_q"]
    return [
        f"{supplied.path} ({supplied.field.low:.4g} to {supplied.field.high:.4g}) is left out: it "
        "stays when the motor stops, as a supply's voltage does"
    ]


def _against(chosen: dict[str, MappedSignal], candidates: list[Candidate]) -> list[str]:
    """Turn the sign of a measured position whose range mirrors the reference's."""
    out = []
    for body in ("rod", "rotor"):
        reference, measured = chosen.get("reference_position"), chosen.get(f"{body}_position")
        if reference is None or measured is None:
            continue
        if reference.dimension != measured.dimension or reference.wrap or measured.wrap:
            continue
        asked, found = (
            (one.unit_si * own.low, one.unit_si * own.high)
            for one in (reference, measured)
            for own in (_candidate(one, candidates).field,)
        )
        straight = abs(found[0] - asked[0]) + abs(found[1] - asked[1])
        mirrored = abs(found[0] + asked[1]) + abs(found[1] + asked[0])
        if mirrored < 0.2 * straight:
            chosen[measured.name] = dataclasses.replace(measured, sign=-1)
            out.append(f"{measured.name}: its range mirrors the reference's, so sign -1")
    return out


def _candidate(signal: MappedSignal, candidates: list[Candidate]) -> Candidate:
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


def _signal(one: Candidate, axis: Axis) -> tuple[MappedSignal, float] | None:
    words = one.words
    if words & NO_SIGNAL:
        return None
    asked = bool(words & ASKED)
    if one.field.equal == 1.0 and not asked:  # never changes: not connected
        return None
    own = words_of(bare(one.field.path))
    unit = unit_told(one)
    quantity = quantity_of(one)
    if words & INJECTED and quantity == "effort":
        torque = bool(words & TORQUE) or dimension_of(unit) == "torque"
        quantity = "injected_torque" if torque else "injected_force"
    if quantity is None and unit:
        quantity = _MEASURED.get(dimension_of(unit) or "")
        if quantity == "voltage_q" and any(word.endswith("sensor") for word in words):
            return None
    if quantity is None and words & ENCODERS:
        quantity = (
            "velocity" if dimension_of(plain(told_of(one))) == "counts per second" else "position"
        )
    if quantity is None or (words & SUPPLY and quantity.startswith(("current", "voltage"))):
        return None
    score = 1.0 + 0.5 * bool(unit) + 0.5 * (one.field.equal < 1.0) + 0.2 * bool(one.joint)
    score += 0.1 * bool(words & MEASURED)
    name: str
    if quantity in ("position", "velocity"):
        if asked:
            name = f"reference_{quantity}"
            score += 0.5 * bool(own & ASKED)
        else:
            name = f"{axis.body(one)}_{quantity}"
            score += 0.3 * bool(words & (ROTOR | ROD))
    else:
        name = quantity
        # What the drive measured of its effort says more than what it was told.
        score += 0.3 * (not asked)
    dimensions = MAPPED[name]
    if unit and dimension_of(unit) not in dimensions:
        return None
    if not unit:
        unit = _usual_unit(name, one, axis)
    dimension = dimension_of(unit) or next(iter(dimensions))
    signal = MappedSignal(name, dimensions[dimension], one.path, one.topic.name, one.joint, unit)
    wrap = one.field.wrap
    if wrap is not None and (dimension in ("length", "angle") or wrap.wrap.signed):
        degrees = {360.0: 1.0, 3600.0: 0.1, 36000.0: 0.01}.get(wrap.wrap.period)
        turn = math.isnan(wrap.wrap.period) or degrees is not None
        if turn and "angle" in dimensions and not unit_told(one):  # what turns so is an angle
            unit, target = ("deg" if degrees else "rad"), dimensions["angle"]
            signal = dataclasses.replace(signal, unit=unit, target=target, scale=degrees or 1.0)
            signal = dataclasses.replace(signal, wrap=wrap.wrap)
        elif not turn or dimension == "angle":
            signal = dataclasses.replace(signal, wrap=wrap.wrap)
    return signal, score


def _counts(one: Candidate, signal: MappedSignal) -> tuple[str, MappedSignal]:
    """A position or speed in counts: with what they are worth, where that shows; else a doubt."""
    if signal.dimension not in ("length", "angle", "speed", "angular speed") or not counted(one):
        return "", signal
    unit = "counts" if signal.dimension in ("length", "angle") else "counts/s"
    wrap = one.field.wrap
    bits = None if wrap is None or wrap.wrap.signed else math.log2(wrap.wrap.period)
    turning = "rotor_position" in (signal.name,) or one.words & ROTOR
    if wrap is not None and bits in _ENCODER_BITS and bits != 16 and turning and unit == "counts":
        turn = round(wrap.wrap.period)
        target = MAPPED[signal.name]["angle"]
        known = dataclasses.replace(signal, unit=unit, counts_per_rev=float(turn), target=target)
        return "", known
    worth = "counts_per_rev" if signal.dimension.startswith("ang") else "counts_per_m"
    or_rpm = " or in rpm" if signal.dimension == "angular speed" else ""
    with_rpm = f", or {{field: {one.path}, unit: rpm}}" if or_rpm else ""
    return (
        f"{signal.name}: {one.path} ({one.field.low:.6g} to {one.field.high:.6g}) is in counts"
        f"{or_rpm}, as it seems, and is left out: add {{field: {one.path}, unit: {unit}, {worth}: "
        f"N}}{with_rpm}",
        signal,
    )


def _usual_unit(name: str, one: Candidate, axis: Axis) -> str:
    if name == "effort":
        pushes = one.words & FORCE or (axis.pushes and not one.words & (TORQUE | ROTOR))
        return "N" if pushes else "N m"
    dimensions = [one for one in MAPPED[name] if one in UNITS]
    if axis.turns:  # a reference may be either
        dimensions.sort(key=lambda one: not one.startswith("ang"))
    return next(iter(UNITS[dimensions[0]]))


def _remarks(signal: MappedSignal, candidates: list[Candidate], axis: Axis) -> list[str]:
    out = []
    own = _candidate(signal, candidates)
    if own.field.wrap is not None:
        out.append(f"{signal.name}: {own.field.wrap.text}")
    if signal.counts_per_rev is not None:
        out.append(
            f"{signal.name}: {signal.counts_per_rev:g} counts per revolution are guessed from "
            "where it wraps around"
        )
        return out
    if not unit_told(own) and not in_si(own.topic.type):
        low, high = own.field.low, own.field.high
        by_axis = open_to_doubt(own) and quantity_of(own) in ("position", "velocity")
        by_axis |= signal.unit == "N" and not own.words & FORCE
        why = f", for {axis.because}" if by_axis and axis.because else ""
        said = f"{signal.name}: {signal.unit} is assumed{why}; "
        said += f"it ranges from {low:.4g} to {high:.4g}"
        if signal.unit == "m" and max(abs(low), abs(high)) > _LONGEST_ROD_M:
            said += " (mm?)"
        out.append(said)
    if signal.name.startswith(("rod_", "rotor_")) and open_to_doubt(own) and not axis.sure:
        other = signal.name.replace("rod_", "rotor_")
        if other == signal.name:
            other = signal.name.replace("rotor_", "rod_")
        out.append(f"{signal.name}: the name leaves open whether it is {other}")
    if own.field.equal == 1.0:  # of references alone
        out.append(f"{signal.name}: never changes")
    return out
