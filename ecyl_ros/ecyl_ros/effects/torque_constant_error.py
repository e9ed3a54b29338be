"""The motor gives more or less torque per ampere than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .along import Along
from .carried_load import carried_by_gain
from .effect import Effect, Quantity
from .rigid_form import HUGE, RigidForm, Stem, Values
from .starts import multiples
from .term import Term, holds_nominal


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    record["torque_constant"] = values["torque_constant_nm_per_a"]


EFFECT = Effect(
    name="torque_constant_error",
    block="motor_electrical",
    title="wrong torque constant",
    summary="Torque per ampere differs from the model's, in friction, acceleration and load alike.",
    excitation="high torque: acceleration or a known load",
    parameters=(
        Quantity(
            name="torque_constant_nm_per_a",
            unit="N m/A",
            low=1e-4,
            high=100.0,
            meaning="true torque constant",
        ),
    ),
    starts=multiples(
        "torque_constant_nm_per_a",
        lambda evidence: evidence.drive.motor.torque_constant,
        (0.6, 0.85, 1.2, 1.6),
    ),
    modify=modify,
    neutral=lambda drive: drive.motor.torque_constant,
    constant="motor.torque_constant",
)


def term(along: Along) -> Term:
    """Another gain of a rigid drive: what the file, and a known injection, ask, scaled."""
    ratio, gain = along.model.ratio, along.machine.gain or 1.0
    asked, inertia = along.of_gain()
    name, unit = along.units.gain(along.machine.actuation == "voltage")
    return Term(
        effect="torque_constant_error",
        key="gain",
        columns=asked[None],
        carried=carried_by_gain(along)[None],
        parameters=lambda c: ((name, unit, gain / (ratio + float(c[0]))),),
        values=lambda c: {"ratio": float(c[0])},
        low=(-0.9 * ratio or 1.0 / HUGE,),
        inertia=inertia,
        of_effort=False,
    )


def _told(along: Along) -> bool:
    """Whether the gain may be another than the file's, and something known tells it."""
    machine = along.machine
    if along.motion.injected.any() and machine.half_widths().get("actuation.gain", 0.0) > 0.0:
        return True
    # What was recorded as a force or torque needs no gain, and 1 says no more.
    scales = machine.gain != 1.0 or machine.actuation in ("current", "voltage")
    return machine.gain is not None and scales and along.known_inertia


def _merged(old: Values, new: Values, along: Along) -> Values:
    stem = "per_volt" if along.machine.actuation == "voltage" else "per_ampere"
    return {stem: (along.machine.gain or 1.0) / (along.model.ratio + new["ratio"])}


RIGID = RigidForm(
    stems=(
        Stem("per_ampere", "gain", 1e-9, HUGE, "true one", either=True),
        Stem("per_volt", "gain", 1e-9, HUGE, "true one", either=True),
    ),
    term=term,
    tried=lambda along, left: [()] if _told(along) else [],
    modify=lambda model, values: model,  # by its ratio
    ratio=lambda values, gain: gain / next(iter(values.values())),
    constant=("actuation.gain",) * 2,
    void=lambda fitted: holds_nominal(fitted.spans[0], fitted.along.machine.gain or 1.0),
    merged=_merged,
)
