"""Lag and gain of a response behind its reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..errors import InputError

MAX_LAG_S = 1.0
# A periodic reference fits equally well one period on. Lags whose residual power is within this
# factor of the best count as equal.
EQUAL = 1.1
EQUAL_FLOOR = 1e-6
MAX_MOVES = 50  # samples that the refined lag may lie from the coarse one


@dataclass(frozen=True)
class Lag:
    """What makes |y(t) - offset - gain r(t - lag)| least, in the mean square.

    Attributes:
        lag_s: NaN where it has no meaning; `reason` then says why.
        gain: amplitude of the response over that of the reference; NaN likewise.
        offset: constant part, in the response's unit.
        residual_rms: of what is left, in the response's unit.
    """

    lag_s: float
    gain: float
    offset: float
    residual_rms: float
    reason: str = ""


def _none(reason: str) -> Lag:
    nan = float("nan")
    return Lag(nan, nan, nan, nan, reason)


def lag_and_gain(
    reference: FloatArray,
    response: FloatArray,
    rate_hz: float,
    *,
    max_lag_s: float | None = None,
) -> Lag:
    """Fit lag, gain and offset; the lag is not bound to whole samples.

    The reference is shifted as a cubic spline, the response is taken as it is. All lags from
    -max_lag/10 to max_lag are tried at whole samples, then the best is refined.

    Args:
        reference: float64[n], evenly sampled, finite; should be free of noise.
        response: float64[n], same instants and unit.
        rate_hz: sampling rate.
        max_lag_s: longest lag looked for; by default 1 s, at most a quarter of the signal.

    Raises:
        InputError: unequal lengths, fewer than 16 samples, values that are not finite, or a
            max_lag_s that is not positive or longer than half the signal.
    """
    if reference.shape != response.shape or reference.size < 16:
        raise InputError(
            f"lag needs two signals of one length of 16 or more, got {reference.size} and "
            f"{response.size}"
        )
    if not (np.isfinite(reference).all() and np.isfinite(response).all()):
        raise InputError("lag needs finite values, got NaN or infinity")
    duration = (reference.size - 1) / rate_hz
    longest = min(MAX_LAG_S, duration / 4) if max_lag_s is None else max_lag_s
    if not 0.0 < longest <= duration / 2:
        raise InputError(f"max_lag_s is {longest:g}, expected 0 to {duration / 2:g} s")
    if np.ptp(reference) <= 1e-12 * np.abs(reference).max():
        return _none("the reference never moves")
    if np.ptp(response) <= 1e-12 * np.abs(response).max():
        return _none("the response never moves")
    ahead, behind = int(0.1 * longest * rate_hz) + 1, int(longest * rate_hz) + 1
    # Away from large constants, where squares lose their last digits.
    base = float(reference.mean())
    coarse = _whole_samples(reference - base, response - response.mean(), ahead, behind)
    if coarse is None:
        return _none("the reference does not move where its lag could be seen")
    best = _chosen(coarse, ahead)
    if best is None:
        return _none(f"no lag between {-ahead / rate_hz:.3g} and {behind / rate_hz:.3g} s fits")
    return _refined(reference - base, base, response, rate_hz, best - ahead)


def _whole_samples(r: FloatArray, y: FloatArray, ahead: int, behind: int) -> FloatArray | None:
    """Residual power over that of y for lags of -ahead..behind samples, on one common stretch.

    A negative correlation counts as no fit at all.
    """
    from scipy.signal import correlate

    inner = y[behind : y.size - ahead]
    n = inner.size
    # sums[j] = sum_i inner[i] r[j + i]; lag k samples stands at j = behind - k.
    sums = correlate(r, inner, mode="valid", method="fft")[::-1]
    total = np.concatenate(([0.0], np.cumsum(r)))
    squares = np.concatenate(([0.0], np.cumsum(r * r)))
    mean = ((total[n:] - total[:-n]) / n)[::-1]
    power_r = (squares[n:] - squares[:-n])[::-1] - n * mean**2
    power_y = float(((inner - inner.mean()) ** 2).sum())
    covariance = sums - n * inner.mean() * mean
    if power_y <= 0.0 or power_r.max() <= 1e-12 * squares[-1]:
        return None
    safe = np.maximum(power_r, 1e-12 * power_r.max())
    return 1.0 - np.maximum(covariance, 0.0) ** 2 / (safe * power_y)


def _chosen(residual: FloatArray, ahead: int) -> int | None:
    """Index of the best lag; None where the response follows at none.

    Among equals the smallest is taken, where a lead counts as ten times its length.
    """
    inner = np.arange(1, residual.size - 1)
    left, mid, right = residual[:-2], residual[1:-1], residual[2:]
    low = (mid <= left) & (mid <= right) & (mid < 1.0 - EQUAL_FLOOR)
    inner, left, mid, right = inner[low], left[low], mid[low], right[low]
    if not inner.size or residual.min() < mid.min():  # nothing, or still falling at the edge
        return None
    # Between samples the residual is lower; a parabola says by how much, to a part of its bend.
    bend = np.maximum(left - 2.0 * mid + right, np.finfo(float).tiny)
    depth = np.maximum(mid - (left - right) ** 2 / (8.0 * bend), 0.0)
    best = int(np.argmin(depth))
    equal = depth <= EQUAL * depth[best] + EQUAL_FLOOR + 0.02 * bend[best]
    lags = inner[equal] - ahead
    return int(lags[np.argmin(np.where(lags < 0, -10 * lags, lags))]) + ahead


def _refined(r: FloatArray, base: float, y: FloatArray, rate_hz: float, start: int) -> Lag:
    """Minimise around `start` samples, on all of the response that the shifted reference covers.

    That stretch is longer than the one `start` was found on. Where something strong lies on top of
    the reference, the minimum may have moved by samples: then the next place is tried.
    """
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(np.arange(r.size), r)
    for _ in range(MAX_MOVES):
        lag, found = _minimum(spline, base, y, rate_hz, start)
        if abs(lag - start) < 1.0 - 1e-3:
            break
        start += 1 if lag > start else -1
    return found


def _minimum(
    spline: Any, base: float, y: FloatArray, rate_hz: float, start: int
) -> tuple[float, Lag]:
    """The least residual within a sample of `start`: its lag in samples, and all of the fit."""
    from scipy.optimize import minimize_scalar

    first, last = max(0, start + 1), min(y.size, y.size + start - 1)
    place = np.arange(first, last, dtype=np.float64)
    inner = y[first:last]
    centred = inner - inner.mean()

    def fit(lag: float) -> tuple[float, float, FloatArray]:
        shifted = spline(place - lag)
        mean = float(shifted.mean())
        shifted -= mean
        power = float(shifted @ shifted)
        gain = float(shifted @ centred) / power if power > 0.0 else 0.0
        return gain, mean, centred - gain * shifted

    def cost(lag: float) -> float:
        _, _, rest = fit(lag)
        return float(rest @ rest)

    # The residual is a parabola near its minimum, so the lag can be had to the root of the
    # floating-point resolution only, some 1e-8 samples.
    found = minimize_scalar(
        cost, bounds=(start - 1.0, start + 1.0), method="bounded", options={"xatol": 1e-9}
    )
    lag = float(found.x)
    gain, mean, rest = fit(lag)
    return lag, Lag(
        lag_s=lag / rate_hz,
        gain=gain,
        offset=float(inner.mean()) - gain * (mean + base),
        residual_rms=float(np.sqrt(np.mean(rest**2))),
    )
