"""The graph while it runs: setpoints, diagnostics, parameters, real time."""

from __future__ import annotations

import json
import math
import time
from pathlib import Path

import numpy as np
import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from ecyl_ros.analysis.tracking import analyse
from ecyl_ros.nodes.wire import to_ns
from ecyl_ros.recording.reader import read_recording

from .conftest import SINE, UNHURRIED_HZ, ecyl, start, unhurried


def _follow(tmp_path: Path, *flags: str, drive: str | Path = "servo_1khz"):
    return start(
        "run",
        "--drive",
        drive,
        "--reference",
        "setpoint",
        "--out",
        tmp_path / "run.mcap",
        *flags,
    )


def test_setpoints_are_followed_and_bad_ones_refused(listener, tmp_path: Path) -> None:
    """A setpoint moves the rod there; NaN, beyond stroke and too fast are counted, not followed."""
    process = _follow(tmp_path, "--duration", "20")
    try:
        assert listener.until(lambda: listener.rod == listener.rod)
        assert listener.until(lambda: listener.setpoint.get_subscription_count() > 0)
        listener.until(lambda: False, 1.0)
        listener.setpoint.publish(Float64(data=0.01))
        assert listener.until(lambda: abs(listener.rod - 0.01) < 2e-4)
        for bad in (math.nan, 1.0, math.inf, -0.24):
            listener.setpoint.publish(Float64(data=bad))
            listener.setpoint.publish(Float64(data=0.01))
        status = "ecyl/reference setpoints"
        assert listener.until(
            lambda: listener.statuses.get(status, {}).get("setpoints_refused") == "4"
        ), listener.statuses
        assert abs(listener.rod - 0.01) < 5e-4
    finally:
        process.terminate()
        process.communicate(timeout=20)
    recording = read_recording(tmp_path / "run.mcap")
    assert recording.rod_position_m.max() < 0.0105
    assert recording.rod_position_m.min() > -0.0005


def test_a_setpoint_acts_from_the_next_sample_on(listener, tmp_path: Path) -> None:
    """What was said of samples to come is taken back at once, and nothing is said of the past."""
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

    listener.create_subscription(JointState, "/ecyl/joint_states", on_joints, 1000)
    process = _follow(tmp_path, "--realtime", drive=unhurried(tmp_path))
    try:
        assert listener.until(lambda: len(said) > 50, 60.0)
        assert listener.until(lambda: listener.setpoint.get_subscription_count() > 0)
        before, count = now[0], len(said)
        listener.setpoint.publish(Float64(data=0.01))
        assert listener.until(lambda: any(position > 0.0 for _, position in said[count:]))
        after = now[0]
    finally:
        process.terminate()
        process.communicate(timeout=20)
    again = next(i for i in range(count, len(said)) if said[i][0] <= said[i - 1][0])
    sample_ns = round(1e9 / UNHURRIED_HZ)
    assert before < said[again][0] <= after + 2 * sample_ns
    positions = [position for stamp, position in said[again:] if stamp >= said[again][0]]
    assert positions[0] > 0.0 or positions[1] > 0.0


def test_analyser_agrees_with_the_offline_figures(listener, tmp_path: Path) -> None:
    """Running rms, lag and tracking error on the topics are those of `ecyl analyse`."""
    out = tmp_path / "run.mcap"
    process = start("run", "--drive", "servo_1khz", "--reference", SINE, "--out", out)
    status = "ecyl/analyser tracking"
    try:
        # The transient at the start has left the window, and a status of a full one has come.
        assert listener.until(
            lambda: (
                len(listener.errors) > 2000
                and float(listener.statuses.get(status, {}).get("window_s", 0.0)) > 3.9
            ),
            60.0,
        )
        figures = dict(listener.statuses[status])
    finally:
        process.terminate()
        _, errors = process.communicate(timeout=20)
    offline = analyse(read_recording(out), 1.0)
    assert float(figures["window_s"]) == pytest.approx(4.0, abs=0.1), errors
    assert float(figures["error_rms_m"]) == pytest.approx(offline.error_rms_m, rel=0.05)
    assert float(figures["lag_s"]) == pytest.approx(offline.lag.lag_s, abs=1e-3)
    assert figures["line_1"].startswith("2")
    assert np.std(listener.errors[1000:2000]) == pytest.approx(offline.error_std_m, rel=0.05)


def test_missed_ticks_and_jitter_are_on_diagnostics(listener, tmp_path: Path) -> None:
    """In real time plant and analyser report missed ticks and jitter, and they agree."""
    process = start(
        "run",
        "--drive",
        unhurried(tmp_path),
        "--reference",
        SINE,
        "--out",
        tmp_path / "run.mcap",
        "--realtime",
    )
    keys = ("missed_ticks", "late_ticks", "stale_ticks", "jitter_p99_s", "jitter_max_s")
    try:
        assert listener.until(
            lambda: "missed_ticks" in listener.statuses.get("ecyl/analyser tracking", {}), 60.0
        )
    finally:
        process.terminate()
        process.communicate(timeout=20)
    for key in keys:
        repeated = float(listener.statuses["ecyl/analyser tracking"][key])
        assert 0.0 <= repeated <= float(listener.statuses["ecyl/plant timing"][key]) + 1e-2


def test_gains_change_live_and_unstable_ones_are_refused(listener, tmp_path: Path) -> None:
    """The parameter service takes stable gains, refuses unstable and start-only ones with why."""
    process = _follow(tmp_path)
    try:
        assert listener.until(lambda: listener.rod == listener.rod)
        client = listener.create_client(SetParameters, "/controller/set_parameters")
        assert client.wait_for_service(timeout_sec=10.0)

        def change(name: str, value: float):
            request = SetParameters.Request(
                parameters=[Parameter(name, value=value).to_parameter_msg()]
            )
            future = client.call_async(request)
            assert listener.until(future.done, 10.0)
            return future.result().results[0]

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
    finally:
        process.terminate()
        process.communicate(timeout=20)


def test_real_time_keeps_the_wall_clock_and_counts(tmp_path: Path) -> None:
    """A 3 s real-time run takes 3 s, has every sample on the 20 ms grid and prints its counts."""
    out = tmp_path / "run.mcap"
    done = ecyl(
        "run",
        "--drive",
        unhurried(tmp_path),
        "--reference",
        SINE,
        "--duration",
        3,
        "--out",
        out,
        "--realtime",
    )
    assert done.returncode == 0, done.stderr
    assert "150 ticks in 3." in done.stdout and "% met" in done.stdout
    recording = read_recording(out)
    assert len(recording) == 150
    assert abs(recording.stamp_ns[0] / 1e9 - time.time()) < 60
    assert set((recording.stamp_ns[1:] - recording.stamp_ns[:-1]).tolist()) == {20_000_000}


def test_zero_delay_runs_with_one_tick_in_real_time_and_says_so(tmp_path: Path) -> None:
    """A drive without delay gets the one tick a topic takes, with a warning."""
    done = ecyl(
        "run",
        "--drive",
        unhurried(tmp_path, delay_ticks=0),
        "--reference",
        SINE,
        "--duration",
        0.5,
        "--out",
        tmp_path / "run.mcap",
        "--realtime",
    )
    assert done.returncode == 0, done.stderr
    assert "running with 1" in done.stderr


def test_json_of_analyse_on_a_run(tmp_path: Path) -> None:
    """A run's recording goes through `ecyl analyse` and its JSON holds the contract's keys."""
    out = tmp_path / "run.mcap"
    assert (
        ecyl(
            "run",
            "--drive",
            "bench",
            "--reference",
            SINE,
            "--duration",
            2,
            "--out",
            out,
            "--in-process",
        ).returncode
        == 0
    )
    done = ecyl("analyse", out, "--skip", 0.5, "--json", tmp_path / "a.json")
    assert done.returncode == 0, done.stderr
    figures = json.loads((tmp_path / "a.json").read_text())
    for key in ("error_std_m", "error_rms_m", "lag_s", "gain", "spectrum", "imfs"):
        assert figures[key] is not None


def test_parameters_dump_and_load_again(listener, tmp_path: Path) -> None:
    """Every parameter the node lists has a value, and those of the drive give the same drive."""
    from rcl_interfaces.srv import GetParameters, ListParameters
    from rclpy.parameter import parameter_value_to_python

    from ecyl_ros.drive.drive_file import drive_from_flat, load_drive

    process = _follow(tmp_path)
    try:
        names = listener.create_client(ListParameters, "/plant/list_parameters")
        assert names.wait_for_service(timeout_sec=30.0)
        future = names.call_async(ListParameters.Request())
        assert listener.until(future.done, 10.0)
        listed = list(future.result().result.names)
        values = listener.create_client(GetParameters, "/plant/get_parameters")
        assert values.wait_for_service(timeout_sec=10.0)
        future = values.call_async(GetParameters.Request(names=listed))
        assert listener.until(future.done, 10.0)
        given = [parameter_value_to_python(value) for value in future.result().values]
    finally:
        process.terminate()
        process.communicate(timeout=20)
    assert len(given) == len(listed) and None not in given
    dumped = dict(zip(listed, given, strict=True))
    dumped["transmission.stiffness"] = list(dumped["transmission.stiffness"])
    assert drive_from_flat(dumped, "dump") == load_drive("servo_1khz")
