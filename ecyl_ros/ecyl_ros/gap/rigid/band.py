"""The band in which motion and effort are compared: noise of the position, and the low-passes."""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt, welch

from ...arrays import BoolArray, FloatArray
from ...drive.rigid.machine import Machine

ORDER = 4  # of the low-passes, run forwards and backwards
DERIVATIVE = 2.5  # cutoff before differentiating, over the bandwidth
SAMPLES_PER_PERIOD = 2.5  # of the bandwidth's frequency, after decimation
_HIGHEST = 0.2  # of the sampling rate: a bandwidth above it is not asked for
_POWER = 0.997  # share of the effort's power that the band holds
_LEAST_SAMPLES = 1500  # to compare, so that steps of friction are seen in smooth motion, too
FEWEST_SAMPLES = 300  # to compare, however noisy the position is
_NOISE = 0.05  # share of the acceleration's power that may be noise
_TOP = 0.35  # of the sampling rate: above it a position is taken to hold noise alone
_QUIETER = 0.5  # times the noise of differences: below, the recorded speed is taken
_LAG = 0.02  # of the speed's spread that a recorded speed may be off beyond noise


def low_passed(sos: FloatArray, values: FloatArray) -> FloatArray:
    """Zero-phase; the straight line through the ends is set aside, so that turns add no step."""
    line = np.linspace(values[0], values[-1], values.size)
    made: FloatArray = sosfiltfilt(sos, values - line) + line
    return made


def slope(values: FloatArray, rate: float) -> FloatArray:
    """Derivative over time by a cubic spline, float64[n].

    Central differences are too small by 16 % at a tenth of the rate, twice over for acceleration;
    these by a thousandth.
    """
    made: FloatArray = CubicSpline(np.arange(values.size) / rate, values).derivative()(
        np.arange(values.size) / rate
    )
    return made


def slope_gain(frequency: FloatArray, rate: float) -> FloatArray:
    """Gain of `slope` at frequencies, float64[k]."""
    angle = math.tau * frequency / rate
    made: FloatArray = rate * 3.0 * np.sin(angle) / (2.0 + np.cos(angle))
    return made


def speed_noise_of(position_noise: float, cutoff: float, rate: float) -> float:
    """Standard deviation of the low-passed speed, from the position's noise.

    White noise of sigma, differentiated, up to the cutoff f_c: 2 pi sigma sqrt(2 f_c^3 / (3 f_s)).
    """
    return math.tau * position_noise * math.sqrt(2.0 * cutoff**3 / (3.0 * rate))


def told_by_speed(
    recorded: FloatArray,
    velocity: FloatArray,
    usable: BoolArray,
    rate: float,
    spread: float,
    machine: Machine,
    bandwidth: float,
    effort: FloatArray,
    cutoff: float,
    times: float = 1.0,
) -> tuple[float, float, float] | None:
    """Bandwidth, cutoff and noise by the recorded speed; None where differences are as good.

    velocity: from differences of the position, with noise of `spread`. The recorded speed has to
    be clearly quieter, and to say the same within that noise: what of their difference goes with
    the motion, as a filter or a scale makes it. The rest is noise of the position, white or not.
    """
    if not usable.any() or not np.isfinite(recorded).all():
        return None
    own = position_noise(recorded, rate, usable)  # of any signal
    quiet = own * math.sqrt(min(2.0 * cutoff / rate, 1.0))
    sos = butter(ORDER, cutoff, fs=rate, output="sos")
    smooth = low_passed(sos, recorded)
    apart = (smooth - velocity)[usable]
    moved = np.stack([smooth, slope(smooth, rate)])[:, usable]
    with_motion = np.linalg.lstsq(moved.T, apart, rcond=None)[0] @ moved
    size = float(np.std(velocity[usable]))
    off = float(np.sqrt(np.mean(with_motion**2)))
    if quiet > _QUIETER * spread or off > 3.0 * spread + _LAG * size:
        return None
    if machine.bandwidth_hz is None:
        bandwidth = max(
            bandwidth, bandwidth_of(recorded, effort, rate, own, usable, order=1, times=times)
        )
        bandwidth = min(bandwidth, 0.4 * rate)
        cutoff = min(DERIVATIVE * bandwidth, 0.45 * rate)
    return bandwidth, cutoff, own * math.sqrt(min(2.0 * cutoff / rate, 1.0))


def _spectrum(values: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    segment = int(min(values.size, max(256, 4.0 * rate)))
    frequency, density = welch(values, rate, nperseg=segment, detrend="constant")
    return frequency, density


def _differences(values: FloatArray, usable: BoolArray, order: int) -> FloatArray:
    """Those between usable samples alone: what lies on either side of a gap is no step."""
    inside = usable
    for _ in range(order):
        inside = inside[1:] & inside[:-1]
    found: FloatArray = np.diff(values, order)[inside]
    return found


def _second_difference(rate: float, frequency: FloatArray) -> FloatArray:
    """Squared gain of the second difference over time."""
    gain: FloatArray = (2.0 * np.sin(np.pi * frequency / rate)) ** 4 * rate**4
    return gain


def position_noise(position: FloatArray, rate: float, usable: BoolArray) -> float:
    """Standard deviation of the position's white noise, from the top of its spectrum.

    Not below `rounding_of`.
    """
    second = _differences(position, usable, 2) * rate**2
    frequency, density = _spectrum(second, rate)
    top = frequency > _TOP * rate
    white = float(np.median(density[top] / _second_difference(rate, frequency[top])))
    return max(math.sqrt(max(white, 0.0) * rate / 2.0), rounding_of(position, usable), 1e-12)


def rounding_of(position: FloatArray, usable: BoolArray) -> float:
    """Standard deviation that rounding to counts makes, of the smallest step between values.

    0 where the steps from sample to sample are not counts.
    """
    steps = np.abs(_differences(position, usable, 1))
    negligible = 1e-12 * max(float(np.ptp(position)), 1e-300)
    smallest = float(np.min(steps[steps > negligible], initial=np.inf))
    crowd = float(np.mean((steps > 0.5 * smallest) & (steps < 1.5 * smallest) | (steps == 0.0)))
    return smallest / math.sqrt(12.0) if crowd > 0.2 and math.isfinite(smallest) else 0.0


def bandwidth_of(
    position: FloatArray,
    effort: FloatArray,
    rate: float,
    noise: float,
    usable: BoolArray,
    order: int = 2,
    times: float = 1.0,
) -> float:
    """Hz up to which effort and acceleration both say more than their noise.

    The frequency that holds 99.7 % of the effort's power (of the acceleration's, where there is no
    effort), or that which leaves 1500 samples to compare, if it is higher; unless noise of the
    position would by then be more than a twentieth of the acceleration's power; never above a fifth
    of the sampling rate. order: of the difference that makes `position` an acceleration; 1 where
    it is a speed, and `noise` is of it. times: as long as this are all recordings that are
    compared together.
    """
    second = _differences(position, usable, order) * rate**order
    frequency, density = _spectrum(second, rate)
    shape = _second_difference(rate, frequency) ** (0.5 * order)
    rough = 2.0 * noise**2 / rate * shape
    signal = np.cumsum(np.maximum(density - rough, 0.0))
    quiet = np.cumsum(rough) <= _NOISE * np.maximum(signal, 1e-300)
    quiet[: max(2, int(2.0 / frequency[1]))] = True
    limit = float(frequency[np.flatnonzero(quiet)[-1]])
    if np.isfinite(effort).all() and float(np.ptp(effort)) > 0.0:
        reach = effort_reach(effort, usable, rate)
    else:
        reach = _held(frequency, signal)
    seconds = times * usable.sum() / rate
    reach = max(reach, leaving(_LEAST_SAMPLES, seconds))
    # What the encoder's noise does in a wider band than it would have is weighed down.
    return max(
        min(reach, max(limit, leaving(FEWEST_SAMPLES, seconds)), _HIGHEST * rate),
        4.0 * frequency[1],
    )


def leaving(samples: int, seconds: float) -> float:
    """Bandwidth, Hz, that leaves so many samples of so many seconds to compare."""
    return samples / (SAMPLES_PER_PERIOD * seconds)


def effort_reach(effort: FloatArray, usable: BoolArray, rate: float) -> float:
    """Hz up to which 99.7 % of the power of an effort lies, less its white noise."""
    frequency, density = _spectrum(effort[usable] - effort[usable].mean(), rate)
    density = np.maximum(density - np.median(density[frequency > 0.4 * rate]), 0.0)
    return _held(frequency, np.cumsum(density))


def _held(frequency: FloatArray, power: FloatArray) -> float:
    """Frequency up to which nearly all of a cumulated power lies."""
    return float(frequency[int(np.searchsorted(power, _POWER * power[-1]))])
