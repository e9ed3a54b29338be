"""What the rotor drives is heavier or lighter than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..drive.parameters import DriveParameters
from ..drive.rigid.model import Model
from .along import Along
from .effect import Effect, Quantity
from .rigid_form import HUGE, RigidForm, Stem
from .starts import multiples
from .term import Fitted, Term, holds_nominal


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    record["per_load_inertia"] = 1.0 / values["inertia_kg_m2"]


EFFECT = Effect(
    name="load_inertia_error",
    block="load",
    title="wrong load inertia",
    summary="Torque in proportion to the load's acceleration, while the flanks are in contact.",
    excitation="acceleration",
    separated_by="passages through the backlash separate it from the rotor's inertia",
    parameters=(
        Quantity(
            name="inertia_kg_m2",
            unit="kg m^2",
            low=1e-9,
            high=100.0,
            meaning="true inertia of the load at the rotor",
        ),
    ),
    starts=multiples(
        "inertia_kg_m2", lambda evidence: evidence.drive.load.inertia, (0.5, 0.75, 1.5, 2.5)
    ),
    modify=modify,
    neutral=lambda drive: drive.load.inertia,
    constant="load.inertia",
)


def term(along: Along) -> Term:
    """The inertia of a rigid drive, which is that of its rotor where it turns."""
    model = along.model
    nominal = _nominal(model)
    name, unit = along.units.inertia
    bare = not (any(model.viscous) or any(model.coulomb) or model.constant)
    scaled = along.machine.gain not in (None, 1.0) and bare and along.known_inertia
    alike = ["torque_constant_error"] if scaled else []
    if along.one_frequency:
        alike.append("stiffness_error")
    return Term(
        effect=f"{along.side}_inertia_error",
        key="inertia",
        columns=along.motion.acceleration[None],
        carried=along.motion.acceleration[None],
        parameters=lambda c: ((name, unit, nominal + float(c[0])),),
        values=lambda c: {"inertia": float(c[0])},
        low=(-nominal,),
        inertia=1.0,
        alternatives=tuple(alike),
    )


def _void(fitted: Fitted) -> str:
    span = fitted.spans[0]
    if span.low <= 0.0:
        return f"its interval, {span.low:.3g} to {span.high:.3g}, holds 0"
    return holds_nominal(span, _nominal(fitted.along.model))


def _nominal(model: Model) -> float:
    """The file's, in the unit that effort is told in."""
    return (model.inertia or 0.0) / (model.ratio or 1.0) * (model.counted or 1.0)


RIGID = RigidForm(
    outputs=("linear",),
    stems=(Stem("inertia", "inertia", 1e-12, HUGE, "all that moves, in place of the nominal one"),),
    term=term,
    tried=lambda along, left: [()] if along.known_inertia else [],
    modify=lambda model, values: replace(
        model,
        inertia=(model.inertia or 0.0) + values["inertia"] - model.ratio * model.keys.inertia,
    ),
    constant=("load.mass", "load.inertia"),
    void=_void,
    merged=lambda old, new, along: {
        "inertia": new["inertia"]
        + old.get("inertia", along.model.counted * along.model.keys.inertia)
    },
)
