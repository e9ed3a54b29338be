"""What the noise of the recorded signals comes to within the band, as an effort."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np

from ...arrays import FloatArray
from ...drive.rigid.loop import gains_of
from ...drive.rigid.machine import Machine
from ...effects.along import UNMODELLED
from .balance import Blur
from .band import DERIVATIVE, ORDER, slope_gain
from .grid import bridged, eroded
from .motion import Motion
from .solution import Solution
from .terms import Catalogue
from .white import least_density

_LONGEST = 20.0  # periods of the weight in a recording, at the least
_LEFT = 0.7  # of the samples have to be left once it has settled
_POINTS = 2000  # of an integral over frequency


def effort_noise(motion: Motion, stated: float | None = None) -> float:
    """Standard deviation of the effort's white noise within the band.

    stated: of a sample, in the unit of the motion's effort; None: from above the band.
    """
    if stated is not None:
        density = stated**2 / (0.5 * motion.rate_hz)
    else:
        density = least_density(motion.effort, motion.usable, motion.rate_hz, motion.bandwidth_hz)
    return math.sqrt(
        density * 0.5 * motion.rate_hz * float(np.mean(motion.gain(_grid(motion)) ** 2))
    )


def acceleration_noise(motion: Motion, *, counted: bool = False, rounded: bool = False) -> float:
    """Standard deviation of the acceleration's noise within the band.

    White noise of the position (of the speed, where acceleration comes from a recorded one), as
    dense as above the band, through differences and low-passes. counted: no less than all noise of
    the position makes of it. rounded: no less than rounding to counts does, which is not white
    while it moves slowly.
    """
    rate, band = motion.rate_hz, motion.bandwidth_hz
    order, density = _rounded_density(motion) if rounded else _motion_density(motion)
    if counted:
        spread = motion.position_noise**2 / (0.5 * rate)
        density = max(density, spread * (math.tau * band) ** 2 if motion.by_speed else spread)
    frequency = _grid(motion)
    gain = slope_gain(frequency, rate) ** order
    cutoff = min(DERIVATIVE * band, 0.45 * rate)
    gain *= motion.gain(frequency) / (1.0 + (frequency / cutoff) ** (2 * ORDER))
    return math.sqrt(density * float(np.mean(gain**2)) * 0.5 * rate)


def weighed(motion: Motion, inertia: float) -> Motion:
    """The motion with its `weight_hz`, for an output of `inertia` in the unit of its effort.

    Noise of the position grows with the square of the frequency on its way to an effort, and swamps
    what else could be seen in a wide band. Where it overtakes noise of the effort, and what no
    model explains, all that is compared is turned down with it.
    """
    usable = motion.usable
    if not (inertia > 0.0 and usable.any()):
        return motion
    order, density = _motion_density(motion)
    own = least_density(motion.effort, usable, motion.rate_hz, motion.bandwidth_hz)
    own += (UNMODELLED * float(np.std(motion.effort[usable]))) ** 2 / motion.bandwidth_hz
    rise = inertia * math.sqrt(max(density, 1e-300))  # times (2 pi f) to the order
    hertz = (math.sqrt(own) / rise) ** (1.0 / order) / math.tau
    hertz = max(hertz, _LONGEST * motion.rate_hz / motion.time_s.size)
    while hertz < motion.bandwidth_hz:
        made = in_lower_band(motion, hertz)
        if made is not None:
            return made
        hertz *= 2.0  # it costs too much to let the filter settle: a shorter one
    return motion


def in_lower_band(motion: Motion, hertz: float) -> Motion | None:
    """The motion weighed down beyond a frequency; None where the recording is too short for it, or
    too little is left once the filter has settled at ends and gaps."""
    if hertz < _LONGEST * motion.rate_hz / motion.time_s.size:
        return None
    left = eroded(motion.usable, math.ceil(motion.rate_hz / hertz))
    if left.sum() < _LEFT * motion.usable.sum():
        return None
    return replace(motion, weight_hz=hertz, usable=left)


def blur_of(motion: Motion, machine: Machine, inertia: float) -> Blur:
    """Noise of the acceleration that regressions have to be freed of."""
    return Blur(
        acceleration_noise(motion),
        acceleration_noise(motion, counted=True),
        functools.partial(round_the_loop, motion, machine, inertia),
    )


def _motion_density(motion: Motion) -> tuple[int, float]:
    """Differences from what was measured to the acceleration; least density of its noise."""
    order, values = 2, motion.raw_position
    if motion.by_speed:
        order, values = 1, bridged(motion.recorded_velocity, np.isfinite(motion.recorded_velocity))
    return order, least_density(values, motion.usable, motion.rate_hz, motion.bandwidth_hz, order)


def _rounded_density(motion: Motion) -> tuple[int, float]:
    """The same, no less than as rounding of the position to counts is on average."""
    order, density = _motion_density(motion)
    if order == 2:
        density = max(density, motion.rounding**2 / (0.5 * motion.rate_hz))
    return order, density


def _grid(motion: Motion) -> FloatArray:
    return np.linspace(0.0, 0.5 * motion.rate_hz, _POINTS)


def measurement_noise(catalogue: Catalogue, fit: Solution) -> float:
    """Standard deviation that noise of effort and motion leaves of the balance.

    fit: of a set that tells the inertia where the file does not.
    """
    motion, machine = catalogue.motion, catalogue.machine
    stated = machine.effort_noise
    if stated is not None and machine.gain is not None and catalogue.units.own:
        stated *= machine.gain
    inertia = fit.inertia(catalogue.model)
    if machine.actuation == "loop":
        return _through_the_loop(motion, machine, inertia)
    return math.hypot(
        effort_noise(motion, stated), inertia * acceleration_noise(motion, rounded=True)
    )


def _through_the_loop(motion: Motion, machine: Machine, inertia: float) -> float:
    """What noise of the position leaves where the loop that it went through is the effort."""
    order, density = _rounded_density(motion)
    if order == 1:
        return math.hypot(effort_noise(motion), inertia * acceleration_noise(motion))
    gains, frequency = gains_of(machine), _grid(motion)
    turn = 1j * math.tau * frequency
    passed = gains.speed_kp * (gains.position_kp + turn) + inertia * turn**2
    power = float(np.mean(np.abs(passed * motion.gain(frequency)) ** 2))
    return math.sqrt(density * power * 0.5 * motion.rate_hz)


def round_the_loop(motion: Motion, machine: Machine, inertia: float, delay_s: float) -> float:
    """Covariance of what noise of the position leaves with the column of a delay.

    Noise n that a loop C sees moves the output, so that n / (1 + L) is measured, L = C / (M s^2).
    The effort is the loop's answer to that, exactly, and M s^2 n is left. A delay's column is what
    the measured motion asks for, ahead of itself: about the loop's bandwidth one cancels the other.
    """
    order, density = _motion_density(motion)
    if machine.actuation != "loop" or order == 1:
        return 0.0
    gains, frequency = gains_of(machine), _grid(motion)[1:]
    turn = 1j * math.tau * frequency
    loop = (gains.speed_kp + gains.speed_ki / turn) * (gains.position_kp + turn)
    asked = inertia * turn**2
    column = np.expm1(turn * delay_s) / delay_s * asked**2 / (asked + loop)
    shared = np.real(np.conj(column) * -asked) * motion.gain(frequency) ** 2
    return density * float(np.mean(shared)) * 0.5 * motion.rate_hz
