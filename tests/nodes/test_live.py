"""The graph while it runs: setpoints, diagnostics, parameters, real time."""

from __future__ import annotations

import json
import math
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter, parameter_value_to_python
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from ecyl_ros.analysis.tracking import analyse
from ecyl_ros.drive.drive_file import drive_from_flat, load_drive
from ecyl_ros.nodes.wire import to_ns
from ecyl_ros.recording.reader import read_recording
from tests.domains import entered

from .conftest import SINE, UNHURRIED_HZ, Listener, ecyl, ecyl_here, node, unhurried
from .processes import NodeProcess

ALL = ("recorder", "analyser", "reference", "controller", "plant")
PATIENCE_S = 60.0


def _parameters(reference: str, out: Path, *flags: str) -> dict[str, tuple[str, ...]]:
    """Each node's own, for a graph that records."""
    own = {"recorder": (f"out:={out}",), "reference": (f'reference:="{reference}"',)}
    wait = ("recorder:=recorder",)
    waiting = dict.fromkeys(("plant", "controller", "reference"), wait)
    return {name: (*flags, *own.get(name, ()), *waiting.get(name, ())) for name in ALL}


def _end(nodes: dict[str, NodeProcess]) -> None:
    """End a graph as the launcher does: the recorder last."""
    for names in (("plant",), ("reference", "controller", "analyser"), ("recorder",)):
        for name in names:
            nodes[name].send_signal(signal.SIGINT)
        for name in names:
            nodes[name].wait(PATIENCE_S)


@pytest.fixture(scope="module")
def own_domain() -> Iterator[int]:
    """One for the whole module, whose tests share a graph."""
    with entered() as number:
        yield number


@pytest.fixture(scope="module")
def following(
    own_domain: int, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[dict[str, NodeProcess], Path]]:
    """Profile servo_1khz in lockstep, waiting for setpoints; its nodes and its recording."""
    out = tmp_path_factory.mktemp("following") / "run.mcap"
    nodes = {
        name: NodeProcess(name, *own, drive="servo_1khz")
        for name, own in _parameters("setpoint", out).items()
    }
    yield nodes, out
    for process in nodes.values():
        process.close()


def _answer(listener: Listener, client, request):
    """A service's response."""
    assert client.wait_for_service(timeout_sec=PATIENCE_S)
    future = client.call_async(request)
    assert listener.until(future.done, PATIENCE_S)
    return future.result()


def test_parameters_dump_and_load_again(listener, following) -> None:
    """Every parameter the node lists has a value, and those of the drive give the same drive."""
    names = listener.create_client(ListParameters, "/plant/list_parameters")
    listed = list(_answer(listener, names, ListParameters.Request()).result.names)
    values = listener.create_client(GetParameters, "/plant/get_parameters")
    answer = _answer(listener, values, GetParameters.Request(names=listed))
    given = [parameter_value_to_python(value) for value in answer.values]
    assert len(given) == len(listed) and None not in given
    dumped = dict(zip(listed, given, strict=True))
    dumped["transmission.stiffness"] = list(dumped["transmission.stiffness"])
    assert drive_from_flat(dumped, "dump") == load_drive("servo_1khz")


def test_gains_change_live_and_unstable_ones_are_refused(listener, following) -> None:
    """The parameter service takes stable gains, refuses unstable and start-only ones with why."""
    assert listener.until(lambda: listener.rod == listener.rod, PATIENCE_S)
    client = listener.create_client(SetParameters, "/controller/set_parameters")

    def change(name: str, value: float):
        message = Parameter(name, value=value).to_parameter_msg()
        return _answer(listener, client, SetParameters.Request(parameters=[message])).results[0]

    assert change("controller.position.kp", 10.0).successful
    refused = change("controller.speed.kp", 5.0)
    assert not refused.successful and "unstable" in refused.reason
    refused = change("controller.rate", 2000.0)
    assert not refused.successful and "start" in refused.reason
    refused = change("motor.resistance", 1.0)
    assert not refused.successful and "start" in refused.reason
    refused = change("controller.setpoint_filter", 5e-3)  # there was none at the start
    assert not refused.successful and "began without filter" in refused.reason
    refused = change("controller.position.kp", -1.0)
    assert not refused.successful and "controller.position.kp" in refused.reason
    assert change("controller.position.kp", 8.0).successful


def test_setpoints_are_followed_and_bad_ones_refused(listener, following) -> None:
    """A setpoint moves the rod there; NaN, beyond stroke and too fast are counted, not followed."""
    nodes, out = following
    assert listener.until(lambda: listener.rod == listener.rod, PATIENCE_S)
    assert listener.until(lambda: listener.setpoint.get_subscription_count() > 0)
    joints = listener.joints
    assert listener.until(lambda: listener.joints > joints + 100)
    for _ in range(20):  # one sent before the reference knows the sender is not heard
        listener.setpoint.publish(Float64(data=0.01))
        if listener.until(lambda: abs(listener.rod - 0.01) < 2e-4, 3.0):
            break
    assert abs(listener.rod - 0.01) < 2e-4
    for bad in (math.nan, 1.0, math.inf, -0.24):
        listener.setpoint.publish(Float64(data=bad))
        listener.setpoint.publish(Float64(data=0.01))
    status = "ecyl/reference setpoints"
    assert listener.until(
        lambda: listener.statuses.get(status, {}).get("setpoints_refused") == "4"
    ), listener.statuses
    assert abs(listener.rod - 0.01) < 5e-4
    _end(nodes)
    recording = read_recording(out)
    assert recording.rod_position_m.max() < 0.0105
    assert recording.rod_position_m.min() > -0.0005


def test_a_setpoint_acts_from_the_next_sample_on_in_real_time(listener, tmp_path: Path) -> None:
    """What was said of samples to come is taken back at once, and nothing is said of the past.

    Plant and analyser report missed ticks and jitter meanwhile, and they agree.
    """
    said: list[tuple[int, float]] = []
    now = [0]
    listener.create_subscription(
        JointState,
        "/ecyl/control/reference",
        lambda message: said.append((to_ns(message.header.stamp), message.position[0])),
        1000,
    )

    def on_joints(message: JointState) -> None:
        now[0] = to_ns(message.header.stamp)

    timings: list[dict[str, str]] = []

    def on_diagnostics(message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == "ecyl/plant timing":
                timings.append({item.key: item.value for item in status.values})

    listener.create_subscription(JointState, "/ecyl/joint_states", on_joints, 1000)
    listener.create_subscription(DiagnosticArray, "/diagnostics", on_diagnostics, 1000)
    drive = unhurried(tmp_path)
    parameters = _parameters("setpoint", tmp_path / "run.mcap", "realtime:=true")
    nodes = {name: node(name, *own, drive=drive) for name, own in parameters.items()}
    assert listener.until(lambda: len(said) > 50, PATIENCE_S)
    assert listener.until(lambda: listener.setpoint.get_subscription_count() > 0)
    for _ in range(20):  # one sent before the reference knows the sender is not heard
        before, count = now[0], len(said)
        listener.setpoint.publish(Float64(data=0.01))
        if listener.until(lambda count=count: any(x > 0.0 for _, x in said[count:]), 3.0):
            break
    after = now[0]
    status = "ecyl/analyser tracking"
    assert listener.until(lambda: "missed_ticks" in listener.statuses.get(status, {}), PATIENCE_S)
    repeated = listener.statuses[status]
    for key in ("missed_ticks", "late_ticks", "stale_ticks", "jitter_p99_s", "jitter_max_s"):
        assert repeated[key] in [timing[key] for timing in timings]
    _end(nodes)
    again = next(i for i in range(count, len(said)) if said[i][0] <= said[i - 1][0])
    sample_ns = round(1e9 / UNHURRIED_HZ)
    assert before < said[again][0] <= after + 2 * sample_ns
    positions = [position for stamp, position in said[again:] if stamp >= said[again][0]]
    assert positions[0] > 0.0 or positions[1] > 0.0


def test_analyser_agrees_with_the_offline_figures(listener, tmp_path: Path) -> None:
    """Running rms, lag and tracking error on the topics are those of `ecyl analyse`."""
    out = tmp_path / "run.mcap"
    nodes = {
        name: node(name, *own, drive="servo_1khz") for name, own in _parameters(SINE, out).items()
    }
    status = "ecyl/analyser tracking"
    # The transient at the start has left the window, and a status of a full one has come.
    assert listener.until(
        lambda: (
            len(listener.errors) > 2000
            and float(listener.statuses.get(status, {}).get("window_s", 0.0)) > 3.9
        ),
        PATIENCE_S,
    )
    figures = dict(listener.statuses[status])
    _end(nodes)
    offline = analyse(read_recording(out), 1.0)
    assert float(figures["window_s"]) == pytest.approx(4.0, abs=0.1)
    assert float(figures["error_rms_m"]) == pytest.approx(offline.error_rms_m, rel=0.05)
    assert float(figures["lag_s"]) == pytest.approx(offline.lag.lag_s, abs=1e-3)
    assert figures["line_1"].startswith("2")
    assert np.std(listener.errors[1000:2000]) == pytest.approx(offline.error_std_m, rel=0.05)


def test_real_time_keeps_the_wall_clock_and_counts(tmp_path: Path) -> None:
    """A 2 s real-time run takes 2 s, has every sample on the 40 ms grid and prints its counts.

    A drive without delay gets the one tick a topic takes, with a warning.
    """
    out = tmp_path / "run.mcap"
    drive = unhurried(tmp_path, delay_ticks=0)
    follow = ("--drive", drive, "--reference", SINE, "--duration", 2, "--out", out)
    done = ecyl("run", *follow, "--realtime")
    assert done.returncode == 0, done.stderr
    assert "running with 1" in done.stderr
    assert "50 ticks in 2." in done.stdout and "% met" in done.stdout
    recording = read_recording(out)
    assert len(recording) == 50
    assert abs(recording.stamp_ns[0] / 1e9 - time.time()) < 600
    assert set((recording.stamp_ns[1:] - recording.stamp_ns[:-1]).tolist()) == {40_000_000}


def test_json_of_analyse_on_a_run(tmp_path: Path) -> None:
    """A run's recording goes through `ecyl analyse` and its JSON holds the contract's keys."""
    out = tmp_path / "run.mcap"
    run = ("--drive", "bench", "--reference", SINE, "--duration", 2, "--out", out, "--in-process")
    assert ecyl_here("run", *run).returncode == 0
    done = ecyl_here("analyse", out, "--skip", 0.5, "--json", tmp_path / "a.json")
    assert done.returncode == 0, done.stderr
    figures = json.loads((tmp_path / "a.json").read_text())
    for key in ("error_std_m", "error_rms_m", "lag_s", "gain", "spectrum", "imfs"):
        assert figures[key] is not None
