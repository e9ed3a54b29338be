"""An hour of a drive at work, written piece by piece: moves, rests, and one hidden fault."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ecyl_ros.drive import engine
from ecyl_ros.drive.cascade import initial_cascade_state
from ecyl_ros.drive.drive_file import load_drive, resolve_drive
from ecyl_ros.drive.packed import pack
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.plant import MEASURED, initial_state, voltage_queue
from ecyl_ros.drive.reference.moves import plan_move
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.recording import TOPICS, Recording
from ecyl_ros.recording.cdr import encode
from ecyl_ros.recording.writer import RecordingWriter

PIECE_S = 50
START_NS = 1_700_000_000_000_000_000
STROKE_M = 0.04  # moves end within it on either side
BUSY_S, IDLE_S = (60.0, 400.0), (30.0, 300.0)  # spells of moves, and of rest between them

Effects = dict[str, dict[str, float]]


def reference(seconds: float, rate_hz: float, seed: int) -> np.ndarray:
    """Rod position m and velocity m/s at `rate_hz`, float64[n + 1, 2]: spells of moves and rests.

    No two moves are alike: each has its own goal, speed and acceleration.
    """
    random = np.random.default_rng(seed)
    count = round(seconds * rate_hz) + 1
    wanted = np.zeros((count, 2))
    clock, place, rest_at = 1.0, 0.0, random.uniform(*BUSY_S)
    while clock < seconds:
        goal = random.uniform(-STROKE_M, STROKE_M)
        speed, acceleration = random.uniform(0.005, 0.12), random.uniform(0.3, 3.0)
        leg = plan_move(place, goal, speed, acceleration, 50.0)
        begin = int(np.ceil(clock * rate_hz))
        end = min(count, int((clock + leg.duration) * rate_hz) + 1)
        for index in range(begin, end):
            position, velocity, _ = leg.at_time(index / rate_hz - clock)
            wanted[index] = position[0], velocity[0]
        clock += leg.duration + random.uniform(0.2, 2.0)
        if clock > rest_at:
            clock += random.uniform(*IDLE_S)
            rest_at = clock + random.uniform(*BUSY_S)
        place = goal
        wanted[end:, 0] = goal
    return wanted


def pieces(
    drive: DriveParameters,
    wanted: np.ndarray,
    effects: Effects,
    acting: tuple[float, float],
) -> Iterator[Recording]:
    """The drive's run in pieces of `PIECE_S`, with the effects while the clock is within `acting`.

    The states go on from piece to piece, so that it is one run.
    """
    rate = drive.sample_rate
    every = drive.telemetry_every
    plant = initial_state()
    base = pack(drive)
    cascade, pending = initial_cascade_state(base), voltage_queue(base)
    size = round(PIECE_S * rate)
    for number, begin in enumerate(range(0, len(wanted) - 1, size)):
        count = min(size, len(wanted) - 1 - begin)
        faulty = acting[0] <= begin / rate < acting[1]
        # Noise is drawn by the tick, and ticks are counted again in every piece.
        sensors = dataclasses.replace(drive.sensors, noise_seed=number + 1)
        now = dataclasses.replace(drive, sensors=sensors, effects=effects if faulty else {})
        samples = np.zeros((count, engine.COLUMNS))
        engine.run_ticks(
            0,
            count * every,
            every,
            np.ascontiguousarray(wanted[begin : begin + count + 1]),
            plant,
            cascade,
            pending,
            pack(now),
            samples,
            np.zeros(len(MEASURED)),
        )
        epoch_ns = START_NS + round(begin / rate * 1e9)
        yield simulation_recording(engine.Simulation(samples, rate, plant), drive, epoch_ns)


def write_hour(
    path: Path,
    seconds: float,
    effects: Effects,
    acting: tuple[float, float] = (0.0, np.inf),
    *,
    seed: int = 1,
) -> None:
    """Record the bench drive with `effects` while the clock is within `acting`, s."""
    drive = load_drive(resolve_drive("bench"))
    wanted = reference(seconds, drive.sample_rate, seed)
    with RecordingWriter(path, overwrite=True) as writer:
        for recording in pieces(drive, wanted, effects, acting):
            columns = []
            for topic in TOPICS:
                joints = topic.joints
                values = {
                    field: recording.signal(signal)
                    for field, signal in topic.signals.items()
                    if not joints or field.rpartition(".")[0] in joints
                }
                columns.append(
                    encode(topic.type, topic.frame_id, joints, recording.stamp_ns, values)
                )
            for i, stamp in enumerate(recording.stamp_ns.tolist()):
                for topic, messages in zip(TOPICS, columns, strict=True):
                    writer.write(topic.name, messages[i], stamp)
