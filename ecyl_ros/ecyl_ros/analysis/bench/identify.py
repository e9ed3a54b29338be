"""From a loop to a transmission: edges, median curve, three lines, clearance, stiffness."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ...arrays import FloatArray
from ...errors import InputError
from . import table1
from .edges import Edges, split_edges
from .fit import Estimate, LineFit, fit_lines
from .loop import Loop
from .median_curve import MedianCurve, median_curve


@dataclass(frozen=True)
class Stiffness:
    """Equation (8): one segment of the flank.

    The equation gives the slope of the curve, not the secant from its origin: the line 1/k3 of
    Fig. 9 does not pass through zero. The torque beyond T2 is T2 + (angle - angle at T2) / k3.
    """

    from_nm: float
    to_nm: float
    nm_per_rad: Estimate


@dataclass(frozen=True)
class Identified:
    """What a loop says of the transmission.

    Attributes:
        loop, edges, curve, fit: the way there.
        clearance_rad: angle between the points at -+3 % of rated torque on the fitted curve.
        clearance_read_rad: the same read off the median curve's points; NaN where it has none.
        clearance_torque_nm: that torque.
        stiffness: segments of equation (8).
        secant_nm_per_rad: largest torque fitted over its angle from the centre, for comparison.
        shaft_twist_rad_per_nm: subtracted from the angle before anything else.
        notes: one line each.
    """

    loop: Loop = field(repr=False)
    edges: Edges = field(repr=False)
    curve: MedianCurve = field(repr=False)
    fit: LineFit
    clearance_rad: Estimate
    clearance_read_rad: float
    clearance_torque_nm: float
    stiffness: tuple[Stiffness, ...]
    secant_nm_per_rad: float
    shaft_twist_rad_per_nm: float
    notes: tuple[str, ...]


def identify(
    loop: Loop,
    *,
    rated_torque_nm: float = table1.RATED_TORQUE,
    shaft_twist_rad_per_nm: float = 0.0,
    per_bin: int | None = None,
) -> Identified:
    """Identify the transmission in a loop.

    Args:
        loop: readings with the output locked.
        rated_torque_nm: the clearance is read between the points at +-3 % of it.
        shaft_twist_rad_per_nm: twist of the shaft up to the angle sensor, which is no part of the
            transmission and is subtracted.
        per_bin: see `median_curve`.

    Raises:
        InputError: see `split_edges`, `median_curve`, `fit_lines`; a rated torque of which 3 % are
            beyond the loop.
    """
    torque = table1.RATED_SHARE * rated_torque_nm
    edges = split_edges(loop)
    turned = replace(loop, angle_rad=loop.angle_rad - shaft_twist_rad_per_nm * loop.torque_nm)
    curve = median_curve(turned, edges, per_bin=per_bin)
    largest = float(np.abs(curve.torque_nm).max())
    if not 0.0 < torque < largest:
        raise InputError(
            f"{loop.source}: 3 % of a rated torque of {rated_torque_nm:g} N m is {torque:g} N m, "
            f"expected more than 0 and within the loop's {largest:.4g} N m"
        )
    if float(np.polyfit(curve.angle_rad, curve.torque_nm, 1)[0]) <= 0.0:
        raise InputError(
            f"{loop.source}: the angle falls as the torque rises; expected both of one sign"
        )
    fit = fit_lines(curve)
    largest = float(np.abs(curve.torque_nm - fit.torque_zero_nm).max())
    last = float(fit.lines.angle_rad(np.array([largest]))[0])
    return Identified(
        loop=turned,
        edges=edges,
        curve=curve,
        fit=fit,
        clearance_rad=fit.angle_estimate(torque),
        clearance_read_rad=_read_off(curve, torque, fit.torque_zero_nm),
        clearance_torque_nm=torque,
        stiffness=_stiffness(fit),
        secant_nm_per_rad=largest / last,
        shaft_twist_rad_per_nm=shaft_twist_rad_per_nm,
        notes=(*curve.notes, *fit.notes),
    )


def _read_off(curve: MedianCurve, torque_nm: float, zero_nm: float) -> float:
    """Angle between the outermost passages of -torque and +torque on the median curve, rad."""
    angle, torque = curve.angle_rad, curve.torque_nm - zero_nm
    return _passage(angle, torque, torque_nm) + _passage(-angle[::-1], -torque[::-1], torque_nm)


def _passage(angle: FloatArray, torque: FloatArray, level: float) -> float:
    # Noise may cross the level more than once: the middle of first and last.
    crossed = np.flatnonzero((torque[:-1] < level) & (torque[1:] >= level))
    if not crossed.size:
        return float("nan")
    share = (level - torque[crossed]) / (torque[crossed + 1] - torque[crossed])
    places = angle[crossed] + share * (angle[crossed + 1] - angle[crossed])
    return 0.5 * float(places.min() + places.max())


def _stiffness(fit: LineFit) -> tuple[Stiffness, ...]:
    largest = np.inf
    corner = fit.t2_nm.value if fit.t2_nm is not None else largest
    segments = [Stiffness(0.0, corner, _inverse(fit.k2_rad_per_nm))]
    if fit.k3_rad_per_nm is not None:
        segments.append(Stiffness(corner, largest, _inverse(fit.k3_rad_per_nm)))
    return tuple(segments)


def _inverse(one: Estimate) -> Estimate:
    return Estimate(1.0 / one.value, 1.0 / one.high, 1.0 / one.low if one.low > 0.0 else np.inf)
