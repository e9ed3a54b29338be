"""Whether signals of a recording count the same way: position and command, effort and motion."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import BoolArray, FloatArray
from .signals import Recording

WRONG = "has the wrong sign"  # in the line on each
_MIRRORED = -0.8  # correlation of what should go together
# Partial correlation of the effort and the acceleration, and the share of the power that the load
# gives the motor: much of the one with a little of the other, or some of both.
_OPPOSED = ((-0.4, -0.02), (-0.2, -0.3))
_ONE_WAY = 0.2  # share of the moving samples that go either way
_ALIKE = 0.3  # by which the mean efforts of both ways may differ in size, without a sign
_IDLE = 0.5  # share of the resting samples without an effort
_SMOOTH_S = 0.02  # over which accelerations are taken
_FEWEST = 200  # samples
_PAIRS = (
    ("rod_position_m", "reference_position_m"),
    ("rotor_position_rad", "reference_position_rad"),
    ("rotor_position_rad", "reference_position_m"),
    ("rotor_position_rad", "rod_position_m"),
    ("rod_velocity_m_per_s", "reference_velocity_m_per_s"),
    ("rotor_velocity_rad_per_s", "reference_velocity_rad_per_s"),
    ("rotor_velocity_rad_per_s", "reference_velocity_m_per_s"),
)
_RATES = (
    ("rotor_position_rad", "rotor_velocity_rad_per_s"),
    ("rod_position_m", "rod_velocity_m_per_s"),
)
_EFFORTS = ("rotor_torque_nm", "current_q_a", "rod_force_n", "voltage_q_v")


@dataclass(frozen=True)
class WrongSign:
    """A signal that counts the other way than another.

    Attributes:
        signal: whose sign is taken for wrong.
        text: one line that says so, and by what.
        lost: whether it has none at all, so that no map can turn it.
    """

    signal: str
    text: str
    lost: bool = False

    def remedy(self, key: str, sign: int) -> str:
        """What to do about it; key, sign: entry of a map that turns the signal, and to what."""
        if self.lost:
            return "expected it logged with its sign, which no map can restore"
        return f"expected sign: {sign}{key}"


def wrong_signs(recording: Recording) -> list[WrongSign]:
    """Signals whose sign contradicts another's; forward has to be one direction for all.

    A measured position or speed is wrong where it mirrors its command, a speed where it mirrors
    the change of its position. An effort is wrong where it takes power out of the motion as a
    whole, and what of it goes with the acceleration (speed, its direction, and position allowed
    for) goes against it: friction and inertia both ask for the other sign. A load that drives the
    motor takes power too, and a spring opposes the acceleration; neither does both.
    """
    out: list[WrongSign] = []
    for measured, asked in _PAIRS:
        known = _known(recording, measured, asked)
        if any(one.signal == measured for one in out) or int(known.sum()) < _FEWEST:
            continue
        alike = _correlation(recording.signal(measured)[known], recording.signal(asked)[known])
        if alike < _MIRRORED:
            text = f"{measured} {WRONG}: it mirrors {asked} (correlation {alike:.2f})"
            out.append(WrongSign(measured, text))
    turned = {one.signal for one in out}
    for position, velocity in _RATES:
        known = _known(recording, position, velocity)
        if velocity in turned or int(known.sum()) < _FEWEST:
            continue
        change = _slope(recording.signal(position), recording)
        known &= np.isfinite(change)
        alike = _correlation(change[known], recording.signal(velocity)[known])
        if alike < _MIRRORED and position not in turned:
            text = (
                f"{velocity} {WRONG}: it mirrors the change of {position} (correlation {alike:.2f})"
            )
            out.append(WrongSign(velocity, text))
            turned.add(velocity)
    speed = _speed(recording, turned)
    if speed is not None:
        out += [
            found for name in _EFFORTS if (found := _effort(recording, name, *speed)) is not None
        ]
    return out


def _known(recording: Recording, *names: str) -> BoolArray:
    known: BoolArray = np.all([np.isfinite(recording.signal(name)) for name in names], axis=0)
    return known


def _correlation(left: FloatArray, right: FloatArray) -> float:
    if left.size < _FEWEST:
        return 0.0
    left, right = left - left.mean(), right - right.mean()
    power = math.sqrt(float(left @ left) * float(right @ right))
    return float(left @ right) / power if power > 0.0 and math.isfinite(power) else 0.0


def _width(recording: Recording) -> int:
    rate = recording.rate_hz
    return max(3, round(_SMOOTH_S * rate)) if math.isfinite(rate) else 3


def _slope(values: FloatArray, recording: Recording) -> FloatArray:
    """Mean rate of change about each sample, NaN next to gaps and ends."""
    width = _width(recording)
    out = np.full(values.size, np.nan)
    if values.size <= 2 * width:
        return out
    span = recording.time_s[2 * width :] - recording.time_s[: -2 * width]
    step = np.nanmedian(np.diff(recording.time_s))
    even = span < 3.0 * width * step
    change = (values[2 * width :] - values[: -2 * width]) / span
    out[width:-width] = np.where(even, change, np.nan)
    return out


def _smooth(values: FloatArray, width: int) -> FloatArray:
    """Moving mean over the samples that a slope is taken from."""
    kernel = np.full(2 * width + 1, 1.0 / (2 * width + 1))
    return np.convolve(values, kernel, mode="same") if values.size > 2 * width else values


def _speed(recording: Recording, turned: set[str]) -> tuple[FloatArray, FloatArray, str] | None:
    """Speed and position of the motor, or else of the rod, as far as their signs are trusted."""
    for position, velocity in _RATES:
        if recording.has(velocity) and velocity not in turned:
            own = recording.signal(velocity)
            where = recording.signal(position) if recording.has(position) else np.zeros(own.size)
            return own, where, velocity
        if recording.has(position) and position not in turned:
            own = recording.signal(position)
            return _slope(own, recording), own, position
    return None


def _effort(
    recording: Recording, name: str, speed: FloatArray, position: FloatArray, by: str
) -> WrongSign | None:
    if not recording.has(name):
        return None
    width = _width(recording)
    effort = _smooth(recording.signal(name), width)
    acceleration = _slope(speed, recording)
    speed = _smooth(speed, width)
    rows = (
        np.isfinite(effort) & np.isfinite(acceleration) & np.isfinite(speed) & np.isfinite(position)
    )
    if int(rows.sum()) < _FEWEST:
        return None
    effort, acceleration, speed = effort[rows], acceleration[rows], speed[rows]
    moving = 0.05 * float(np.abs(speed).max())
    if not moving > 0.0:
        return None
    if _unsigned(recording, name, speed, moving, rows):
        return WrongSign(
            name,
            f"{name} has lost its sign: it is never below 0 whichever way it goes, by {by}",
            lost=True,
        )
    held = effort - float(np.mean(effort))
    power = held * speed
    taken = float(power.sum()) / max(float(np.abs(power).sum()), 1e-300)
    others = np.column_stack([np.ones(speed.size), speed, np.tanh(speed / moving), position[rows]])
    others /= np.maximum(np.abs(others).max(axis=0), 1e-300)
    left = _without(held, others)
    pull = _without(acceleration - acceleration.mean(), others)
    against = _correlation(left, pull)
    if any(against < least and taken < power_less for least, power_less in _OPPOSED):
        return WrongSign(
            name,
            f"{name} {WRONG}: it goes against the acceleration (correlation "
            f"{against:.2f}) and against the motion ({-taken:.0%} of its power is taken from it), "
            f"by {by}",
        )
    return None


def _unsigned(
    recording: Recording, name: str, speed: FloatArray, moving: float, rows: BoolArray
) -> bool:
    """Whether an effort is but the size of one: it touches 0 from above while motion reverses.

    A load that always pulls one way may ask for that; not where nothing is needed to hold it at
    rest, or where both ways ask for as much.
    """
    effort = recording.signal(name)[rows]
    ahead, back = speed > moving, speed < -moving
    share = min(ahead.mean(), back.mean()) / max(float((ahead | back).mean()), 1e-9)
    if share < _ONE_WAY or effort.min() != 0.0 or int((effort == 0.0).sum()) < 3:
        return False
    rest = ~(ahead | back)
    if rest.any() and float(np.mean(effort[rest] == 0.0)) > _IDLE:
        return True
    sizes = float(effort[ahead].mean()), float(effort[back].mean())
    return abs(sizes[0] - sizes[1]) < _ALIKE * max(sizes)


def _without(values: FloatArray, others: FloatArray) -> FloatArray:
    weights, *_ = np.linalg.lstsq(others, values, rcond=None)
    out: FloatArray = values - others @ weights
    return out
