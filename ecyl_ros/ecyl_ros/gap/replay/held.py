"""Control ticks that a controller left out: the inverter held its last voltage, and so did the
integrals.

A cascade that closes over topics in real time now and then wakes too late for a tick. What that
does to the drive is none of its faults; where every command was recorded, the replay leaves out
the same ticks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...drive.cascade import CascadeState
from ...drive.engine import VOLTAGE
from ...drive.parameters import DriveParameters
from ...recording.signals import Recording
from .grid import Grid

_UNLIKE = 0.99  # of all commands: none that is rounded coarsely enough to come again by chance
_LONGEST_S = 0.1  # for so long a drive holds a voltage, as the node graph's watchdog has it
_ANSWERED = ("rotor_position_rad", "rotor_velocity_rad_per_s", "current_q_a")


def held_ticks(recording: Recording, grid: Grid, drive: DriveParameters) -> NDArray[np.int64]:
    """Ticks of a replay's grid that the recorded controller left out: int64[m].

    Told only where every tick's command was recorded, of a loop whose commands travel.
    """
    if grid.every > 1 or grid.rows is None or not drive.controller.delay_ticks:
        return np.zeros(0, dtype=np.int64)
    found: NDArray[np.int64] = grid.rows[held_samples(recording)]
    return found


def held_samples(recording: Recording) -> NDArray[np.int64]:
    """The samples whose command is the one before, though what it answers to has moved: int64[m].

    A voltage at its limit may come again, and one that is rounded may: neither counts.
    """
    voltage = recording.voltage_q_v
    none = np.zeros(0, dtype=np.int64)
    same = np.concatenate([[False], voltage[1:] == voltage[:-1]])
    if not same.any():
        return none
    said, times = np.unique(voltage[np.isfinite(voltage) & ~same], return_counts=True)
    if np.count_nonzero(times == 1) < _UNLIKE * times.sum():
        return none
    moved = np.zeros(len(voltage), dtype=bool)
    for name in _ANSWERED:
        values = recording.signal(name)
        moved[1:] |= np.isfinite(values[1:] - values[:-1]) & (values[1:] != values[:-1])
    inside = np.isin(voltage, said[times == 1]) & (np.abs(voltage) < np.nanmax(np.abs(voltage)))
    found = np.flatnonzero(same & moved & inside)
    runs = np.split(found, np.flatnonzero(np.diff(found) > 1) + 1)
    short = [run for run in runs if len(run) <= _LONGEST_S * recording.rate_hz]
    return np.concatenate([none, *short])


def run_holding(
    run: Callable[[int, int], None],
    ticks: int,
    held: Sequence[int],
    cascade: CascadeState,
    pending: FloatArray,
    samples: FloatArray,
) -> None:
    """Run all ticks, but leave out the controller in those that are `held`.

    Args:
        run: runs so many ticks from a first one; see `engine.run_ticks`. held: in order, of a loop
            whose samples are its ticks.
        cascade, samples: states and rows that `run` works on.
        pending: float64[delay + 1, 2], voltages on their way, at least one tick of them: a command
            that acts in its own tick has acted before it could be taken back.
    """
    first = 0
    for tick in held:
        run(first, tick - first)
        before = [None if one is None else one.copy() for one in cascade]
        last = pending[-1].copy()
        run(tick, 1)
        for now, kept in zip(cascade, before, strict=True):
            if now is not None:
                now[:] = kept
        pending[-2:] = last
        samples[tick, VOLTAGE : VOLTAGE + 2] = last
        first = tick + 1
    run(first, ticks - first)
