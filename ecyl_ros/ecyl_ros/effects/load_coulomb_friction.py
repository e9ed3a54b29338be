"""Coulomb friction behind the clearance: screw, nut, guide, rod seal."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
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
    put_bristle(record, "load", values)


EFFECT = Effect(
    name="load_coulomb_friction",
    block="load",
    title="Coulomb friction on the load",
    summary="A torque of constant size against the load's motion; the load stays where it is while "
    "the rotor crosses the clearance.",
    excitation="reversals, some of them slow; the clearance tells it from the rotor's",
    parameters=(
        Quantity(
            name="coulomb_nm", unit="N m", low=0.0, high=1e3, meaning="friction torque at the rotor"
        ),
        *bristle("load"),
    ),
    starts=starts,
    modify=modify,
)


@kernel
def load_friction(p, speed, torque, angle, time):
    """Level: constant."""
    return p.load_coulomb_friction_coulomb_nm
