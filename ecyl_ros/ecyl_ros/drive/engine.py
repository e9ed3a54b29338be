"""The offline engine: the node graph's tick loop, compiled whole.

`simulate` calls the same step functions in the same order as the plant and controller nodes, so a
lockstep graph and the engine agree to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .cascade import cascade_step, initial_cascade_state
from .compiled import called
from .interpolation import interpolate_reference, reference_cubic
from .packed import pack
from .parameters import DriveParameters
from .plant import MEASURED, STATE_SIZE, apply_voltage, initial_state, measure, voltage_queue

REFERENCE, REFERENCE_VELOCITY = 0, 1
VOLTAGE = 2  # columns VOLTAGE, VOLTAGE + 1: u_d, u_q
MEASUREMENT = 4  # columns MEASUREMENT ...: see plant.MEASURED
LOAD = MEASUREMENT + len(MEASURED)  # columns LOAD, LOAD + 1: angle rad, speed rad/s
COLUMNS = LOAD + 2


@called
def run_ticks(
    first_tick, ticks, every, reference, plant, cascade, pending, params, samples, inputs
):
    """Run `ticks` control ticks from `first_tick`, in place; the compiled heart of `simulate`.

    every: ticks per sample. reference: float64[m, 2], sample i belongs to tick i * every and one
    more than the run reaches is there. plant, cascade: states. pending: float64[delay + 1, 2],
    voltages on their way to the inverter. samples: float64[n, COLUMNS] to fill at the ticks that
    are whole multiples of `every`. inputs: scratch, float64[len(MEASURED)].
    """
    period = every * params[0].tick
    delay = pending.shape[0] - 1
    index = first_tick // every
    into = first_tick - index * every
    cubic = reference_cubic(reference[index], reference[index + 1], period)
    for tick in range(first_tick, first_tick + ticks):
        measure(plant, tick, params, inputs)
        if into == 0:
            cubic = reference_cubic(reference[index], reference[index + 1], period)
        position, velocity = interpolate_reference(into / every, cubic)
        cascade_step(cascade, position, velocity, inputs, params, pending[delay])
        if into == 0:
            row = samples[index]
            row[REFERENCE] = reference[index, 0]
            row[REFERENCE_VELOCITY] = reference[index, 1]
            row[VOLTAGE] = pending[delay, 0]
            row[VOLTAGE + 1] = pending[delay, 1]
            for column in range(inputs.shape[0]):
                row[MEASUREMENT + column] = inputs[column]
            row[LOAD] = plant[2]
            row[LOAD + 1] = plant[3]
        apply_voltage(plant, pending, params)
        into += 1
        if into == every:
            into = 0
            index += 1


@dataclass(frozen=True)
class Simulation:
    """What a run leaves: `samples` float64[n, COLUMNS] at `sample_rate` Hz, and the last state."""

    samples: np.ndarray
    sample_rate: float
    final_state: np.ndarray

    @property
    def time_s(self) -> np.ndarray:
        """Instants of the samples from the start of the run, s."""
        return np.arange(len(self.samples)) / self.sample_rate

    def signal(self, name: str) -> np.ndarray:
        """One measured signal by its name in `plant.MEASURED`, float64[n]."""
        return self.samples[:, MEASUREMENT + MEASURED.index(name)]


def tick_count(drive: DriveParameters, duration_s: float) -> int:
    """Control ticks in `duration_s`."""
    return round(duration_s * drive.controller.rate)


def sample_count(drive: DriveParameters, duration_s: float) -> int:
    """Telemetry samples in `duration_s`: those at ticks 0, every, 2 every, ... below the last."""
    return -(-tick_count(drive, duration_s) // drive.telemetry_every)


def simulate(
    drive: DriveParameters,
    reference: Callable[[int], tuple[float, float]],
    duration_s: float,
    *,
    substeps: int | None = None,
    initial: np.ndarray | None = None,
    progress: Callable[[float], None] | None = None,
) -> Simulation:
    """Run the drive's closed loop for `duration_s`.

    Args:
        drive: parameters.
        reference: gives (rod position m, rod velocity m/s) for sample index 0, 1, 2, ...; called
            in order, once each, at `drive.sample_rate`.
        duration_s: length of the run, s.
        substeps: plant sub-steps per tick instead of the automatic choice.
        initial: plant state to start from, float64[STATE_SIZE]; at rest unless given.
        progress: called now and then with the share that is done, 0 to 1.
    """
    ticks = tick_count(drive, duration_s)
    every = drive.telemetry_every
    samples = np.zeros((sample_count(drive, duration_s), COLUMNS))
    # The controller interpolates towards the next sample, so one more than is recorded is needed.
    wanted = np.array([reference(index) for index in range(len(samples) + 1)], dtype=np.float64)
    params = pack(drive, substeps=substeps)
    plant = initial_state() if initial is None else np.array(initial, dtype=np.float64)
    if plant.shape != (STATE_SIZE,):
        raise ValueError(f"initial state has shape {plant.shape}, expected ({STATE_SIZE},)")
    cascade = initial_cascade_state(params)
    pending = voltage_queue(params)
    scratch = np.zeros(len(MEASURED))
    block = max(1, ticks if progress is None else ticks // 100)
    for first in range(0, ticks, block):
        count = min(block, ticks - first)
        run_ticks(first, count, every, wanted, plant, cascade, pending, params, samples, scratch)
        if progress is not None:
            progress((first + count) / ticks)
    return Simulation(samples, drive.sample_rate, plant)
