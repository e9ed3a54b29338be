"""White noise of a measured signal, from its spectrum above the band of the comparison.

White noise is as dense at every frequency, so that no part of the spectrum lies below it: true
effort, ripple and the shaking of a machine only add. The least density above the band bounds it.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.signal import detrend, get_window
from scipy.stats import chi2, norm

from ...arrays import BoolArray, FloatArray
from ...recording.runs import runs_of

_SEGMENT = 256  # samples of one spectrum, where as many are usable in a row
_SHORTEST = 16
_PARTS = 8  # of the spectrum above the band, each of one density
_APART = 1.5  # bins that say different things behind a Hann window


def least_density(
    values: FloatArray,
    usable: BoolArray,
    rate_hz: float,
    above_hz: float,
    order: int = 0,
    below_hz: float = math.inf,
    share: float = 0.5,
    segment: int = _SEGMENT,
) -> float:
    """Least one-sided density between two frequencies, or up to half the rate, in values^2 / Hz.

    Freed of what the least of several estimates lies too low. Of the segments of a recording the
    median counts (or another `share` of them is below), for a blow is in all frequencies of its
    segment, of `segment` samples at the most.

    order: of the differences by which values are taken that move far beyond their noise.
    """
    taken = np.diff(values, order, prepend=np.full(order, values[0]))
    power = _spectra(taken, usable, rate_hz, segment)
    frequency = np.linspace(0.0, 0.5 * rate_hz, power.shape[1])
    power[:, 1:] /= (2.0 * np.sin(np.pi * frequency[1:] / rate_hz)) ** (2 * order)
    inside = (frequency >= above_hz) & (frequency <= below_hz)
    parts = np.array_split(np.flatnonzero(inside[1:-1]) + 1, _PARTS)
    means = np.array([power[:, part].mean(axis=1) for part in parts if part.size])
    freedom = 2.0 * min(part.size for part in parts if part.size) / _APART
    middles = np.quantile(means, share, axis=1) * (freedom / float(chi2.ppf(share, freedom)))
    # The standard error of a median is sqrt(pi / 2) that of a mean.
    spread = math.sqrt(2.0 / freedom * 0.5 * math.pi / power.shape[0])
    lowest = float(norm.ppf(1.0 - 0.5 ** (1.0 / len(means))))
    return float(middles.min()) / max(1.0 + lowest * spread, 0.5)


def _spectra(
    values: FloatArray, usable: BoolArray, rate_hz: float, segment: int = _SEGMENT
) -> FloatArray:
    """Densities of half overlapping segments of usable samples in a row, float64[segments, bins].

    Of all samples, where nowhere enough are usable in a row.
    """
    runs = runs_of(usable)
    longest = int(np.max(runs[:, 1] - runs[:, 0], initial=0))
    if longest < _SHORTEST:
        runs, longest = np.array([[0, values.size]]), values.size
    size = min(segment, longest) // 2 * 2
    starts = [at for a, b in runs.tolist() for at in range(a, b - size + 1, max(size // 2, 1))]
    pieces = np.stack([values[at : at + size] for at in starts])
    window = get_window("hann", size)
    spectra = np.abs(np.fft.rfft(detrend(pieces, axis=1) * window, axis=1)) ** 2
    made: FloatArray = 2.0 * spectra / (rate_hz * float(np.sum(window**2)))
    return made
