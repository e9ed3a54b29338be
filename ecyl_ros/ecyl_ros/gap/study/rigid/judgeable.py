"""Whether a recording can show a fault: what it adds to the effort, over all that hides it.

The fault's effort along the motion is freed of what other faults or an uncertain sheet give as
well (a constant load, friction, inertia, a spring, a shift in time), and compared with noise in the
band of frequencies that shows it best.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.signal import butter, sosfiltfilt

from ....arrays import FloatArray
from .demand import demand
from .drawn import Drawn
from .equations import Truth
from .motion import LOOP_HZ

SHOWS = 3.0  # times the noise in the band that a fault's effort must reach, RMS
_BANDS_HZ = (3.0, 6.0, 12.0, 25.0, 50.0, 100.0)
_BOTH_WAYS = 0.1  # share of the motion in either direction, for friction that tells them apart
_MOVES = 0.02  # of the top speed: below it a machine is at rest
_EVERY = 5  # ticks of the loop from one sample of this judgement to the next

# What is not taken out of a fault's effort, because it is that fault.
_ITSELF = {
    "coulomb_friction": "sign",
    "viscous_friction": "speed",
    "inertia_error": "acceleration",
    "constant_load": "one",
    "spring_load": "position",
    "actuation_delay": "rate",
}


def standing(drawn: Drawn, faulty: Truth, effect: str, rows: FloatArray) -> float:
    """RMS of the fault's own effort over noise, in the best band; 0 where the motion hides it.

    rows: float64[n, 6], of `equations.run` with the fault.
    """
    position, speed, acceleration = rows[::_EVERY, 3], rows[::_EVERY, 1], rows[::_EVERY, 4]
    rate = LOOP_HZ / _EVERY
    time = np.arange(position.size) / rate
    top = float(np.max(np.abs(speed)))
    moving = np.abs(speed) > _MOVES * top
    motion = time, position, np.where(moving, speed, 0.0), acceleration
    healthy = demand(drawn.truth, *motion)
    own = demand(faulty, *motion) - healthy
    by_direction = effect == "direction_dependent_friction"
    if by_direction:
        share = [float(np.mean(way * speed[moving] > 0.0)) for way in (1.0, -1.0)]
        if min(share) < _BOTH_WAYS:
            return 0.0
    height, middle, width = faulty.jam
    if height and passes(position, middle, width) == 1:  # a moment as well as a place
        return 0.0
    columns = {
        "one": np.ones_like(time),
        "sign": np.sign(motion[2]),
        "speed": speed,
        "acceleration": acceleration,
        "position": position,
    }
    if drawn.logger.lag_samples:
        columns["rate"] = np.gradient(healthy, time)
    if by_direction:
        del columns["one"], columns["sign"], columns["speed"]
    itself = next((one for end, one in _ITSELF.items() if effect.endswith(end)), None)
    columns.pop(itself or "", None)
    best = 0.0
    for band in _BANDS_HZ:
        if band > 0.2 * min(rate, drawn.logger.rate_hz):
            break
        sos = butter(2, band, fs=rate, output="sos")
        # At rest friction hides whatever it holds.
        basis = sosfiltfilt(sos, np.array(list(columns.values())) * moving, axis=-1)
        seen = sosfiltfilt(sos, own * moving)
        seen = seen - basis.T @ np.linalg.lstsq(basis.T, seen, rcond=None)[0]
        best = max(best, float(np.sqrt(np.mean(seen**2))) / noise_in(drawn, band))
    return best


def passes(position: FloatArray, middle: float, width: float) -> int:
    """How often a course, float64[n], enters a part of the travel."""
    inside = np.abs(position - middle) < 0.5 * width
    return int(np.count_nonzero(np.diff(inside, prepend=False) & inside))


def pulled(drawn: Drawn) -> float:
    """RMS of the effort that another axis asks for over all other noise, in the best band."""
    other = float(np.sqrt(np.mean(drawn.coupling**2)))
    alone = replace(drawn, coupling=np.zeros(1))
    return other / min(noise_in(alone, band) for band in _BANDS_HZ)


def noise_in(drawn: Drawn, band_hz: float) -> float:
    """Standard deviation of all that hides effort up to a frequency, in the output's own unit."""
    logger = drawn.logger
    share = math.sqrt(2.0 * band_hz / logger.rate_hz)
    per_unit = drawn.truth.gain / (drawn.truth.winding[0] or 1.0)
    white = 0.0 if drawn.effort_signal is None else per_unit * logger.effort_noise * share
    # A step of the encoder, twice differentiated within the band.
    step = logger.resolution / math.sqrt(12.0) * share / math.sqrt(5.0)
    counts = drawn.truth.inertia * step * (math.tau * band_hz) ** 2
    other = float(np.sqrt(np.mean(drawn.coupling**2)))
    return math.sqrt(white**2 + counts**2 + other**2) or 1e-12
