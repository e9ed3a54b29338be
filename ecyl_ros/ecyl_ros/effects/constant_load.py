"""A constant force on the rod: gravity, a hanging mass, a preload."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..drive.compiled import kernel
from .along import Along
from .effect import Effect, Evidence, Quantity, Start
from .rigid_form import HUGE, RigidForm, Stem, added
from .starts import direction, regress
from .term import Term


def starts(evidence: Evidence) -> list[Start]:
    """The mean of the unexplained torque, and the other sign: the load seats on one flank."""
    both = regress(evidence.torque_nm, np.ones_like(evidence.time_s), direction(evidence))
    force = -float(both[0]) / evidence.drive.transmission.rod_per_rotor
    force = force if abs(force) > 1e-6 else 1.0
    return [{"force_n": force * factor} for factor in (1.0, 0.3, 2.0, -1.0)]


EFFECT = Effect(
    name="constant_load",
    block="load",
    title="constant load",
    summary="A force of constant size and direction: the current has an offset, and the "
    "transmission keeps to one flank where inertia does not lift it off.",
    excitation="motion in both directions",
    separated_by="passages through the backlash distinguish it from a current offset",
    parameters=(
        Quantity(
            name="force_n",
            unit="N",
            low=-1e6,
            high=1e6,
            meaning="on the rod, positive against positive motion",
        ),
    ),
    starts=starts,
    rarity=1,
)


def offsets(along: Along) -> tuple[str, ...]:
    """What an effort that does not change looks like where a current is measured at all."""
    read = along.machine.actuation in ("current", "loop") or along.units.effort == "A"
    return ("current_sensor_offset",) if read else ()  # a loop has one inside


def term(along: Along) -> Term:
    """A constant effort; where the motion goes one way only, friction looks the same."""
    units = along.units
    rubs = () if along.both_ways else (f"{along.side}_coulomb_friction",)
    return Term(
        effect="constant_load",
        key="constant",
        columns=along.one[None],
        carried=along.one[None],
        parameters=lambda c: ((units.load, units.effort, float(c[0])),),
        values=lambda c: {"load": float(c[0])},
        low=(-math.inf,),
        alternatives=(*rubs, *offsets(along)),
        mean=True,
    )


RIGID = RigidForm(
    stems=(Stem("load", "load", -HUGE, HUGE, "positive against positive motion"),),
    term=term,
    modify=lambda model, values: replace(model, constant=model.constant + values["load"]),
    constant=("load.constant_load",) * 2,
    on_top=True,
    merged=added,
)


@kernel
def load_torque(p, time, angle, speed):
    """The force over the lead."""
    return -p.constant_load_force_n * p.rod_per_rotor
