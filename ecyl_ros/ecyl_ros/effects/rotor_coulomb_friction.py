"""Coulomb friction on the rotor: bearings, seals, brake."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
from . import load_coulomb_friction
from .effect import Effect, Evidence, Quantity, Start, bristle, put_bristle
from .starts import direction, regress


def starts(evidence: Evidence) -> list[Start]:
    """The step that the unexplained torque makes with the direction of motion."""
    level = -float(
        regress(evidence.torque_nm, direction(evidence), np.ones_like(evidence.time_s))[0]
    )
    return [{"coulomb_nm": max(level, 1e-4) * factor} for factor in (1.0, 0.4, 2.0)]


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Let the contact give as the bristle says."""
    put_bristle(record, "rotor", values)


EFFECT = Effect(
    name="rotor_coulomb_friction",
    block="motor_mechanical",
    title="Coulomb friction on the rotor",
    summary="A torque of constant size against the rotor's motion; the rotor sticks at reversals, "
    "in the backlash too, where the load does not act.",
    excitation="reversals, some of them slow",
    separated_by="the backlash separates it from friction on the load",
    parameters=(
        Quantity(
            name="coulomb_nm", unit="N m", low=0.0, high=1e3, meaning="friction torque at the rotor"
        ),
        *bristle("rotor"),
    ),
    starts=starts,
    modify=modify,
)


# A drive of one inertia that turns has on its rotor what a straight one has on its load.
RIGID = replace(load_coulomb_friction.RIGID, outputs=("rotary",))


@kernel
def rotor_friction(p, speed, torque, time):
    """Level: constant."""
    return p.rotor_coulomb_friction_coulomb_nm
