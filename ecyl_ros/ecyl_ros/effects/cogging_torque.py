"""Cogging: torque of the magnets against the slots, over the rotor angle."""

from __future__ import annotations

import numpy as np

from ..drive.compiled import kernel
from .along import Along
from .effect import Effect, Evidence, Quantity, Start, phase
from .rigid_form import HUGE, RigidForm, Stem
from .starts import over_rotor_turn
from .term import Left, Term
from .waves import ORDER, nearest_order, once_per_turn, order_in, over_turn, parts, wave


def starts(evidence: Evidence) -> list[Start]:
    """The strongest lines of the unexplained torque over the rotor angle."""
    lines = over_rotor_turn(evidence, np.ones_like(evidence.rotor_angle_rad))
    return [
        {"amplitude_nm": height, "periods_per_rev": order, "phase_rad": shift}
        for order, height, shift in lines
    ]


EFFECT = Effect(
    name="cogging_torque",
    block="motor_mechanical",
    title="cogging torque",
    summary="A torque that repeats with rotor angle, independent of current: ripple at a "
    "frequency in proportion to speed, largest in effect at low speed.",
    excitation="slow motion over several periods of the slots",
    parameters=(
        Quantity(name="amplitude_nm", unit="N m", low=0.0, high=1e3, meaning="peak torque"),
        Quantity(
            name="periods_per_rev", unit="1", low=0.9, high=1e3, meaning="periods per rotor turn"
        ),
        phase("of the sine at rotor angle zero"),
    ),
    starts=starts,
)


# The least of a motor: the least common multiple of slots and poles (Hanselman, "Brushless
# permanent magnet motor design", 2003), of three slots and two poles.
_LOWEST = 6.0


def term(along: Along, order: float) -> Term:
    """A sine of a rigid drive's position."""
    units = along.units
    return over_turn(
        along,
        order,
        "amplitude",
        (units.level("amplitude"), units.effort),
        effect="cogging_torque",
        key=f"cogging {order:.9g}",
        alternatives=once_per_turn(order, along.turn.name),
        moved=lambda fixed: term(along, order_in(along, fixed)),
    )


def _like(along: Along, left: Left, other: Term) -> tuple[float]:
    """On an arc of a small part of its period it is what the weight of an arm is there."""
    return (_LOWEST,) if other.effect == "gravity_on_arm" else nearest_order(left, other)


RIGID = RigidForm(
    stems=(Stem("amplitude", "level", 0.0, HUGE, "peak"), *ORDER),
    term=term,
    tried=lambda along, left: [(order,) for order in left.orders(None)],
    shape=lambda along, values, effort: (values["wave"] / along.turn.rate,),
    coefficients=lambda values: parts(values["amplitude"], values["phase"]),
    several=True,
    like=_like,
    twins=("torque_ripple", "periodic_disturbance"),
)


@kernel
def rotor_torque(p, angle, speed, current):
    """A sine of the rotor angle."""
    if p.cogging_torque_amplitude_nm == 0.0:
        return 0.0
    return wave(
        p.cogging_torque_amplitude_nm,
        p.cogging_torque_periods_per_rev,
        p.cogging_torque_phase_rad,
        angle,
    )


@kernel
def rigid_load(v, time, position):
    """A sine of the position; v: amplitude, rad per m or rad, phase."""
    return wave(v[0], v[1], v[2], position)
