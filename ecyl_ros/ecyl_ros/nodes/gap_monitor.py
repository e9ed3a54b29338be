"""The gap monitor: the nominal model beside a running drive, and where the two differ now.

Listens to the telemetry of any drive that sends it, emulated or real, and only listens.
"""

from __future__ import annotations

import time
from functools import partial

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
from rclpy.clock import Clock, ClockType
from rclpy.publisher import Publisher
from rclpy.qos import QoSPolicyKind, QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from ..arrays import FloatArray
from ..drive.parameters import DriveParameters
from ..drive.stability import check_stability
from ..errors import InputError
from ..gap.live.monitor import MEASURED_TOPICS, REFERENCE, REFERENCE_SIGNALS, Monitor, rehearse
from ..gap.live.window import GapNow
from ..gap.replay.replay import SIGNALS
from ..recording import cdr
from ..recording.topics import CURRENT, JOINT_STATE, JOINT_STATES, VECTOR3_STAMPED, VOLTAGE
from ..recording.topics import REFERENCE as REFERENCE_TOPIC
from . import wire
from .drive_node import DriveNode
from .realtime import with_transport_delay
from .run_node import run_node

STEP_S = 0.02  # messages are decoded and compared in batches
LEVELS_S = 0.5
SILENT_S = 2.0  # of all topics, from which on the drive counts as silent
QUEUE = 1000

_TOPICS = {
    REFERENCE: (wire.REFERENCE, JointState, JOINT_STATE, REFERENCE_TOPIC),
    "joint_states": (wire.JOINT_STATES, JointState, JOINT_STATE, JOINT_STATES),
    "current": (wire.CURRENT, Vector3Stamped, VECTOR3_STAMPED, CURRENT),
    "voltage": (wire.VOLTAGE, Vector3Stamped, VECTOR3_STAMPED, VOLTAGE),
}
_RESIDUALS = {
    "joint_states": wire.GAP_JOINT_STATES,
    "current": wire.GAP_CURRENT,
    "voltage": wire.GAP_VOLTAGE,
}
_WHEN = {
    "reversal": "around reversals",
    "rest": "at rest",
    "low_speed": "at low speed",
    "high_speed": "at high speed",
    "acceleration": "while accelerating",
    "high_torque": "at high torque",
    "position": "on a tenth of the stroke",
    "time": "within a tenth of the time",
}


class GapMonitor(DriveNode):
    """Publishes residuals per sample, their level twice a second, and the gap's place."""

    batch_s = 5e-3
    live = ("motor.", "transmission.", "load.", "controller.", "sensors.")

    def __init__(self, **options) -> None:
        super().__init__(
            "gap_monitor",
            {
                "window": (4.0, "s of the drive's time that are judged"),
                "rotor_joint": (wire.ROTOR, "name of the rotor in joint_states"),
                "rod_joint": (wire.ROD, "name of the rod in joint_states and reference"),
            },
            **options,
        )
        window = self.option("window")
        if window < 1.0:
            raise InputError(f"node gap_monitor: window = {window:g}, expected 1 s or more")
        if self.option("realtime"):
            self.drive = with_transport_delay(self.drive, self.get_logger())
        check_stability(self.drive, "node gap_monitor")
        rehearse(self.drive)  # before anything comes that would have to wait
        self._monitor = Monitor(self.drive, window)
        joints = {wire.ROTOR: self.option("rotor_joint"), wire.ROD: self.option("rod_joint")}
        self._paths = {key: _paths(key, joints) for key in _TOPICS}
        self._joints = [joints[wire.ROTOR], joints[wire.ROD]]
        self._waiting: dict[str, list[bytes]] = {key: [] for key in _TOPICS}
        self._arrived: dict[str, float] = {}
        self._received = dict.fromkeys(_TOPICS, 0)
        self._unreadable = 0
        self._beginnings = 0
        self._silent = False
        self._started = time.monotonic()

        self._residuals = {
            key: self.create_publisher(_TOPICS[key][1], topic, QoSProfile(depth=QUEUE))
            for key, topic in _RESIDUALS.items()
        }
        self._levels: dict[str, Publisher] = {}
        overriding = QoSOverridingOptions(
            [QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY]
        )
        for key, (topic, kind, _, _) in _TOPICS.items():
            self.create_subscription(
                kind,
                topic,
                partial(self._on_message, key),
                wire.lossless(),
                raw=True,
                qos_overriding_options=overriding,
            )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(STEP_S, self._step, clock=steady)
        self.create_timer(LEVELS_S, self._publish_levels, clock=steady)
        self.create_timer(1.0, self._report_gap, clock=steady)

    # --- in ------------------------------------------------------------------------------------

    def _on_message(self, key: str, data: bytes) -> None:
        self.handled += 1
        self._waiting[key].append(bytes(data))

    def _step(self) -> None:
        """Hand over what has come, let the twin catch up, say the residuals."""
        now = time.monotonic()
        for key, waiting in self._waiting.items():
            if waiting:
                self._waiting[key] = []
                self._arrived[key] = now
                self._received[key] += len(waiting)
                self._take(key, waiting, now)
        found = self._monitor.step(now)
        if self._monitor.beginnings > self._beginnings:
            self._beginnings = self._monitor.beginnings
            why = self._monitor.why
            self.get_logger().info(f"the twin restarts: {why}" if why else "the twin begins")
        for key, (stamps, left) in found.items():
            if self._residuals[key].get_subscription_count():
                self._publish_residuals(key, stamps, left)

    def _take(self, key: str, messages: list[bytes], now: float) -> None:
        kind, paths = _TOPICS[key][2], self._paths[key]
        try:
            stamps, values, _ = cdr.decode(kind, messages, paths)
        except cdr.CdrError as error:
            if len(messages) > 1:
                for one in messages:
                    self._take(key, [one], now)
                return
            self._unreadable += 1
            name = self.resolve_topic_name(_TOPICS[key][0])
            self.get_logger().warning(
                f"{name}: {error}; {self._unreadable} messages left out", throttle_duration_sec=5.0
            )
            return
        self._monitor.put(key, stamps, np.column_stack([values[path] for path in paths]), now)

    # --- out -----------------------------------------------------------------------------------

    def _publish_residuals(self, key: str, stamps: np.ndarray, left: FloatArray) -> None:
        _, _, kind, spec = _TOPICS[key]
        columns = {path: left[:, column] for column, path in enumerate(self._paths[key])}
        if key != "joint_states":
            columns["vector.z"] = np.zeros(len(stamps))
        joints = self._joints if key == "joint_states" else []
        for message in cdr.encode(kind, spec.frame_id, joints, stamps, columns):
            self._residuals[key].publish(message)

    def _publish_levels(self) -> None:
        gap = self._monitor.judge(place=False) if self._is_heard() else None
        for one in gap.signals if gap is not None else ():
            if one.name not in self._levels:
                topic = f"{wire.GAP_OVER_NOISE}/{one.name}"
                self._levels[one.name] = self.create_publisher(Float64, topic, 10)
            self._levels[one.name].publish(Float64(data=one.over_noise))

    def _is_heard(self) -> bool:
        newest = max(self._arrived.values(), default=self._started)
        return bool(self._arrived) and time.monotonic() - newest < SILENT_S

    def _report_gap(self) -> None:
        if not self._is_heard():
            self._report_silence()
            return
        if self._silent:
            self._silent = False
            self.get_logger().info("the drive is heard again")
        gap = self._monitor.judge()
        level, message = self._in_words(gap)
        self.report(level, "gap_monitor gap", message, self._values(gap))

    def _report_silence(self) -> None:
        """Once: what is said of a silent drive does not change."""
        newest = max(self._arrived.values(), default=self._started)
        silent = time.monotonic() - newest
        if self._silent or silent < SILENT_S:
            return
        self._silent = True
        topics = ", ".join(self.resolve_topic_name(_TOPICS[key][0]) for key in _TOPICS)
        since = "yet" if not self._arrived else f"for {silent:.1f} s"
        self.get_logger().warning(f"nothing heard {since} on {topics}")
        self.report(
            DiagnosticStatus.STALE,
            "gap_monitor gap",
            f"the drive is silent: nothing heard {since}",
            self._values(self._monitor.judge()),
        )

    def _in_words(self, gap: GapNow | None) -> tuple[bytes, str]:
        heard = self._monitor.heard
        if REFERENCE not in heard and not self._monitor.is_running:
            name = self.resolve_topic_name(wire.REFERENCE)
            return DiagnosticStatus.WARN, f"no {name}: the model has nothing to follow"
        if not set(heard) - {REFERENCE}:
            return DiagnosticStatus.WARN, "only the reference is heard: nothing to compare"
        if gap is None:
            why = f" ({self._monitor.why})" if self._monitor.why else ""
            return DiagnosticStatus.OK, f"the twin has just started and is settling{why}"
        missing = self._missing(gap)
        tail = f"; not judged: {missing}" if missing else ""
        if not gap.is_gap:
            return DiagnosticStatus.OK, f"no gap: the residual is noise{tail}"
        first = gap.signals[0]
        words = f"gap in {_title(first.name)}, {first.over_noise:.3g} times noise"
        place = gap.condition
        if place is not None:
            words += f", {100 * place.share:.0f} % of it {_WHEN[place.condition]}"
            if place.condition not in ("position", "time"):
                words += f" ({100 * place.time_share:.0f} % of the time)"
        if gap.blocks:
            words += f"; in {' or '.join(gap.blocks)}"
        return DiagnosticStatus.WARN, words + tail

    @staticmethod
    def _missing(gap: GapNow) -> str:
        judged = {one.name for one in gap.signals}
        return ", ".join(_title(one.name) for one in SIGNALS if one.name not in judged)

    def _values(self, gap: GapNow | None) -> dict[str, str]:
        values: dict[str, str] = {}
        if gap is not None:
            values["window_s"] = f"{gap.duration_s:.6g}"
            values["samples"] = str(gap.samples)
            for one in gap.signals:
                values[f"{one.name}_over_noise"] = f"{one.over_noise:.4g}"
                unit = one.unit.replace("/", "_per_").lower()
                values[f"{one.name}_rms_{unit}"] = f"{one.rms:.4g}"
                values[f"{one.name}_floor_{unit}"] = f"{one.floor:.4g}"
            if gap.is_gap:
                values["signal"] = gap.signals[0].name
                values["condition"] = "" if gap.condition is None else gap.condition.condition
                values["block"] = " or ".join(gap.blocks)
            for port in gap.ports:
                values[f"port_{port.block}_over_noise"] = f"{port.typical_ratio:.4g}"
            values["not_judged"] = self._missing(gap)
        heard = self._monitor.heard
        away = [self.resolve_topic_name(_TOPICS[key][0]) for key in _TOPICS if key not in heard]
        values["topics_not_heard"] = ", ".join(away)
        return values | self._counts()

    def _counts(self) -> dict[str, str]:
        monitor = self._monitor
        streams = monitor.streams.by_key
        return {
            "samples_received": str(self._received["joint_states"]),
            "samples_compared": str(max(monitor.compared.values())),
            "samples_missing": str(sum(one.missing for one in streams.values())),
            "samples_out_of_order": str(sum(one.late for one in streams.values())),
            "samples_too_late": str(monitor.lost),
            "messages_unreadable": str(self._unreadable),
            "beginnings": str(monitor.beginnings),
            "last_beginning": monitor.why,
        }

    # --- the model -----------------------------------------------------------------------------

    def on_drive_changed(self, drive: DriveParameters) -> None:
        """Restart with a changed model."""
        check_stability(drive, "node gap_monitor")
        if drive.controller.rate != self.drive.controller.rate:
            raise InputError("controller.rate is read at start only")
        self._monitor.change(drive)


def _paths(key: str, joints: dict[str, str]) -> list[str]:
    """Field paths of a topic's signals in the order of the monitor's columns."""
    by_signal = {signal: path for path, signal in _TOPICS[key][3].signals.items()}
    found = []
    for signal in REFERENCE_SIGNALS if key == REFERENCE else MEASURED_TOPICS[key]:
        joint, _, field = by_signal[signal].rpartition(".")
        found.append(f"{joints.get(joint, joint)}.{field}")
    return found


def _title(name: str) -> str:
    return name.replace("_", " ")


def main(args: list[str] | None = None) -> int:
    """Entry point of `gap_monitor`."""
    return run_node(GapMonitor, args)
