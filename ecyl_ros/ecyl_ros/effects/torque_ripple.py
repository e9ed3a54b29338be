"""Torque ripple: a torque constant that varies over the rotor angle."""

from __future__ import annotations

import numpy as np

from ..drive.compiled import kernel
from .along import Along
from .effect import Effect, Evidence, FloatArray, Quantity, Start, phase
from .rigid_form import RigidForm, Stem, Values
from .starts import angular_orders, strongest
from .term import Left, Term
from .waves import ORDER, extent, order_parameters, parts, polar, quadratures, shown, size, wave


def starts(evidence: Evidence) -> list[Start]:
    """The strongest lines of the unexplained torque, as shares of the motor's torque."""
    angle = evidence.rotor_angle_rad
    motor_torque = evidence.drive.motor.torque_constant * evidence.current_a
    lines = strongest(evidence.torque_nm, angle, angular_orders(angle, 96.0), 4, motor_torque)
    return [
        {"fraction": min(share, 1.0), "periods_per_rev": order, "phase_rad": shift}
        for order, share, shift in lines
    ]


EFFECT = Effect(
    name="torque_ripple",
    block="motor_mechanical",
    title="torque ripple",
    summary="The motor's torque per ampere varies with the rotor angle: ripple that grows with "
    "the torque and vanishes without it.",
    excitation="high torque while the rotor turns over several periods",
    parameters=(
        Quantity(
            name="fraction", unit="1", low=0.0, high=1.0, meaning="peak share of the motor's torque"
        ),
        Quantity(
            name="periods_per_rev", unit="1", low=0.9, high=1e3, meaning="periods per rotor turn"
        ),
        phase("of the sine at rotor angle zero"),
    ),
    starts=starts,
    rarity=2,
)


def term(along: Along, order: float, effort: FloatArray) -> Term:
    """A sine of a rigid drive's position times `effort`, float64[n]: what is explained so far.

    Not what was measured, which holds what is to be explained.
    """
    turn = along.turn
    phase_rad = order * turn.angle
    return Term(
        effect="torque_ripple",
        key=f"ripple {order:.9g}",
        columns=effort * quadratures(phase_rad),
        parameters=lambda c: (("fraction", "1", size(c)), *order_parameters(along, order)),
        values=lambda c: polar("fraction", c) | {"wave": order * turn.rate},
        low=(-np.inf, -np.inf),
        fixed={turn.name: shown(along, order)},
        extent=extent(along, order),
        rate=order,
        phase=phase_rad,
        follows=True,
        again=lambda explained: term(along, order, explained),
    )


def _candidates(along: Along, left: Left) -> list[Term]:
    return [term(along, order, left.explained) for order in left.orders(left.explained)]


def _like(along: Along, left: Left, other: Term) -> Term | None:
    order = left.nearest(other, False) if other.over_time else other.rate
    return term(along, order, left.explained) if order > 0.0 else None


def _asked(along: Along, values: Values, effort: FloatArray) -> FloatArray:
    columns = term(along, values["wave"] / along.turn.rate, effort).columns
    made: FloatArray = parts(values["fraction"], values["phase"]) @ columns
    return made


RIGID = RigidForm(
    stems=(Stem("fraction", "share", 0.0, 1.0, "peak share of effort"), *ORDER),
    candidates=_candidates,
    asked=_asked,
    of_effort=True,
    several=True,
    like=_like,
    twins=("cogging_torque", "periodic_disturbance"),
)


@kernel
def rotor_torque(p, angle, speed, current):
    """The motor's torque times a sine of the rotor angle."""
    if p.torque_ripple_fraction == 0.0:
        return 0.0
    share = wave(
        p.torque_ripple_fraction,
        p.torque_ripple_periods_per_rev,
        p.torque_ripple_phase_rad,
        angle,
    )
    return p.torque_constant * current * share


@kernel
def rigid_share(v, position):
    """A sine of the position; v: fraction, rad per m or rad, phase."""
    return wave(v[0], v[1], v[2], position)
