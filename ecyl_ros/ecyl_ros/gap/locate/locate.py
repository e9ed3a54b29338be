"""Where the gap lies: by signal, by condition, by frequency, and by block.

Blocks are judged each with measured signals at its own ports, so that the closed loop does not
smear the fault of one over all.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from scipy.signal import welch

from ...arrays import BoolArray, FloatArray
from ...typical import typical_rms
from ..diagnosis import ConditionShare, PortCheck, SignalGap
from ..fit.fit import Fit
from ..replay.evidence import Smoother, gather
from ..replay.replay import Replay
from .conditions import near_reversal, shares, strongest_lines, widened
from .controller_port import controller_check

_LOW_SHARE = 0.05  # of the largest speed
_HIGH_SHARE = 0.5  # of the largest torque or acceleration


def by_signal(
    replay: Replay, before: Fit, after: Fit, noise: FloatArray, rows: BoolArray
) -> tuple[SignalGap, ...]:
    """RMS of the gap before and after in each signal's unit, on `rows`.

    noise: float64[signals], RMS of what noise alone leaves, over the signals' floors.
    """
    found = []
    for index, one in enumerate(replay.signals):
        known = rows & np.isfinite(replay.recorded[index])
        floor = float(replay.floor[index])
        values = [
            float(np.sqrt(np.mean(fit.gap[index, known] ** 2))) * floor if known.any() else 0.0
            for fit in (before, after)
        ]
        found.append(
            SignalGap(one.name, one.unit, values[0], values[1], floor * float(noise[index]))
        )
    return tuple(found)


def pooled(replay: Replay, gaps: FloatArray) -> float:
    """RMS per signal, each over the standard deviation of its recorded signal, pooled.

    gaps: float64[signals] in units of the noise floor.
    """
    spread = np.nanstd(replay.recorded, axis=1)
    shares = gaps * replay.floor / np.where(spread > 0.0, spread, np.inf)
    return float(np.sqrt(np.mean(shares**2)))


def by_condition(replay: Replay, gap: FloatArray) -> tuple[ConditionShare, ...]:
    """Shares of the gap's energy under the conditions of motion, largest surplus first.

    gap: float64[signals, n] over the noise floor. Each signal counts alike.
    """
    energy = _energy(gap) * replay.usable
    total = float(energy.sum())
    if total <= 0.0:
        return ()
    evidence = gather(replay, {})
    speed = evidence.rotor_speed_rad_s
    smooth = Smoother(replay.time_s)
    speed = smooth(speed)
    acceleration = smooth(speed, 1)
    top = float(np.nanmax(np.abs(speed), initial=0.0))
    near = near_reversal(speed, smooth.step)
    about = widened(np.abs(speed) > 0.01 * top, smooth.step, 2)
    masks: dict[str, BoolArray] = {}
    masks["reversal"] = near & about
    masks["rest"] = ~about
    masks["low_speed"] = (np.abs(speed) < _LOW_SHARE * top) & about & ~near
    masks["high_speed"] = np.abs(speed) > _HIGH_SHARE * top
    masks["acceleration"] = np.abs(acceleration) > _HIGH_SHARE * float(np.abs(acceleration).max())
    current = evidence.current_a
    if np.isfinite(current).any():
        smooth_current = np.abs(smooth(current))
        masks["high_torque"] = smooth_current > _HIGH_SHARE * float(np.nanmax(smooth_current))
    return shares(energy, masks, {"position": replay.reference_m, "time": replay.time_s})


def _energy(gap: FloatArray) -> FloatArray:
    each = gap**2
    scale = each.mean(axis=1, keepdims=True)
    summed: FloatArray = np.sum(each * (scale > 1.2**2), axis=0)
    return summed if summed.any() else np.sum(each, axis=0)


def by_frequency(replay: Replay, gap: FloatArray) -> tuple[float, ...]:
    """The strongest lines of the gap, Hz: peaks of its spectrum pooled over the signals."""
    rate = 1.0 / float(np.median(np.diff(replay.time_s)))
    length = min(gap.shape[1], int(4.0 * rate))
    frequency, density = welch(gap, rate, nperseg=length, detrend="constant", axis=1)
    noise = 2.0 / rate  # density of white noise of variance 1
    total = density.sum(axis=0)
    level = noise * gap.shape[0]
    return strongest_lines(frequency, total, 4.0 * level)


def by_port(replay: Replay) -> tuple[PortCheck, ...]:
    """Each block's own equation with measured signals at its ports, recorded less replayed."""
    return tuple(
        check
        for check in (controller_check(replay), *balances(replay))
        if check is not None and math.isfinite(check.rms)
    )


def beside_the_loop(ports: Sequence[PortCheck], replay: Replay) -> tuple[PortCheck, ...]:
    """The checks with the noise that the loop puts into the command in the voltage's floor.

    Of all commands that the current follows between two samples one is recorded, each with what
    noise made of it.
    """
    command = replay.loop_share * replay.proportional_noise_v if replay.noise_in_loop else 0.0
    command /= math.sqrt(Smoother(replay.time_s).points)
    return tuple(
        dataclasses.replace(one, floor=math.hypot(one.floor, command))
        if one.block == "motor_electrical"
        else one
        for one in ports
    )


def pooled_ports(checks: Sequence[Sequence[PortCheck]]) -> tuple[PortCheck, ...]:
    """The checks of several recordings of one machine as one each, in RMS."""
    if len(checks) == 1:
        return tuple(checks[0])

    def together(values: Sequence[float]) -> float:
        return float(np.sqrt(np.mean(np.square(values))))

    alike: dict[str, list[PortCheck]] = {}
    for one in (one for own in checks for one in own):
        alike.setdefault(one.what, []).append(one)
    return tuple(
        dataclasses.replace(
            own[0],
            rms=together([one.rms for one in own]),
            floor=together([one.floor for one in own]),
            typical=together([one.rms if one.typical is None else one.typical for one in own]),
        )
        for own in alike.values()
    )


def _check(block: str, what: str, unit: str, left: FloatArray, floor: float) -> PortCheck:
    rms = float(np.sqrt(np.nanmean(left**2)))
    return PortCheck(block, what, unit, rms, floor, typical_rms(left))


def balances(replay: Replay) -> list[PortCheck]:
    """Voltage, torque and position balance, recorded less replayed through the same filters."""
    evidence = gather(replay, {})
    smooth = Smoother(replay.time_s)
    motor = replay.drive.motor
    floors = {one.name: float(f) for one, f in zip(replay.signals, replay.floor, strict=True)}
    average = 1.0 / math.sqrt(smooth.points)
    slope = math.sqrt(12.0 / (smooth.step**2 * smooth.points**3))
    found = []
    columns = replay.full({})
    simulated = {one.name: columns[one.column] for one in replay.signals}
    if np.isfinite(evidence.voltage_v).any() and np.isfinite(evidence.current_a).any():
        balance = []
        for voltage, current, speed in (
            (evidence.voltage_v, evidence.current_a, evidence.rotor_speed_rad_s),
            (
                simulated["voltage_q"],
                simulated["current_q"],
                simulated.get("rotor_velocity", evidence.rotor_speed_rad_s),
            ),
        ):
            balance.append(
                smooth(voltage)
                - motor.resistance * smooth(current)
                - motor.inductance * smooth(current, 1)
                - motor.back_emf_constant * smooth(speed)
            )
        left = (balance[0] - balance[1])[replay.usable]
        noise = floors["current_q"]
        floor = math.sqrt(
            (motor.resistance * noise * average) ** 2
            + (motor.inductance * noise * slope) ** 2
            + (motor.back_emf_constant * floors.get("rotor_velocity", 0.0) * average) ** 2
        )
        found.append(_check("motor_electrical", "voltage balance", "V", left, floor))
    torque = evidence.torque_nm
    if np.isfinite(torque).sum() > 50:
        inertia = motor.rotor_inertia + replay.drive.load.inertia
        floor = math.hypot(
            motor.torque_constant * floors["current_q"] * average,
            inertia * floors.get("rotor_velocity", 0.0) * slope,
        )
        found.append(_check("motor_mechanical", "torque balance in contact", "N m", torque, floor))
    rod = evidence.rod_error_rad[replay.usable]
    if np.isfinite(rod).any():
        ratio = replay.drive.transmission.rod_per_rotor
        floor = math.hypot(floors["rod_position"] / ratio, floors["rotor_position"])
        found.append(_check("transmission", "rod against rotor", "rad", rod, floor))
    return found
