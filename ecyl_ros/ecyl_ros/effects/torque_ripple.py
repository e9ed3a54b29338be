"""Torque ripple: a torque constant that varies over the rotor angle."""

from __future__ import annotations

from dataclasses import replace

from ..arrays import FloatArray
from ..drive.compiled import kernel
from .along import Along
from .effect import Effect, Evidence, Quantity, Start, phase
from .rigid_form import RigidForm, Stem
from .starts import over_rotor_turn
from .term import Fitted, Term, plain
from .waves import ORDER, nearest_order, once_per_turn, order_in, over_turn, parts, wave


def starts(evidence: Evidence) -> list[Start]:
    """The strongest lines of the unexplained torque, as shares of the motor's torque."""
    motor_torque = evidence.drive.motor.torque_constant * evidence.current_a
    lines = over_rotor_turn(evidence, motor_torque)
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
    share = over_turn(
        along,
        order,
        "fraction",
        ("fraction", "1"),
        effect="torque_ripple",
        key=f"ripple {order:.9g}",
        alternatives=once_per_turn(order, along.turn.name),
        moved=lambda fixed: term(along, order_in(along, fixed), effort),
        follows=True,
        of_effort=False,
        again=lambda left, values: term(along, order, left.explained),
    )
    return replace(share, columns=along.motion.quiet(effort) * share.columns)


def _void(fitted: Fitted) -> str:
    """With a ripple of more than itself a torque turns round within every wave: no motor's does."""
    beyond = fitted.spans[0].low > EFFECT.parameters[0].high
    return plain(fitted) or ("it would be more ripple than torque" if beyond else "")


RIGID = RigidForm(
    stems=(Stem("fraction", "share", 0.0, 1.0, "peak share of effort"), *ORDER),
    term=term,
    tried=lambda along, left: [(order, left.explained) for order in left.orders(left.explained)],
    shape=lambda along, values, effort: (values["wave"] / along.turn.rate, effort),
    coefficients=lambda values: parts(values["fraction"], values["phase"]),
    of_effort=True,
    several=True,
    like=lambda along, left, other: (*nearest_order(left, other), left.explained),
    twins=("cogging_torque", "periodic_disturbance"),
    void=_void,
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
