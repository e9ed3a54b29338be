"""Three lines through a median curve by Levenberg-Marquardt (section 3.3).

The curve is fitted as torque over angle: the torque sensor's 0.4 N m is 8 to 350 arcsec of shaft
angle, against 2 arcsec of the angle sensor, so the error stands on the torque axis and is of one
size there. Fitted the other way round, as equation (7) is written, the errors of the first line
would count forty times those of the third.

T2 is tied, as the paper ties it ("a function of T1 and the slope"), though it does not say how.
Least squares itself demands that the errors beyond T2 add up to zero (the derivative by T2 is
constant there), which puts the third line through the middle of its points and gives T2 from T1,
the slopes and that middle. So the tie costs nothing: the optimum is that of five free parameters.

The zeros of both sensors are fitted along: a torquemeter that is off by a newton metre would
double or halve k1. Without a slope in the clearance and without a second corner nothing tells one
zero from the other, nor does it matter.

Intervals come from the Jacobian of all parameters at the optimum, and the scatter of what is left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...errors import InputError
from .lines import ThreeLines
from .median_curve import MedianCurve

GRID = 24  # places tried for each corner before the fit proper
ROUNDS = 60
SETTLED = 1e-12  # of the angle's range
FINEST = 1e-4  # of the torque's range: a misfit below it is not told from none
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class LineFit:
    """What was fitted.

    Attributes:
        lines: as equation (7) has them.
        k1_rad_per_nm ... t2_nm: estimates; None where the curve does not show the parameter.
        clearance_rad: 2 (k1 - k2) T1, the dead zone that leaves the second line where it is.
        angle_zero_rad, torque_zero_nm: readings at the curve's centre.
        misfit_nm: RMS of the torques about the curve.
        points: fitted.
        notes: which parameters the curve does not show, one line each.
    """

    lines: ThreeLines
    k1_rad_per_nm: Estimate | None
    k2_rad_per_nm: Estimate
    k3_rad_per_nm: Estimate | None
    t1_nm: Estimate | None
    t2_nm: Estimate | None
    clearance_rad: Estimate
    angle_zero_rad: float
    torque_zero_nm: float
    misfit_nm: float
    points: int
    notes: tuple[str, ...]
    _covariance: FloatArray
    _shape: _Shape
    _values: FloatArray

    def angle_estimate(self, torque_nm: float) -> Estimate:
        """Angle between -torque and +torque on the fitted curve, rad, with its interval."""
        return _estimate(
            lambda v: 2.0 * float(_lines(v).angle_rad(np.array([torque_nm]))[0]),
            self._shape.full(self._values),
            self._shape,
            self._covariance,
            self.points,
        )


@dataclass(frozen=True)
class _Shape:
    """Which of the parameters (s1, s2, s3, a1, a2, zero, t0) are free.

    s: stiffness of each line; a: angle of each corner from the centre; zero, t0: angle and torque
    of the centre. Without a sloping first line s1 = 0; without a second corner s3 = s2 and a2 is
    out of reach; without either t0 = 0.
    """

    sloping: bool
    corner: bool

    @property
    def free(self) -> list[int]:
        names = [0] if self.sloping else []
        names += [1]
        names += [2] if self.corner else []
        names += [3]
        names += [4] if self.corner else []
        return [*names, 5, 6] if self.sloping or self.corner else [*names, 5]

    def full(self, free: FloatArray) -> FloatArray:
        values = np.zeros(7)
        values[self.free] = free
        if not self.corner:
            values[2], values[4] = values[1], np.inf
        return values


def _torque(values: FloatArray, angle: FloatArray) -> FloatArray:
    s1, s2, s3, a1, a2, zero, t0 = values
    twist = angle - zero
    size = np.abs(twist)
    torque = s1 * np.minimum(size, a1) + s2 * np.clip(size - a1, 0.0, max(a2 - a1, 0.0))
    if np.isfinite(a2):
        torque += s3 * np.maximum(size - a2, 0.0)
    return t0 + np.sign(twist) * torque


def _lines(values: FloatArray) -> ThreeLines:
    s1, s2, s3, a1, a2, _, _ = values
    t1 = s1 * a1
    t2 = t1 + s2 * (a2 - a1) if np.isfinite(a2) else np.inf
    k1 = 1.0 / s1 if s1 > 0.0 else np.inf
    return ThreeLines(k1, 1.0 / s2, 1.0 / s3, t1, t2, half_clearance_rad=a1 if s1 <= 0.0 else 0.0)


def fit_lines(curve: MedianCurve) -> LineFit:
    """Fit three lines; fewer where the curve does not show three.

    Of three lines, a plain dead zone in place of the first, and one stiffness in place of the last
    two, the form with the least Bayes information criterion is taken, and `notes` says so.

    Raises:
        InputError: nothing that loads up with angle was found.
    """
    angle_scale = float(np.ptp(curve.angle_rad)) / 2.0
    torque_scale = float(np.abs(curve.torque_nm).max())
    angle, torque = curve.angle_rad / angle_scale, curve.torque_nm / torque_scale
    tried = []
    for shape in (_Shape(s, c) for s in (True, False) for c in (True, False)):
        found = _fitted(shape, angle, torque)
        if found is not None:
            misfit = max(float(np.sqrt(np.mean(found[1] ** 2))), FINEST)
            score = 2.0 * angle.size * np.log(misfit) + len(shape.free) * np.log(angle.size)
            tried.append((score, shape, found[0], found[1]))
    if not tried:
        raise InputError("bench: the median curve does not load up with angle; expected lines")
    _, shape, values, rest = min(tried, key=lambda one: one[0])
    jacobian = _jacobian(lambda v: _torque(shape.full(v), angle), values)
    spare = angle.size - len(shape.free)
    units = np.array([*[torque_scale / angle_scale] * 3, *[angle_scale] * 3, torque_scale])
    units = units[shape.free]
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * float(rest @ rest) / spare
    covariance = covariance * np.outer(units, units)
    return _described(shape, values * units, covariance, float(rest.std()) * torque_scale, rest)


def _described(
    shape: _Shape, values: FloatArray, covariance: FloatArray, misfit: float, rest: FloatArray
) -> LineFit:
    full = shape.full(values)
    lines = _lines(full)

    def of(name: str) -> Estimate:
        return _estimate(
            lambda v: float(getattr(_lines(v), name)), full, shape, covariance, rest.size
        )

    notes = []
    if not shape.sloping:
        notes.append("the clearance is a plain dead zone: k1 has no end, T1 is 0")
    if not shape.corner:
        notes.append("one stiffness fits the whole flank: no k3, no T2")
    return LineFit(
        lines=lines,
        k1_rad_per_nm=of("k1") if shape.sloping else None,
        k2_rad_per_nm=of("k2"),
        k3_rad_per_nm=of("k3") if shape.corner else None,
        t1_nm=of("t1") if shape.sloping else None,
        t2_nm=of("t2") if shape.corner else None,
        clearance_rad=_estimate(_dead_zone, full, shape, covariance, rest.size),
        angle_zero_rad=float(full[5]),
        torque_zero_nm=float(full[6]),
        misfit_nm=misfit,
        points=int(rest.size),
        notes=tuple(notes),
        _covariance=covariance,
        _shape=shape,
        _values=values,
    )


def _dead_zone(values: FloatArray) -> float:
    s1, s2, _, a1, _, _, _ = values
    return float(2.0 * a1 * (1.0 - s1 / s2))


def _estimate(of, full: FloatArray, shape: _Shape, covariance: FloatArray, points: int) -> Estimate:
    """A function of the parameters with its interval, by its gradient."""
    from scipy.stats import t as student

    free = full[shape.free]
    value = of(full)
    gradient = _jacobian(lambda v: np.array([of(shape.full(v))]), free)[0]
    spread = float(np.sqrt(max(gradient @ covariance @ gradient, 0.0)))
    half = float(student.ppf(0.5 + CONFIDENCE / 2.0, points - free.size)) * spread
    return Estimate(value, value - half, value + half)


def _jacobian(of, values: FloatArray) -> FloatArray:
    """Central differences: the lines are straight, so steps need not be small."""
    columns = []
    scale = np.abs(values).max()
    for index, value in enumerate(values):
        step = 1e-6 * max(abs(value), 1e-3 * scale)
        up, down = values.copy(), values.copy()
        up[index] += step
        down[index] -= step
        columns.append((of(up) - of(down)) / (2.0 * step))
    return np.stack(columns, axis=-1)


def _fitted(
    shape: _Shape, angle: FloatArray, torque: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Free parameters and residual, everything of order one; None where no start was found."""
    from scipy.optimize import least_squares

    start = _start(shape, angle, torque)
    if start is None:
        return None
    if not shape.corner:
        found = least_squares(
            lambda v: _torque(shape.full(v), angle) - torque, start, method="lm", xtol=1e-14
        )
        return _sound(shape, found.x, angle, torque)
    # The points beyond T2 are those of the round before, until they no longer change.
    values = start
    place = shape.free.index(4)
    for _ in range(ROUNDS):
        twist = angle - values[shape.free.index(5)]
        beyond = np.abs(twist) > values[place]
        if beyond.sum() < 3:
            return None
        tied = np.delete(values, place)

        def full(v: FloatArray, beyond: np.ndarray = beyond) -> FloatArray:
            return np.insert(
                v, place, _tie(shape.full(np.insert(v, place, 0.0)), angle, torque, beyond)
            )

        found = least_squares(
            lambda v: _torque(shape.full(full(v)), angle) - torque, tied, method="lm", xtol=1e-14
        )
        before, values = values, full(found.x)
        if np.abs(values - before).max() <= SETTLED:
            break
    return _sound(shape, values, angle, torque)


def _tie(values: FloatArray, angle: FloatArray, torque: FloatArray, beyond: np.ndarray) -> float:
    """Corner angle that puts the third line through the middle of the points beyond it."""
    s1, s2, s3, a1, _, zero, t0 = values
    twist = angle[beyond] - zero
    middle_angle = float(np.abs(twist).mean())
    middle_torque = float((np.sign(twist) * (torque[beyond] - t0)).mean())
    if s2 == s3:
        return middle_angle
    return float((middle_torque - s1 * a1 + s2 * a1 - s3 * middle_angle) / (s2 - s3))


def _sound(
    shape: _Shape, values: FloatArray, angle: FloatArray, torque: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    s1, s2, s3, a1, a2, _, _ = full = shape.full(values)
    rising = s2 > 0.0 and s3 > 0.0 and s1 >= 0.0 and 0.0 < a1 < a2
    if not rising or (shape.corner and a2 >= np.abs(angle).max()):
        return None
    return values, _torque(full, angle) - torque


def _start(shape: _Shape, angle: FloatArray, torque: FloatArray) -> FloatArray | None:
    """The best of a grid of corners; the slopes then are linear least squares."""
    zero, t0 = _centre(angle, torque) if 6 in shape.free else (_middle(angle, torque)[0], 0.0)
    size, sign = np.abs(angle - zero), np.sign(angle - zero)
    loaded = torque - t0
    reach = float(size.max())
    corners = np.quantile(size, np.linspace(0.02, 0.98, GRID))
    best: tuple[float, FloatArray] | None = None
    for first in corners:
        for second in corners[corners > first] if shape.corner else (np.inf,):
            columns = _basis(shape, size, float(first), float(second))
            slopes, *_ = np.linalg.lstsq(sign[:, None] * columns, loaded, rcond=None)
            if np.any(slopes <= 0.0):
                continue
            rest = (sign[:, None] * columns) @ slopes - loaded
            cost = float(rest @ rest)
            if best is None or cost < best[0]:
                corner = [second] if shape.corner else []
                best = (cost, np.array([*slopes, first, *corner, zero, t0])[: len(shape.free)])
    return None if best is None or reach <= 0.0 else best[1]


def _basis(shape: _Shape, size: FloatArray, first: float, second: float) -> FloatArray:
    columns: list[FloatArray] = [np.minimum(size, first)] if shape.sloping else []
    columns.append(np.clip(size - first, 0.0, second - first))
    if shape.corner:
        columns.append(np.maximum(size - second, 0.0))
    return np.stack(columns, axis=1)


def _centre(angle: FloatArray, torque: FloatArray) -> tuple[float, float]:
    """Angle and torque about which the flanks are most nearly the same, turned round."""
    offsets = np.linspace(-0.2, 0.2, 81)
    middles = [_middle(angle, torque - one) for one in offsets]
    best = int(np.argmin([scatter for _, scatter in middles]))
    return middles[best][0], float(offsets[best])


def _middle(angle: FloatArray, torque: FloatArray) -> tuple[float, float]:
    """Middle between the flanks at equal torques, which the steep part near zero does not blur, and
    how much it scatters over those torques."""
    order = np.argsort(torque)
    levels = np.linspace(0.2, 0.9, 29) * min(torque.max(), -torque.min())
    up, down = (np.interp(sign * levels, torque[order], angle[order]) for sign in (1.0, -1.0))
    middle = 0.5 * (up + down)
    return float(np.median(middle)), float(middle.std())
