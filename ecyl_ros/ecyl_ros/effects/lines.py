"""What a line, a sine of some rate over angle or time, explains of a signal, rate by rate."""

from __future__ import annotations

import math

import numpy as np

from ..arrays import FloatArray
from ..drive.compiled import allocating
from .passed import Passed

_SAME = 1e-11  # relative: steps of evenly spaced rates differ by rounding
_EXACT = 64  # rates from one exact sine to the next; between them it is turned step by step


def explained(
    y: FloatArray,
    x: FloatArray,
    g: FloatArray,
    base: FloatArray,
    rates: FloatArray,
    passed: Passed | None = None,
) -> FloatArray:
    """float64[rates, 3]: variance explained, size and phase of a line g x A sin(rate x + phase).

    y: signal, without what is along `base`; x: angle, g: gain, all float64[n]; base: float64[n, k],
    orthonormal, taken out of the lines too. passed: what the signal's filter leaves of the lines.
    """
    sums = np.zeros((len(rates), 5))
    through = passed or Passed(np.zeros(len(x)), 0.0, np.ones(2))
    given = (y, x, g, base.T, rates, through.speed, through.response)
    per_speed = through.step_s / math.pi * (len(through.response) - 1)
    _inner_products(*(np.ascontiguousarray(one) for one in given), per_speed, sums)
    ss, cc, sc, sy, cy = sums.T
    determinant = np.maximum(ss * cc - sc**2, 1e-9 * (ss + cc) ** 2 + 1e-300)
    sine, cosine = (sy * cc - cy * sc) / determinant, (cy * ss - sy * sc) / determinant
    size = np.hypot(sine, cosine)
    # A line that is hardly more than a slope over the angles seen gets an absurd amplitude.
    sound = size * float(np.sqrt(np.mean(g**2))) < 5.0 * float(np.std(y))
    variance = np.where(sound, sine * sy + cosine * cy, 0.0)
    return np.column_stack([variance, size, np.arctan2(cosine, sine)])


@allocating
def _inner_products(y, x, g, base, rates, speed, response, per_speed, sums):
    """Fill `sums`, float64[rates, 5]: of sine and cosine with themselves, each other and `y`.

    base: float64[k, n], taken out of both. per_speed: places in `response` per rate and speed.
    """
    count, directions, last = len(x), base.shape[0], len(response) - 1
    left = np.empty(count)
    sine, cosine = np.empty(count), np.empty(count)
    step_sine, step_cosine = np.empty(count), np.empty(count)
    along = np.empty((2, directions))
    step = math.nan
    for row in range(len(rates)):
        if row % _EXACT == 0:
            for i in range(count):
                sine[i] = math.sin(rates[row] * x[i])
                cosine[i] = math.cos(rates[row] * x[i])
        else:
            turn = rates[row] - rates[row - 1]
            if not abs(turn - step) <= _SAME * abs(step):
                step = turn
                for i in range(count):
                    step_sine[i] = math.sin(step * x[i])
                    step_cosine[i] = math.cos(step * x[i])
            for i in range(count):
                turned = sine[i] * step_cosine[i] + cosine[i] * step_sine[i]
                cosine[i] = cosine[i] * step_cosine[i] - sine[i] * step_sine[i]
                sine[i] = turned
        ss, cc, sc, sy, cy = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(count):
            place = abs(rates[row] * speed[i]) * per_speed
            if place < last:
                below = int(place)
                share = place - below
                left[i] = g[i] * ((1.0 - share) * response[below] + share * response[below + 1])
            else:
                left[i] = 0.0
            s, c = left[i] * sine[i], left[i] * cosine[i]
            ss += s * s
            cc += c * c
            sc += s * c
            sy += s * y[i]
            cy += c * y[i]
        for k in range(directions):
            along[0, k] = 0.0
            along[1, k] = 0.0
            for i in range(count):
                along[0, k] += left[i] * sine[i] * base[k, i]
                along[1, k] += left[i] * cosine[i] * base[k, i]
            ss -= along[0, k] * along[0, k]
            cc -= along[1, k] * along[1, k]
            sc -= along[0, k] * along[1, k]
        sums[row, 0] = ss
        sums[row, 1] = cc
        sums[row, 2] = sc
        sums[row, 3] = sy
        sums[row, 4] = cy
