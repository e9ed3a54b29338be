"""The current over a step in which an effect at the inverter makes the winding's equation stiff.

Where a dead time's loss turns its sign, it acts on the current like a resistance of hundreds of
ohms: the current settles within microseconds, the mechanics do not. The current alone is therefore
taken over the step first, in pieces of its own, by an exponential Rosenbrock method of third order
(exprb32 of Hochbruck, Ostermann and Schweitzer, SIAM J. Numer. Anal. 47, 2009): what is linear
decays exactly, however fast, and pieces are short only where the loss bends on the way. The
mechanics then follow with that current.
"""

from __future__ import annotations

import math

from ..effects import learned, ports
from .compiled import called, kernel

# Error of a piece by the method of second order within, as a share of the current over which the
# loss changes; `tests/drive/test_stiff_current.py` holds the whole against much finer steps.
_TOLERANCE = 1e-3
_SHORTEST = 1e-4  # piece, as a share of the step
_SERIES = 0.5  # exponents below which differences of exponentials would cancel


@kernel
def _phis(z):
    """The integrals phi_1 to phi_4 of exp, phi_k = (phi_(k-1) - 1 / (k-1)!) / z."""
    if abs(z) > _SERIES:
        one = (math.exp(z) - 1.0) / z
        two = (one - 1.0) / z
        three = (two - 0.5) / z
        return one, two, three, (three - 1.0 / 6.0) / z
    term = four = 1.0 / 24.0
    for k in range(5, 15):
        term *= z / k
        four += term
    three = 1.0 / 6.0 + z * four
    two = 0.5 + z * three
    return 1.0 + z * two, two, three, four


@kernel
def _voltage(y, current, twist_torque, u_q, time, p):
    """What the winding sees of the command `u_q` at a current, V."""
    if p.learned_port == learned.INVERTER_VOLTAGE:
        angle, speed = (y[2], y[3]) if p.learned_on_load else (y[0], y[1])
        u_q += learned.law_value(p, angle, speed, current, twist_torque, u_q, time, y[8], y[9])
    return u_q + ports.inverter_voltage(p, current, u_q)


@called
def current_over(y, twist_torque, acceleration, jerk, u_q, step, time, p):
    """Current at the end of a step, and the one half way that gives Simpson's rule its mean, A.

    y: state at the beginning. acceleration, jerk: of the rotor, rad/s^2 and rad/s^3, as they would
    be with the current held.
    """
    per_inductance, emf = p.per_inductance, p.back_emf_constant * p.per_inductance
    per_ampere = p.torque_constant * p.per_rotor_inertia
    coupling = p.pole_pairs * y[1] * y[4]
    tolerance = _TOLERANCE * p.current_span
    current, speed, gone, area = y[5], y[1], 0.0, 0.0
    piece = step
    while step - gone > 1e-12 * step:
        piece = min(piece, step - gone)
        seen = _voltage(y, current, twist_torque, u_q, time + gone, p)
        lossy = ports.inverter_resistance(p, current, u_q)
        slope = (seen - p.resistance * current) * per_inductance - emf * speed - coupling
        faster = acceleration + jerk * gone + per_ampere * (current - y[5])
        bend = -emf * faster
        bend_rate = -emf * (jerk + per_ampere * slope)
        one, two, three, four = _phis(-(p.resistance + lossy) * per_inductance * piece)
        square = piece * piece
        ahead = current + piece * one * slope + square * (two * bend + piece * three * bend_rate)
        curved = per_inductance * (
            _voltage(y, ahead, twist_torque, u_q, time + gone, p) - seen + lossy * (ahead - current)
        )
        mended = 2.0 * piece * three * curved
        error = abs(mended)
        if error > tolerance and piece > _SHORTEST * step:
            piece *= max(0.1, 0.9 * math.sqrt(tolerance / error))
            continue
        taken = (
            piece * current
            + square * (two * slope + 2.0 * four * curved)
            + square * piece * (three * bend + piece * four * bend_rate)
        )
        speed += piece * (faster + 0.5 * jerk * piece) + per_ampere * (taken - piece * current)
        area += taken
        current = ahead + mended
        gone += piece
        if 8.0 * error < tolerance:
            piece *= 2.0
    return current, 0.25 * (6.0 * area / step - y[5] - current)
