"""The analyser node: tracking error of the rod while the drive runs, and its figures."""

from __future__ import annotations

import math
from collections import deque

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from ..analysis.running import RunningTracking
from ..errors import InputError
from . import wire
from .drive_node import DriveNode
from .run_node import run_node

PLANT_STATUS = "plant timing"
# Values of the plant's timing status that are repeated beside the tracking figures.
TIMING_KEYS = (
    "missed_ticks",
    "late_ticks",
    "stale_ticks",
    "jitter_p50_s",
    "jitter_p99_s",
    "jitter_p999_s",
    "jitter_max_s",
)
UNMATCHED = 10_000  # references kept while their measurement is on its way


class Analyser(DriveNode):
    """Publishes `ecyl/tracking_error` per sample and, on `/diagnostics`, running figures."""

    batch_s = 2e-3

    def __init__(self, **options) -> None:
        super().__init__(
            "analyser",
            {"window": (4.0, "s over which the running figures are taken")},
            **options,
        )
        window = self.option("window")
        if window <= 0.0:
            raise InputError(f"node analyser: window = {window:g}, expected more than 0 s")
        self._tracking = RunningTracking(window)
        self._references: deque[tuple[int, float, float]] = deque(maxlen=UNMATCHED)
        self._positions: deque[tuple[int, float, float, Header]] = deque(maxlen=UNMATCHED)
        self._sample_ns = round(wire.NANOSECONDS / self.drive.sample_rate)
        self._last_ns: int | None = None
        self._gaps = 0
        self._timing: dict[str, str] = {}
        self._error = self.create_publisher(JointState, wire.TRACKING_ERROR, 64)
        self.create_subscription(JointState, wire.REFERENCE, self._on_reference, wire.lossless())
        self.create_subscription(
            JointState, wire.JOINT_STATES, self._on_joint_states, wire.lossless()
        )
        self._plant_status = self.status_name(PLANT_STATUS)
        self.create_subscription(DiagnosticArray, wire.DIAGNOSTICS, self._on_diagnostics, 10)
        self.create_timer(1.0, self._publish_figures, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _on_reference(self, message: JointState) -> None:
        self.heard_partner()
        velocity = message.velocity[0] if len(message.velocity) else math.nan
        stamp_ns = wire.to_ns(message.header.stamp)
        self._begin_again_if(stamp_ns, self._references)
        self._references.append((stamp_ns, message.position[0], velocity))
        self._match()

    def _on_joint_states(self, message: JointState) -> None:
        self.heard_partner()
        if wire.ROD not in message.name:
            return
        rod = list(message.name).index(wire.ROD)
        stamp_ns = wire.to_ns(message.header.stamp)
        velocity = message.velocity[rod] if len(message.velocity) > rod else math.nan
        self._begin_again_if(stamp_ns, self._positions)
        self._positions.append((stamp_ns, message.position[rod], velocity, message.header))
        self._match()

    def _begin_again_if(self, stamp_ns: int, waiting: deque) -> None:
        """A stamp that goes back means a new run: what waits from the old one has no partner."""
        if waiting and stamp_ns <= waiting[-1][0]:
            self._references.clear()
            self._positions.clear()
            self._last_ns = None

    def _match(self) -> None:
        """Pair reference and position by stamp; both come in order."""
        references, positions = self._references, self._positions
        while references and positions:
            stamp_ns, reference, reference_velocity = references[0]
            other_ns, position, velocity, header = positions[0]
            if stamp_ns < other_ns:
                references.popleft()
            elif other_ns < stamp_ns:
                positions.popleft()
            else:
                references.popleft()
                positions.popleft()
                self._take(stamp_ns, reference, position)
                self._error.publish(
                    JointState(
                        header=Header(stamp=header.stamp, frame_id=wire.ROD_FRAME),
                        name=[wire.ROD],
                        position=[reference - position],
                        velocity=[reference_velocity - velocity],
                    )
                )

    def _take(self, stamp_ns: int, reference: float, position: float) -> None:
        if self._last_ns is not None and stamp_ns > self._last_ns:
            self._gaps += max(0, round((stamp_ns - self._last_ns) / self._sample_ns) - 1)
        self._last_ns = stamp_ns
        self._tracking.update(stamp_ns, reference, position)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == self._plant_status:
                values = {item.key: item.value for item in status.values}
                self._timing = {key: values[key] for key in TIMING_KEYS if key in values}

    def _publish_figures(self) -> None:
        figures = self._tracking.figures()
        if not figures.samples:
            return
        lines = {
            f"line_{rank}": f"{line.frequency_hz:.4g} Hz, {line.amplitude:.4g} m"
            for rank, line in enumerate(figures.lines, start=1)
        }
        values = {
            "window_s": f"{figures.duration_s:.6g}",
            "error_rms_m": f"{figures.error_rms_m:.6g}",
            "error_std_m": f"{figures.error_std_m:.6g}",
            "error_max_m": f"{figures.error_max_m:.6g}",
            "lag_s": f"{figures.lag.lag_s:.6g}",
            "gain": f"{figures.lag.gain:.6g}",
            **lines,
            "samples_missing": str(self._gaps),
            **self._timing,
        }
        late = float(self._timing.get("missed_ticks", 0)) > 0
        self.report(
            DiagnosticStatus.WARN if late or self._gaps else DiagnosticStatus.OK,
            "analyser tracking",
            f"rms error {figures.error_rms_m:.3g} m over {figures.duration_s:.3g} s",
            values,
        )

    def waiting_for(self) -> str | None:
        """The plant, always."""
        return "a plant on " + self.resolve_topic_name(wire.JOINT_STATES)


def main(args: list[str] | None = None) -> int:
    """Entry point of `analyser`."""
    return run_node(Analyser, args)
