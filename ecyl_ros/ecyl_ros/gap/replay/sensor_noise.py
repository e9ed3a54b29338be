"""Noise of the sensors: as a drive file states it, and as a recording shows it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray
from ...drive.loop_noise import current_command_noise
from ...drive.parameters import DriveParameters
from ...recording.signals import Recording
from ...typical import typical_rms

# Where drive files state no noise and signals are coarse, the recording's own roughness gives it.
_ROUGHNESS_ORDER = 3
_ROUGHER = 1.5  # a signal may be this much noisier than stated
_QUIET_COMMAND = 0.15  # floor of a command without noise, as a share of what noise would make it
_ROUNDED = 1e-9  # of a signal's range: nearer than that two values are one


def roughness(values: FloatArray) -> float:
    """Standard deviation of the white noise in a sampled smooth signal.

    From third differences, by the median, so that neither smooth motion nor single impacts count;
    0 where fewer than 50 values are there.
    """
    finite = values[np.isfinite(values)]
    if finite.size < 50:
        return 0.0
    differences = np.diff(finite, _ROUGHNESS_ORDER)
    scale = math.sqrt(math.comb(2 * _ROUGHNESS_ORDER, _ROUGHNESS_ORDER))
    return typical_rms(differences) / scale


def coarse_step(values: FloatArray) -> float:
    """The step that a signal was rounded to, where that is more than its noise; 0 else.

    Of a staircase most third differences are 0, and its roughness says nothing.
    """
    distinct = np.unique(values[np.isfinite(values)])
    if distinct.size < 2:
        return 0.0
    apart = np.diff(distinct)
    step = float(apart[apart > _ROUNDED * (distinct[-1] - distinct[0])].min())
    return step if step / math.sqrt(12.0) > roughness(values) else 0.0


def states_noise(drive: DriveParameters) -> dict[str, bool]:
    """Whether the drive file states noise of each signal; a resolution alone is the least of it.

    The commanded voltage has what comes round the loop.
    """
    sensors = drive.sensors
    stated = {
        "rotor_position": sensors.rotor_position_noise > 0.0,
        "rotor_velocity": sensors.rotor_velocity_noise > 0.0,
        "current_q": sensors.current_noise > 0.0,
        "rod_position": sensors.rod_position_noise > 0.0,
    }
    return {**stated, "voltage_q": any(stated.values())}


def declared_noise(drive: DriveParameters) -> dict[str, float]:
    """Standard deviation of each signal's noise as the drive file states it, in its unit.

    The commanded voltage carries no noise of its own: its floor is what the noise of the measured
    signals becomes on its way through the cascade's proportional gains and filters.
    """
    sensors, controller = drive.sensors, drive.controller
    position = math.hypot(
        sensors.rotor_position_noise, sensors.rotor_position_resolution / math.sqrt(12.0)
    )
    rod = math.hypot(sensors.rod_position_noise, sensors.rod_position_resolution / math.sqrt(12.0))
    current = math.hypot(sensors.current_noise, current_command_noise(drive))
    return {
        "rotor_position": position,
        "rotor_velocity": sensors.rotor_velocity_noise,
        "current_q": sensors.current_noise,
        "voltage_q": controller.current.kp * current,
        "rod_position": rod,
    }


def first_floors(
    signals: Sequence[str], recorded: FloatArray, drive: DriveParameters
) -> FloatArray:
    """Floors before anything was replayed, float64[signals]: as stated, else as rough as recorded.

    signals: names. recorded: float64[signals, n].
    """
    stated, known = declared_noise(drive), states_noise(drive)
    return np.array(
        [
            max(stated[name], 0.0 if known[name] else roughness(values), 1e-30)
            for name, values in zip(signals, recorded, strict=True)
        ]
    )


def settled_floors(
    signals: Sequence[str], recorded: FloatArray, left: FloatArray, drive: DriveParameters
) -> tuple[FloatArray, float]:
    """Standard deviation of each signal's noise: as stated, or more where it is rougher.

    Roughness is looked for in what the nominal replay leaves, so that fast motion does not count as
    noise; a gap that is rough itself cannot raise the floor beyond what was stated times
    `_ROUGHER`. Where no noise was stated, it is as the recording shows it, and no less than its
    resolution makes.

    Args:
        signals, recorded: see `first_floors`.
        left: float64[signals, n], recorded less the nominal replay.
        drive: as its file states it.

    Returns:
        Floors, float64[signals], and the share of the stated noise that goes round the loop, as the
        command shows it; all of it where it does not.
    """
    stated, known = declared_noise(drive), states_noise(drive)
    floors, loop_share = [], 1.0
    for name, values, rest in zip(signals, recorded, left, strict=True):
        said = stated[name]
        measured = min(roughness(values), roughness(rest))
        if not (known[name] and said > 0.0):
            scale = float(np.nanstd(values)) or 1.0
            floors.append(max(said, measured, 1e-9 * scale))
        elif name == "voltage_q":
            # Noise that only the recording has never gets into the command.
            loop_share = min(1.0, measured / said)
            floors.append(said * max(loop_share, _QUIET_COMMAND))
        else:
            floors.append(min(max(said, measured), _ROUGHER * said))
    return np.array(floors), loop_share


def with_steps(drive: DriveParameters, recording: Recording) -> DriveParameters:
    """The drive with the steps that the recording was quantised to, where its file states none.

    As the recording says, or its values show.
    """
    sensors = drive.sensors
    rotor, rod = (
        recording.resolution.get(name, 0.0) or coarse_step(recording.signal(name))
        for name in ("rotor_position_rad", "rod_position_m")
    )
    sensors = dataclasses.replace(
        sensors,
        rotor_position_resolution=sensors.rotor_position_resolution or rotor,
        rod_position_resolution=sensors.rod_position_resolution or rod,
    )
    return dataclasses.replace(drive, sensors=sensors)


def with_noise(drive: DriveParameters, share: float, seed: int) -> DriveParameters:
    """The drive with a share of its sensors' noise, drawn from `seed`."""
    noise = {
        one.name: share * getattr(drive.sensors, one.name)
        for one in dataclasses.fields(drive.sensors)
        if one.name.endswith("_noise")
    }
    sensors = dataclasses.replace(drive.sensors, **noise, noise_seed=seed)
    return dataclasses.replace(drive, sensors=sensors)


def silent(drive: DriveParameters) -> DriveParameters:
    """The drive without noise and quantisation."""
    quiet = with_noise(drive, 0.0, drive.sensors.noise_seed)
    sensors = dataclasses.replace(
        quiet.sensors, rotor_position_resolution=0.0, rod_position_resolution=0.0
    )
    return dataclasses.replace(quiet, sensors=sensors)
