"""The twin beside a running drive: takes what the topics say, gives residuals and the gap now."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ...arrays import FloatArray, StampArray
from ...drive.engine import MEASUREMENT, VOLTAGE
from ...drive.parameters import DriveParameters
from ...drive.plant import MEASURED
from ..replay.sensor_noise import declared_noise
from .start import settling_time_s, state_from
from .streams import Stream, Streams
from .twin import Twin
from .window import Compared, GapNow, Window

REFERENCE = "reference"
# The signals of the topics that are compared, by the topics' keys.
MEASURED_TOPICS: Mapping[str, tuple[str, ...]] = {
    "joint_states": (
        "rotor_position_rad",
        "rotor_velocity_rad_per_s",
        "rotor_torque_nm",
        "rod_position_m",
        "rod_velocity_m_per_s",
        "rod_force_n",
    ),
    "current": ("current_d_a", "current_q_a"),
    "voltage": ("voltage_d_v", "voltage_q_v"),
}
REFERENCE_SIGNALS = ("reference_position_m", "reference_velocity_m_per_s")

SILENT_S = 0.5  # wall time of others after which they no longer wait for a topic
_GATHER_S = 0.2  # wall time to let the topics of a drive find us before the twin begins
_LONG_GAP_NS = 20_000_000  # a gap in the reference that the loop would notice
_GAP_STEPS = 3.0
_MOST_TICKS = 20_000  # at a time, so that what comes meanwhile is taken
_KEPT_NS = 1_000_000_000  # of what waits without a reference


class Monitor:
    """One drive and its twin.

    Put in what comes with `put`, call `step` often and `judge` now and then; all give at once.

    Attributes:
        beginnings: times the twin began. why: reason of the latest beginning.
        settled_ns: stamp from which on residuals count, None before a beginning.
        compared: samples compared so far, by topic.
        lost: samples that came too late to be compared.
    """

    def __init__(self, drive: DriveParameters, window_s: float) -> None:
        """drive: the nominal model. window_s: length of what is judged, s of the drive's time."""
        self.streams = Streams({REFERENCE: REFERENCE_SIGNALS, **MEASURED_TOPICS})
        self.beginnings = 0
        self.why = ""
        self.settled_ns: int | None = None
        self.compared = dict.fromkeys(MEASURED_TOPICS, 0)
        self.lost = 0
        self._window_s = window_s
        self._run = 0
        self._waiting_since: float | None = None
        self._model(drive)

    def _model(self, drive: DriveParameters) -> None:
        self.drive = drive
        self._noise = declared_noise(drive)
        self._settling_ns = round(settling_time_s(drive) * 1e9)
        self._window = Window(drive, self._window_s)
        self._twin: Twin | None = None
        self._columns = {
            key: [_simulated(name, drive) for name in names]
            for key, names in MEASURED_TOPICS.items()
        }

    def put(self, key: str, stamp_ns: StampArray, values: FloatArray, now_s: float) -> None:
        """Samples of one topic, `reference` or one of `MEASURED_TOPICS`, in the order they came.

        stamp_ns: int64[n]. values: float64[n, signals]. now_s: on any steady clock.
        """
        if key == REFERENCE:
            known = np.isfinite(values[:, 0])
            stamp_ns, values = stamp_ns[known], values[known]
        self.streams.put(key, stamp_ns, values, now_s)

    def change(self, drive: DriveParameters) -> None:
        """Restart with another model."""
        self._model(drive)
        self._end("the model was changed")

    @property
    def heard(self) -> tuple[str, ...]:
        """Topics of this run that have not fallen silent while others went on."""
        there = self.streams.of_run()
        latest = max((stream.heard_s for stream in there.values()), default=0.0)
        return tuple(key for key, stream in there.items() if latest - stream.heard_s < SILENT_S)

    @property
    def is_running(self) -> bool:
        """Whether the twin runs."""
        return self._twin is not None

    def step(self, now_s: float) -> dict[str, tuple[StampArray, FloatArray]]:
        """Run the twin as far as it can, and compare.

        Returns for each topic with news stamps, int64[n], and recorded less simulated in the order
        of `MEASURED_TOPICS`, float64[n, signals] in SI units, NaN where not measured.
        """
        if self._run != self.streams.run:
            self._run = self.streams.run
            self._end(f"{self.streams.reason}: the drive restarted")
        if self._twin is None and not self._begin(now_s):
            self._forget()
            return {}
        twin = self._twin
        assert twin is not None
        reference = self.streams.by_key[REFERENCE]
        gap = self._gap_in(reference)
        edges = None if gap is None else [int(one) for one in reference.stamp_ns[gap : gap + 2]]
        newest = [reference.newest_ns if edges is None else edges[0]]
        newest += [self.streams.by_key[key].newest_ns for key in self.heard if key != REFERENCE]
        horizon = min(one for one in newest if one is not None)
        last = min(twin.tick_of(horizon), twin.ticks - 1 + _MOST_TICKS)
        if last >= twin.ticks:
            rows = slice(0, None if gap is None else gap + 1)
            twin.advance(
                last,
                reference.stamp_ns[rows],
                reference.values[rows, 0],
                reference.values[rows, 1],
            )
        found = self._compare(twin)
        self._drop_reference(twin, reference)
        if self._ran_away(found):
            self._end("the twin ran away from the measurement")
        elif edges is not None and last >= twin.tick_of(edges[0]):
            self._skip(*edges)
        return found

    def judge(self, place: bool = True) -> GapNow | None:
        """The gap in the window; None while too little is compared or settled.

        place: also where it lies; without, only how large it is.
        """
        return self._window.judge(place)

    # --- beginnings ----------------------------------------------------------------------------

    def _begin(self, now_s: float) -> bool:
        there = self.streams.of_run()
        reference = there.get(REFERENCE)
        others = {key: one for key, one in there.items() if key != REFERENCE and one.stamp_ns.size}
        if reference is None or reference.stamp_ns.size < 2 or not others:
            self._waiting_since = None
            return False
        if len(others) < len(MEASURED_TOPICS):
            if self._waiting_since is None:
                self._waiting_since = now_s
            if now_s - self._waiting_since < _GATHER_S:
                return False
        main = others.get("joint_states") or next(iter(others.values()))
        earliest = max(int(one.stamp_ns[0]) for one in (reference, *others.values()))
        row = int(np.searchsorted(main.stamp_ns, earliest))
        if row >= len(main.stamp_ns) or main.stamp_ns[row] > int(reference.stamp_ns[-1]):
            return False
        begin_ns = int(main.stamp_ns[row])
        first = {
            name: float(value)
            for key, names in MEASURED_TOPICS.items()
            for name, value in zip(names, self.streams.by_key[key].at(begin_ns), strict=True)
        }
        wanted, wanted_speed = _reference_at(reference, begin_ns)
        state = state_from(first, wanted, wanted_speed, self.drive, self._noise)
        self._twin = Twin(self.drive, begin_ns, state)
        self.settled_ns = begin_ns + (0 if state.at_rest else self._settling_ns)
        self.beginnings += 1
        self._waiting_since = None
        for stream in others.values():
            stream.drop(int(np.searchsorted(stream.stamp_ns, begin_ns)))
        return True

    def _end(self, why: str) -> None:
        self._twin = None
        self.settled_ns = None
        self._window.clear()
        self.why = why

    def _forget(self) -> None:
        """What waits without a twin is kept for a second only."""
        for stream in self.streams.by_key.values():
            if stream.newest_ns is not None and stream.stamp_ns.size:
                old = np.searchsorted(stream.stamp_ns, stream.newest_ns - _KEPT_NS)
                stream.drop(int(old))

    def _gap_in(self, reference: Stream) -> int | None:
        """Row of the reference's last sample before the first gap in it."""
        limit = max(_LONG_GAP_NS, _GAP_STEPS * _or(reference.period_ns, 0.0))
        rows = np.flatnonzero(np.diff(reference.stamp_ns) > limit)
        return int(rows[0]) if rows.size else None

    def _skip(self, before: int, after: int) -> None:
        """Restart behind a gap in the reference."""
        self._end(f"no reference for {(after - before) / 1e9:.3g} s")
        for stream in self.streams.by_key.values():
            stream.drop(int(np.searchsorted(stream.stamp_ns, after)))

    def _ran_away(self, found: Mapping[str, tuple[StampArray, FloatArray]]) -> bool:
        """Whether model and machine are further apart than the stroke is long."""
        _, left = found.get("joint_states", (None, np.zeros((0, 6))))
        limits, ratio = self.drive.limits, self.drive.transmission.rod_per_rotor
        stroke = limits.stroke_max - limits.stroke_min
        apart = np.maximum(np.abs(left[:, 0]) * ratio, np.abs(left[:, 3]))
        return bool((apart > stroke).any() or np.isinf(left).any())

    # --- comparison ----------------------------------------------------------------------------

    def _compare(self, twin: Twin) -> dict[str, tuple[StampArray, FloatArray]]:
        found = {}
        for key, stream in self.streams.of_run().items():
            if key == REFERENCE:
                continue
            count = twin.ready(stream.stamp_ns)
            if not count:
                continue
            stamps, recorded = stream.stamp_ns[:count], stream.values[:count]
            stream.drop(count)
            simulated, noise, square = twin.at(stamps)
            known = np.isfinite(simulated[:, 0])
            self.lost += int(count - known.sum())
            stamps, recorded = stamps[known], recorded[known]
            simulated, noise, square = simulated[known], noise[known], square[known]
            if not stamps.size:
                continue
            self.compared[key] += len(stamps)
            left = recorded - np.column_stack(
                [factor * simulated[:, column] for column, factor in self._columns[key]]
            )
            found[key] = (stamps, left)
            settled = stamps >= (self.settled_ns or 0)
            self._window.put(
                key,
                Compared(
                    stamps[settled],
                    MEASURED_TOPICS[key],
                    recorded[settled],
                    simulated[settled],
                    noise[settled],
                    square[settled],
                ),
            )
        return found

    def _drop_reference(self, twin: Twin, reference: Stream) -> None:
        """Keep what lies around the next tick."""
        now_ns = twin.begin_ns + twin.ticks / self.drive.controller.rate * 1e9
        row = int(np.searchsorted(reference.stamp_ns, now_ns)) - 2
        reference.drop(max(row, 0))


def _simulated(name: str, drive: DriveParameters) -> tuple[int, float]:
    """Column of the engine's samples that a signal is compared with, and its factor."""
    if name == "rotor_torque_nm":
        return MEASUREMENT + MEASURED.index("current_q_a"), drive.motor.torque_constant
    if name == "rod_force_n":
        torque = MEASUREMENT + MEASURED.index("transmitted_torque_nm")
        return torque, 1.0 / drive.transmission.rod_per_rotor
    if name in MEASURED:
        return MEASUREMENT + MEASURED.index(name), 1.0
    return VOLTAGE + ("voltage_d_v", "voltage_q_v").index(name), 1.0


def _reference_at(reference: Stream, stamp_ns: int) -> tuple[float, float]:
    """Position and rate of the reference at an instant, m and m/s."""
    at: Sequence[float] = ((reference.stamp_ns - stamp_ns) * 1e-9).tolist()
    position, velocity = reference.values[:, 0], reference.values[:, 1]
    wanted = float(np.interp(0.0, at, position))
    row = int(np.clip(np.searchsorted(at, 0.0, side="right") - 1, 0, len(at) - 2))
    rate = float(velocity[row])
    if math.isnan(rate):
        rate = float((position[row + 1] - position[row]) / (at[row + 1] - at[row]))
    return wanted, rate


def _or(value: float, otherwise: float) -> float:
    return value if math.isfinite(value) else otherwise


def rehearse(drive: DriveParameters) -> None:
    """Compile, or load from cache, all that a monitor of this drive will call.

    A second's standstill with a rotor that is off by a little, so that the gap is placed too.
    """
    monitor = Monitor(drive, 1.0)
    stamps = np.arange(500, dtype=np.int64) * 2_000_000
    monitor.put(REFERENCE, stamps, np.zeros((len(stamps), 2)), 0.0)
    for key, names in MEASURED_TOPICS.items():
        values = np.zeros((len(stamps), len(names)))
        values[1:, 0] = 1.0 + 1e-3 * np.arange(1, len(stamps))
        monitor.put(key, stamps, values, 0.0)
    for _ in range(-(-round(drive.controller.rate) // _MOST_TICKS) + 1):
        monitor.step(0.0)
    monitor.judge()
