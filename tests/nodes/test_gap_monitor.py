"""The gap monitor: fed with runs of known drives, its residuals and its words are as they must."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import HistoryPolicy, QoSProfile
from scipy.interpolate import CubicSpline
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from ecyl_ros.drive.drive_file import load_drive, resolve_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.reference.spec import make_reference
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.gap.live.monitor import MEASURED_TOPICS, REFERENCE, REFERENCE_SIGNALS, Monitor
from ecyl_ros.gap.replay.sensor_noise import silent
from ecyl_ros.nodes.gap_monitor import GapMonitor
from ecyl_ros.recording import cdr
from ecyl_ros.recording.signals import Recording
from ecyl_ros.recording.topics import JOINT_STATE, TOPICS

from .conftest import SINE, node

SWING = "sine:amplitude=5e-3,frequency=1"
STATUS = "ecyl/gap_monitor gap"
CHUNK = 50  # samples at a time


def recorded(
    drive: DriveParameters, seconds: float, effects: dict | None = None, *, reference: str = SWING
) -> Recording:
    """A run of the drive with these effects and noise that no twin draws."""
    sensors = dataclasses.replace(drive.sensors, noise_seed=4711)
    worn = dataclasses.replace(drive, effects=effects or {}, sensors=sensors)
    follow = make_reference(reference, worn, seconds)
    run = simulate(worn, lambda index: follow.sample(index / worn.sample_rate), seconds)
    return simulation_recording(run, worn)


def shifted(recording: Recording, by_s: float) -> Recording:
    """The same with later stamps."""
    return dataclasses.replace(recording, stamp_ns=recording.stamp_ns + round(by_s * 1e9))


class Bench(Node):
    """Sends recordings to a monitor in the same process and keeps what it says."""

    def __init__(self, drive: str = "bench", **own: object) -> None:
        super().__init__("bench")
        everything = QoSProfile(history=HistoryPolicy.KEEP_ALL, depth=0)
        kinds = {JOINT_STATE: JointState}
        self.outputs = {
            topic.key: self.create_publisher(
                kinds.get(topic.type, Vector3Stamped), topic.name, everything
            )
            for topic in TOPICS
        }
        self.reports: list[DiagnosticStatus] = []
        self.residuals: list[tuple[int, float, float]] = []  # stamp ns, rotor rad, rod m
        self.levels: list[float] = []
        self.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 100)
        self.create_subscription(
            JointState, "/ecyl/gap/joint_states", self._on_residual, everything
        )
        self.create_subscription(
            Float64, "/ecyl/gap/over_noise/rotor_position", self._on_level, everything
        )
        self.monitor = GapMonitor(
            cli_args=["--ros-args", "--params-file", str(resolve_drive(drive))],
            parameter_overrides=[Parameter(key, value=value) for key, value in own.items()],
        )
        self.executor_ = SingleThreadedExecutor()
        for one in (self, self.monitor):
            self.executor_.add_node(one)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        self.reports += [status for status in message.status if status.name == STATUS]

    def _on_residual(self, message: JointState) -> None:
        stamp = message.header.stamp
        self.residuals.append(
            (stamp.sec * 10**9 + stamp.nanosec, message.position[0], message.position[1])
        )

    def _on_level(self, message: Float64) -> None:
        self.levels.append(message.data)

    def until(self, condition: Callable[[], bool], seconds: float = 60.0) -> bool:
        """Spin until a condition holds."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self.executor_.spin_once(timeout_sec=0.02)
            if condition():
                return True
        return False

    def send(self, recording: Recording, *, without: tuple[str, ...] = ()) -> None:
        """Publish a recording as fast as the monitor takes it."""
        for start in range(0, len(recording), CHUNK):
            part = slice(start, start + CHUNK)
            count = 0
            for topic in TOPICS:
                if topic.key in without:
                    continue
                columns = {
                    path: recording.signal(signal)[part]
                    for path, signal in topic.signals.items()
                    if path.split(".")[0] in (*topic.joints, "vector")
                }
                if topic.key in ("current", "voltage"):
                    columns["vector.z"] = np.zeros(len(recording.stamp_ns[part]))
                for message in cdr.encode(
                    topic.type, topic.frame_id, topic.joints, recording.stamp_ns[part], columns
                ):
                    self.outputs[topic.key].publish(message)
                    count += 1
            wanted = self.monitor.handled + count
            assert self.until(lambda wanted=wanted: self.monitor.handled >= wanted)

    def report(self, fresh: Callable[[DiagnosticStatus], bool] | None = None) -> DiagnosticStatus:
        """The next status that is `fresh`, or simply the next one, while the drive goes on."""
        seen = len(self.reports)
        wanted = fresh or (lambda _: True)
        assert self.until(lambda: any(wanted(one) for one in self.reports[seen:])), [
            one.message for one in self.reports
        ]
        return next(one for one in self.reports[seen:] if wanted(one))

    def judged(self) -> DiagnosticStatus:
        """The next status about a gap or none."""
        return self.report(lambda one: "gap" in one.message)

    def close(self) -> None:
        """End both nodes."""
        self.executor_.shutdown()
        self.monitor.destroy_node()
        self.destroy_node()


def values_of(status: DiagnosticStatus) -> dict[str, str]:
    """Values of a status by key."""
    return {item.key: item.value for item in status.values}


@pytest.fixture
def bench() -> Iterator[Bench]:
    """A monitor of the bench drive, and who talks to it."""
    rclpy.init(args=[])
    made = Bench()
    yield made
    made.close()
    rclpy.try_shutdown()


def feed(
    monitor: Monitor, recording: Recording, begin_s: float = 0.0
) -> dict[str, list[np.ndarray]]:
    """Send a recording to a monitor without a node; residuals by topic."""
    found: dict[str, list[np.ndarray]] = {}
    now = begin_s
    for start in range(0, len(recording), CHUNK):
        part = slice(start, start + CHUNK)
        now += CHUNK * 1e-3
        for key, names in {REFERENCE: REFERENCE_SIGNALS, **MEASURED_TOPICS}.items():
            values = np.column_stack([recording.signal(name)[part] for name in names])
            monitor.put(key, recording.stamp_ns[part], values, now)
        for key, (_, left) in monitor.step(now).items():
            found.setdefault(key, []).append(left)
    return found


def test_residuals_are_the_recorded_less_a_run_of_the_engine(bench: Bench) -> None:
    """Healthy drive: residuals equal recorded less `simulate`, rms 1 floor, no sample missed."""
    drive = load_drive("bench")
    run = recorded(drive, 5.0)
    bench.send(run)
    status = bench.judged()
    values = values_of(status)
    follow = make_reference(SWING, drive, 5.0)
    model = simulate(silent(drive), lambda index: follow.sample(index / 1000.0), 5.0)
    assert [stamp for stamp, _, _ in bench.residuals] == run.stamp_ns.tolist()
    expected = run.rotor_position_rad - model.signal("rotor_position_rad")
    left = np.array(bench.residuals)[:, 1]
    assert np.abs(left - expected).max() < 1e-3 * expected.std()
    assert status.level == DiagnosticStatus.OK and "no gap" in status.message, status.message
    assert 0.9 < float(values["current_q_over_noise"]) < 1.1
    assert 0.9 < float(values["rod_position_over_noise"]) < 1.1
    assert float(values["samples_compared"]) == len(run)
    assert values["samples_missing"] == values["samples_too_late"] == "0"
    assert values["not_judged"] == values["topics_not_heard"] == ""


@pytest.mark.parametrize(
    ("effect", "signal", "block", "condition"),
    [
        ({"resistance_error": {"resistance_ohm": 1.1}}, "voltage_q", "motor_electrical", None),
        ({"lead_error": {"lead_m": 0.0201}}, "rod_position", "transmission or sensor", None),
        ({"load_coulomb_friction": {"coulomb_nm": 0.1}}, "rotor_position", "load", "reversal"),
        ({"current_sensor_offset": {"offset_a": 0.3}}, "current_q", "sensor", None),
    ],
)
def test_an_effect_stands_out_where_it_acts(
    bench: Bench, effect: dict, signal: str, block: str, condition: str | None
) -> None:
    """A drive with an effect: WARN names the signal, block and condition that the effect has."""
    bench.send(recorded(load_drive("bench"), 4.5, effect))
    status = bench.judged()
    values = values_of(status)
    assert status.level == DiagnosticStatus.WARN, status.message
    assert values["signal"] == signal and values["block"] == block, status.message
    assert condition is None or values["condition"] == condition
    assert signal.replace("_", " ") in status.message and block in status.message


def test_the_level_is_published_twice_a_second(bench: Bench) -> None:
    """`over_noise/rotor_position` is the residual's rms over what noise leaves: friction shows."""
    effect = {"rotor_viscous_friction": {"viscous_nm_s_per_rad": 5e-3}}
    run = recorded(load_drive("bench"), 4.0, effect)
    bench.send(run)
    assert bench.until(lambda: len(bench.levels) > 2)
    rms = np.sqrt(np.mean(np.array(bench.residuals)[:, 1] ** 2))
    values = values_of(bench.judged())
    assert float(values["rotor_position_rms_rad"]) == pytest.approx(rms, rel=0.02)
    assert bench.levels[-1] == pytest.approx(float(values["rotor_position_over_noise"]), rel=0.01)


def test_a_drive_that_begins_anew_is_taken_up(bench: Bench) -> None:
    """Stamps go back to 0: the twin restarts from the start, and no sample of it is missed."""
    run = recorded(load_drive("bench"), 3.0)
    bench.send(run)
    assert bench.until(lambda: len(bench.residuals) == len(run))
    bench.send(run)
    status = bench.judged()
    values = values_of(status)
    assert values["beginnings"] == "2" and "stamps went back by 3 s" in values["last_beginning"]
    assert status.level == DiagnosticStatus.OK, status.message
    assert len(bench.residuals) == 2 * len(run)
    assert bench.residuals[len(run)][0] == 0


def test_silence_is_said_once_and_ends(bench: Bench) -> None:
    """Nothing heard: STALE once; heard again with the stamps going on: as if nothing had been."""
    run = recorded(load_drive("bench"), 4.0)
    bench.send(run.slice(0.0, 2.5))
    bench.report(lambda one: one.level == DiagnosticStatus.STALE)
    seen = len(bench.reports)
    bench.until(lambda: False, 2.5)
    assert len(bench.reports) == seen
    bench.send(run.slice(2.5))
    status = bench.judged()
    assert status.level == DiagnosticStatus.OK, status.message
    assert values_of(status)["beginnings"] == "1"
    assert len(bench.residuals) == len(run)


def test_without_voltage_the_rest_is_judged(bench: Bench) -> None:
    """No ecyl/voltage: the status says so, and the gap of the other signals is found."""
    effect = {"load_coulomb_friction": {"coulomb_nm": 0.1}}
    bench.send(recorded(load_drive("bench"), 4.0, effect), without=("voltage",))
    status = bench.judged()
    values = values_of(status)
    assert status.level == DiagnosticStatus.WARN
    assert "not judged: voltage q" in status.message
    assert values["topics_not_heard"] == "/ecyl/voltage" and values["signal"] == "rotor_position"


def test_without_a_reference_it_says_what_it_needs(bench: Bench) -> None:
    """No ecyl/reference: WARN names it, nothing is compared."""
    bench.send(recorded(load_drive("bench"), 1.0), without=("reference",))
    status = bench.report()
    assert status.level == DiagnosticStatus.WARN and "no /ecyl/reference" in status.message
    assert not bench.residuals


def test_a_gap_in_the_stamps_begins_the_twin_anew(bench: Bench) -> None:
    """Half a second is missing: the twin restarts in motion, settles, and finds no gap."""
    run = recorded(load_drive("bench"), 5.0)
    bench.send(run.slice(0.0, 1.3))
    bench.send(run.slice(1.8))
    status = bench.judged()
    values = values_of(status)
    assert status.level == DiagnosticStatus.OK, status.message
    assert values["beginnings"] == "2" and "no reference for 0.501 s" in values["last_beginning"]
    assert int(values["samples_missing"]) == 4 * 500  # of four topics


def test_the_model_can_be_changed_while_it_runs(bench: Bench) -> None:
    """The resistance set to what the drive has: the gap is gone."""
    run = recorded(load_drive("bench"), 5.5, {"resistance_error": {"resistance_ohm": 1.1}})
    bench.send(run.slice(0.0, 2.0))
    assert bench.judged().level == DiagnosticStatus.WARN
    (result,) = bench.monitor.set_parameters([Parameter("motor.resistance", value=1.1)])
    assert result.successful
    bench.send(run.slice(2.0))
    status = bench.judged()
    assert status.level == DiagnosticStatus.OK, status.message
    (result,) = bench.monitor.set_parameters([Parameter("motor.resistance", value=-1.0)])
    assert not result.successful and "motor.resistance" in result.reason


def test_what_is_no_message_is_left_out_and_counted(bench: Bench) -> None:
    """Bytes of another type on a topic: counted, and the samples around them are compared."""
    run = recorded(load_drive("bench"), 2.0)
    bench.send(run.slice(0.0, 1.0))
    bench.outputs["current"].publish(b"\0\1\0\0\1\2\3\4\5")
    bench.send(run.slice(1.0))
    values = values_of(bench.judged())
    assert values["messages_unreadable"] == "1" and values["samples_compared"] == "2000"


@pytest.mark.parametrize("profile", ["bench", "servo_1khz"])
def test_a_drive_joined_in_motion_shows_no_gap(profile: str) -> None:
    """Begun from one sample in motion, the twin comes to the machine's track: no gap."""
    drive = load_drive(profile)
    monitor = Monitor(drive, 4.0)
    feed(monitor, recorded(drive, 12.0).slice(1.37))
    gap = monitor.judge()
    assert gap is not None and not gap.is_gap, gap
    assert monitor.beginnings == 1


def test_stamps_between_ticks_are_compared_at_their_instants() -> None:
    """300 Hz on a 10 kHz loop, stamps off its ticks: residuals as a spline of the run gives."""
    drive = silent(load_drive("bench"))
    fast = dataclasses.replace(drive, telemetry_rate=drive.controller.rate)
    run = recorded(fast, 3.0)
    stamps = (np.arange(1, 895) * 1e9 / 300.3).astype(np.int64)
    # The reference keeps its own stamps.
    signals = {
        name: CubicSpline(run.time_s, run.signal(name))(stamps * 1e-9)
        for names in MEASURED_TOPICS.values()
        for name in names
    }
    monitor = Monitor(drive, 4.0)
    left: list[np.ndarray] = []
    measured = {"rotor": 0, "rod": 3}
    for second in range(30):
        span = slice(second * 1000, (second + 1) * 1000)
        rows = slice(*np.searchsorted(stamps, [second * 10**8, (second + 1) * 10**8]))
        columns = [run.signal(name)[span][::10] for name in REFERENCE_SIGNALS]
        monitor.put(REFERENCE, run.stamp_ns[span][::10], np.column_stack(columns), 0.1 * second)
        for key, names in MEASURED_TOPICS.items():
            values = np.column_stack([signals[name][rows] for name in names])
            monitor.put(key, stamps[rows], values, 0.1 * second)
        found = monitor.step(0.1 * second)
        if "joint_states" in found:
            left.append(found["joint_states"][1])
    residual = np.concatenate(left)
    assert len(residual) >= 880
    assert monitor.settled_ns is not None
    settled = stamps[: len(residual)] > monitor.settled_ns
    # What is left is less than noise would be, by far; at impacts two interpolations differ.
    rms = np.sqrt(np.mean(residual[settled] ** 2, axis=0))
    noise = load_drive("bench").sensors
    assert rms[measured["rotor"]] < 0.2 * noise.rotor_position_noise
    assert rms[measured["rod"]] < 0.2 * noise.rod_position_noise


def test_topics_of_an_old_run_do_not_mix_with_a_new_one() -> None:
    """Voltages of the old run that come after joint states of the new one are left out."""
    drive = load_drive("bench")
    run = recorded(drive, 2.0)
    monitor = Monitor(drive, 2.0)
    late = slice(1900, 2000)
    voltage = np.column_stack([run.voltage_d_v, run.voltage_q_v])
    for start, stop in ((0, 1900), (1900, 2000)):
        for key, names in {REFERENCE: REFERENCE_SIGNALS, **MEASURED_TOPICS}.items():
            if key == "voltage" and start == 1900:
                continue
            values = np.column_stack([run.signal(name)[start:stop] for name in names])
            monitor.put(key, run.stamp_ns[start:stop], values, 0.0)
    joints = np.column_stack([run.signal(name) for name in MEASURED_TOPICS["joint_states"]])
    monitor.put("joint_states", run.stamp_ns[:100], joints[:100], 0.1)
    monitor.put("voltage", run.stamp_ns[late], voltage[late], 0.1)
    assert set(monitor.streams.of_run()) == {"joint_states"}
    monitor.put("voltage", run.stamp_ns[:100], voltage[:100], 0.1)
    assert set(monitor.streams.of_run()) == {"joint_states", "voltage"}
    assert monitor.streams.by_key["voltage"].stamp_ns.tolist() == run.stamp_ns[:100].tolist()
    assert monitor.streams.run == 1


def test_a_twin_that_runs_away_begins_anew() -> None:
    """A machine further off than its stroke is long: the twin begins from what is measured."""
    drive = load_drive("bench")
    run = recorded(drive, 2.0)
    far = dataclasses.replace(
        run, rod_position_m=run.rod_position_m + np.where(run.time_s > 1.0, 1.0, 0.0)
    )
    monitor = Monitor(drive, 2.0)
    feed(monitor, far)
    assert monitor.beginnings > 1 and "ran away" in monitor.why


def test_a_window_too_short_is_refused() -> None:
    """window = 0.2 s: one line that says what was expected, exit code 2."""
    process = node("gap_monitor", "window:=0.2")
    text, _ = process.communicate(timeout=60)
    assert process.returncode == 2
    assert text.strip().splitlines()[-1] == (
        "ecyl: node gap_monitor: window = 0.2, expected 1 s or more"
    )


def test_it_outlives_the_drive_it_watches(tmp_path: Path) -> None:
    """Processes: two lockstep runs one after the other, watched by one monitor, each judged."""
    rclpy.init(args=[])
    heard: list[DiagnosticStatus] = []
    listener = Node("listener")
    listener.create_subscription(
        DiagnosticArray,
        "/diagnostics",
        lambda message: heard.extend(one for one in message.status if one.name == STATUS),
        100,
    )
    executor = SingleThreadedExecutor()
    executor.add_node(listener)

    def until(condition: Callable[[], bool], seconds: float = 60.0) -> bool:
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline and not condition():
            executor.spin_once(timeout_sec=0.05)
        return condition()

    monitor = node("gap_monitor")
    others = []
    try:
        assert until(lambda: any(one.level == DiagnosticStatus.STALE for one in heard))
        for run in (1, 2):
            timed = "duration:=1.5"
            others = [node("controller"), node("reference", timed, f'reference:="{SINE}"')]
            plant = node("plant", timed)
            others.append(plant)
            heard.clear()
            assert until(lambda plant=plant: plant.poll() is not None), "the plant has not ended"
            assert until(lambda: any(one.level == DiagnosticStatus.STALE for one in heard))
            for process in others:
                process.kill()
                process.wait()
            last = values_of(heard[-1])
            assert last["beginnings"] == str(run)
            assert int(last["samples_compared"]) >= 1490 * run
            judged = [one for one in heard if "gap" in one.message]
            assert all(one.level == DiagnosticStatus.OK for one in judged), judged
            assert monitor.poll() is None
    finally:
        for process in (monitor, *others):
            process.kill()
            process.wait()
        executor.shutdown()
        listener.destroy_node()
        rclpy.try_shutdown()
