"""A place on the stroke where the rod drags: dirt, a dent, a bent rod."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
from .along import Along
from .effect import Effect, Evidence, Quantity, Start, bristle, put_bristle
from .rigid_form import RigidForm, Stem, level
from .starts import direction
from .term import Fitted, Term, plain


def starts(evidence: Evidence) -> list[Start]:
    """The stretch of the stroke around the worst place on which the drag is above half of it."""
    ratio = evidence.drive.transmission.rod_per_rotor
    position = evidence.rotor_angle_rad * ratio
    drag = -evidence.torque_nm * direction(evidence)
    rows = np.isfinite(drag) & np.isfinite(position)
    if rows.sum() < 200:
        return []
    low, high = float(position[rows].min()), float(position[rows].max())
    found: list[Start] = []
    for count in (120, 40):
        edges = np.linspace(low, high, count + 1)
        bins = np.clip(np.digitize(position[rows], edges) - 1, 0, count - 1)
        held = np.bincount(bins, minlength=count)
        profile = np.bincount(bins, weights=drag[rows], minlength=count) / np.maximum(held, 1)
        profile[held < 5] = 0.0
        best = int(np.argmax(profile))
        above = profile > 0.5 * profile[best]
        first = last = best
        while first > 0 and above[first - 1]:
            first -= 1
        while last < count - 1 and above[last + 1]:
            last += 1
        width = float(edges[last + 1] - edges[first])
        found.append(
            {
                "coulomb_nm": max(float(np.median(profile[first : last + 1])), 1e-3),
                "position_m": float(0.5 * (edges[last + 1] + edges[first])),
                "width_m": width,
                "edge_m": 0.1 * width,
            }
        )
    return found


def place(values: Start) -> tuple[float, float]:
    """From where it has hardly set in to where it has all but gone."""
    middle, half = values["position_m"], 0.5 * values["width_m"] + values["edge_m"]
    return middle - half, middle + half


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Let the contact give as the bristle says."""
    put_bristle(record, "load", values)


EFFECT = Effect(
    name="local_jam",
    block="load",
    title="local jam",
    summary="The load drags at one place of the stroke and nowhere else, in both directions.",
    excitation="passes over the place in both directions and travel well beyond it",
    parameters=(
        Quantity(name="coulomb_nm", unit="N m", low=0.0, high=1e3, meaning="peak, at the rotor"),
        Quantity(name="position_m", unit="m", low=-10.0, high=10.0, meaning="of its middle"),
        Quantity(
            name="width_m", unit="m", low=1e-6, high=10.0, meaning="where it is above half its peak"
        ),
        Quantity(
            name="edge_m",
            unit="m",
            low=1e-7,
            high=10.0,
            meaning="length over which it sets in",
            default=1e-4,
            nuisance=True,
        ),
        *bristle("load"),
    ),
    starts=starts,
    modify=modify,
    refines=("load_coulomb_friction", "rotor_coulomb_friction"),
    place=place,
    rarity=2,
)


_EDGE = 0.1  # of its width, over which it sets in
_PLACE = 0.1  # of its width: the places along the travel that it is searched in
WIDEST = 0.4  # of the travel: what drags on more of it is the friction, and elsewhere there is less


def term(along: Along, middle: float, width: float) -> Term:
    """Drag against the motion on one part of a rigid drive's travel."""
    units, end = along.units, along.units.end
    distance = np.abs(along.motion.position - middle)
    inside = 0.5 * (1.0 - np.tanh((distance - 0.5 * width) / (_EDGE * width)))
    fixed = {f"position_{end}": middle, f"width_{end}": width}
    return Term(
        effect="local_jam",
        key=f"jam {middle:.6g} {width:.6g}",
        columns=(along.sign * inside)[None],
        parameters=lambda c: (
            (units.level("coulomb"), units.effort, float(c[0])),
            *((name, end, value) for name, value in fixed.items()),
        ),
        values=lambda c: {"coulomb": float(c[0]), "position": middle, "width": width},
        low=(0.0,),
        fixed=fixed,
        reach=dict.fromkeys(fixed, _PLACE * width),
        moved=lambda fixed: _of_travel(along, *fixed.values()),
    )


def _of_travel(along: Along, middle: float, width: float) -> Term:
    """The same on no more than a part of the travel."""
    travel = float(np.ptp(along.motion.position[along.motion.usable]))
    return term(along, middle, min(width, WIDEST * travel))


def _void(fitted: Fitted) -> str:
    """A place is part of a turn, and its both ends are seen; one that was passed once may as well
    have been a moment."""
    middle, width = fitted.term.fixed.values()
    if not fitted.along.machine.linear and width > math.tau:
        return "its place would be wider than a turn of the output"
    position = fitted.along.motion.position
    reach = (0.5 + _EDGE) * width
    if not position.min() < middle - reach < middle + reach < position.max():
        return "its place has an end that the motion does not reach: no jam by what was seen"
    inside = np.abs(position - middle) < 0.5 * width
    if np.count_nonzero(np.diff(inside, prepend=False) & inside) == 1:
        return "its place was passed once: a moment of the time would do as well"
    return plain(fitted)


RIGID = RigidForm(
    stems=(
        level("coulomb", "drag against the motion"),
        Stem("position", "position", -1e6, 1e6, "middle of the part"),
        Stem("width", "position", 1e-9, 1e6, "length of the part"),
    ),
    term=term,
    tried=lambda along, left: [found] if (found := left.window())[1] > 0.0 else [],
    void=_void,
    shape=lambda along, values, effort: (values["position"], values["width"]),
    coefficients=lambda values: (values["coulomb"],),
)


@kernel
def load_friction(p, speed, torque, angle, time):
    """Level: flat over the width, with soft edges."""
    if p.local_jam_coulomb_nm == 0.0:
        return 0.0
    distance = angle * p.rod_per_rotor - p.local_jam_position_m
    half = 0.5 * p.local_jam_width_m
    rise = math.tanh((distance + half) / p.local_jam_edge_m)
    fall = math.tanh((distance - half) / p.local_jam_edge_m)
    return 0.5 * p.local_jam_coulomb_nm * (rise - fall)


@kernel
def rigid_level(v, time, position, speed, acceleration):
    """Level: flat over the width, its edges in proportion to it; v: level, middle, width."""
    inside = (abs(position - v[1]) - 0.5 * v[2]) / (_EDGE * v[2])
    return 0.5 * v[0] * (1.0 - math.tanh(inside))
