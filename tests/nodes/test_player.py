"""A motion on a node graph: recorded within its bounds, or ended with the drive at rest."""

from __future__ import annotations

import dataclasses
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive, resolve_drive
from ecyl_ros.errors import InputError
from ecyl_ros.investigate.bounds import bounds_for
from ecyl_ros.investigate.played import Played, missed
from ecyl_ros.investigate.survey import survey
from ecyl_ros.nodes import player
from ecyl_ros.nodes.play import emulated, play
from ecyl_ros.nodes.player import Task
from ecyl_ros.recording.reader import read_recording

DRIVE = load_drive("servo_1khz")


def _drive(folder: Path, *changes: tuple[str, str]) -> Path:
    """Profile servo_1khz with a sample a tick, and lines changed."""
    text = resolve_drive("servo_1khz").read_text()
    for old, new in (("telemetry_rate: 250.0 ", "telemetry_rate: 1000.0 "), *changes):
        assert text.count(old) == 1
        text = text.replace(old, new)
    path = folder / "hidden.yaml"
    path.write_text(text)
    return path


def _task(
    out: Path, duration_s: float = 2.0, follow: str = "auto", silence_s: float = 15.0
) -> Task:
    motion, healthy = survey(DRIVE, duration_s)
    bounds = bounds_for(DRIVE, healthy, None, None)
    return Task(bounds, tuple(motion.points()), out, follow=follow, silence_s=silence_s)


def _played(hidden: Path, task: Task, name: str) -> Played:
    with emulated(hidden, name) as alive:
        result = play(task, namespace=name, alive=alive)
    assert isinstance(result, Played)
    return result


def _moving(out: Path) -> None:
    """Wait until a motion that is recorded to `out` is under way."""
    while not out.exists() or out.stat().st_size < 100_000:
        time.sleep(0.01)


def _kept(result: Played) -> np.ndarray:
    """Reference positions and speeds of the recording, all within the limits."""
    assert result.recording is not None
    shown = read_recording(result.recording)
    place, speed = shown.reference_position_m, shown.reference_velocity_m_per_s
    faster = np.diff(speed) / np.diff(shown.stamp_ns * 1e-9)
    limits = DRIVE.limits
    assert limits.stroke_min <= place.min() and place.max() <= limits.stroke_max
    assert np.abs(speed).max() <= limits.speed * (1.0 + 1e-6)
    assert np.abs(faster).max() <= limits.acceleration * (1.0 + 1e-3)
    return np.stack([place, speed])


def test_a_motion_is_played_as_it_is_and_recorded(tmp_path: Path) -> None:
    """The recording's reference is the motion, sample by sample; the peaks are the recording's."""
    motion, _ = survey(DRIVE, 2.0)
    result = _played(_drive(tmp_path), _task(tmp_path / "m.mcap"), "whole")
    assert result.ended is None and result.at_rest
    place, _ = _kept(result)
    wanted = np.array([motion.sample(1e-3 * index)[0] for index in range(2000)])
    begin = int(np.argmax(place != 0.0)) - 1
    np.testing.assert_allclose(place[begin : begin + 2000], wanted, atol=1e-8)
    shown = read_recording(tmp_path / "m.mcap")
    errors = np.abs(shown.reference_position_m - shown.rod_position_m)
    assert result.error_m == pytest.approx(errors.max(), rel=1e-3)
    assert result.missed_ticks is None  # in lockstep there are none


def test_a_jam_on_the_way_brings_the_drive_to_rest(tmp_path: Path) -> None:
    """A rod that is held: tracking error beyond its bound; the reference brakes within limits."""
    place = "position_m: 0.01, width_m: 4.0e-3, edge_m: 1.0e-3"
    jam = f"    effects: {{local_jam: {{coulomb_nm: 900.0, {place}}}}}\n"
    hidden = _drive(tmp_path, ("    tolerances:", f"{jam}    tolerances:"))
    result = _played(hidden, _task(tmp_path / "m.mcap", 4.0), "jam")
    assert result.ended is not None and "tracking error of" in result.ended, result
    assert result.at_rest and abs(_kept(result)[1, -1]) < 1e-6


def test_a_current_beyond_its_bound_brings_the_drive_to_rest(tmp_path: Path) -> None:
    """A stretch of heavy drag, with any tracking error allowed and little more than the healthy
    current: the current ends it."""
    place = "position_m: 0.01, width_m: 4.0e-3, edge_m: 1.0e-3"
    jam = f"    effects: {{local_jam: {{coulomb_nm: 12.0, {place}}}}}\n"
    hidden = _drive(tmp_path, ("    tolerances:", f"{jam}    tolerances:"))
    motion, healthy = survey(DRIVE, 4.0)
    bounds = bounds_for(DRIVE, healthy, 1.0, 1.05 * healthy.current_a)
    task = Task(bounds, tuple(motion.points()), tmp_path / "m.mcap", silence_s=15.0)
    result = _played(hidden, task, "current")
    assert result.ended is not None and result.ended.startswith("current of"), result
    assert f"beyond {bounds.current_a:.3g} A" in result.ended
    assert result.at_rest and abs(_kept(result)[1, -1]) < 1e-6


_ALARM = """
import sys, time
from pathlib import Path
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
rclpy.init()
node = rclpy.create_node("alarm", namespace="alarm")
publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
out = Path(sys.argv[1])
while not out.exists() or out.stat().st_size < 100_000:
    time.sleep(0.01)
said = [
    DiagnosticStatus(level=DiagnosticStatus.ERROR, name="other/ecyl/plant", message="not ours"),
    DiagnosticStatus(level=DiagnosticStatus.ERROR, name="alarm/ecyl/plant", message="too hot"),
]
for number in range(40):
    publisher.publish(DiagnosticArray(status=said[: 1 + (number >= 10)]))
    time.sleep(0.05)
"""


def test_an_error_that_a_node_of_the_drive_reports_ends_it(tmp_path: Path) -> None:
    """ERROR on /diagnostics under the drive's namespace: its words are the reason; another drive's
    are not."""
    out = tmp_path / "m.mcap"
    alarm = subprocess.Popen([sys.executable, "-c", _ALARM, str(out)])
    try:
        result = _played(_drive(tmp_path), _task(out, 8.0), "alarm")
    finally:
        alarm.terminate()
        alarm.wait(10)
    assert result.ended == "plant: too hot", result
    assert result.at_rest and abs(_kept(result)[1, -1]) < 1e-6


_COUNTING = """
import sys, time
from pathlib import Path
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
rclpy.init()
node = rclpy.create_node("counting", namespace="counting")
publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
out = Path(sys.argv[1])
while rclpy.ok():
    moving = out.exists() and out.stat().st_size > 100_000
    values = [KeyValue(key="missed_ticks", value="8" if moving else "3")]
    status = DiagnosticStatus(name="counting/ecyl/plant timing", values=values)
    publisher.publish(DiagnosticArray(status=[status]))
    time.sleep(0.02)
"""


def test_ticks_that_the_drive_missed_on_the_way_are_counted(tmp_path: Path) -> None:
    """Of a drive that had missed 3 ticks before and 8 in the end, 5; of one that does not say,
    none are known."""
    out = tmp_path / "m.mcap"
    counting = subprocess.Popen([sys.executable, "-c", _COUNTING, str(out)])
    try:
        result = _played(_drive(tmp_path), _task(out), "counting")
    finally:
        counting.terminate()
        counting.wait(10)
    assert result.missed_ticks == 5 and result.ended is None, result
    assert "missed 5 of its control ticks" in missed(result)


def test_a_motion_that_the_drive_refuses_is_not_begun(tmp_path: Path) -> None:
    """A slower drive refuses it as a whole; its reason is the reason, and nothing has moved."""
    slow = "    limits: {speed: 0.02}\n"
    hidden = _drive(tmp_path, ("    tolerances:", f"{slow}    tolerances:"))
    result = _played(hidden, _task(tmp_path / "m.mcap"), "slow")
    assert result.ended is not None and "the drive refused: trajectory asks for" in result.ended
    assert not _kept(result).any()


def test_a_partner_that_is_killed_ends_it(tmp_path: Path) -> None:
    """The controller is killed in the middle: its silence is noticed, what was recorded is kept."""
    task = _task(tmp_path / "m.mcap", 8.0, silence_s=2.0)
    with emulated(_drive(tmp_path), "killed") as alive:
        processes = alive.__self__.processes  # type: ignore[attr-defined]

        def kill() -> None:
            _moving(tmp_path / "m.mcap")
            os.kill(processes["controller"].pid, signal.SIGKILL)

        thread = threading.Thread(target=kill)
        thread.start()
        result = play(task, namespace="killed")
        thread.join()
        assert alive() == "the controller node ended early (signal SIGKILL)"
    assert isinstance(result, Played) and result.recording is not None
    assert "nothing heard on /killed/ecyl/" in (result.ended or ""), result


def test_setpoints_take_a_drive_through_a_motion(tmp_path: Path) -> None:
    """A drive that follows setpoints alone is there in the end."""
    slower = dataclasses.replace(DRIVE.limits, speed=0.5 * DRIVE.limits.speed)
    motion, healthy = survey(dataclasses.replace(DRIVE, limits=slower), 2.0)
    bounds = bounds_for(DRIVE, healthy, 0.05, None)
    points = tuple(motion.points())
    hidden = _drive(tmp_path)
    result = _played(
        hidden, Task(bounds, points, tmp_path / "s.mcap", "setpoint", silence_s=15.0), "points"
    )
    assert result.ended is None, result
    assert np.abs(_kept(result)[0]).max() > 0.5 * max(abs(one.position) for one in points)


@pytest.mark.parametrize(
    ("number", "name"), [(signal.SIGINT, "Ctrl-C"), (signal.SIGTERM, "SIGTERM")]
)
def test_a_signal_ends_a_motion_with_the_drive_at_rest(
    tmp_path: Path, number: signal.Signals, name: str
) -> None:
    """In the middle of it: the reference brakes within its limits, what was recorded is kept."""

    def interrupt() -> None:
        _moving(tmp_path / "c.mcap")
        os.kill(os.getpid(), number)

    thread = threading.Thread(target=interrupt)
    thread.start()
    result = _played(_drive(tmp_path), _task(tmp_path / "c.mcap", 8.0), f"signal_{number.name}")
    thread.join()
    assert result.ended == f"stopped by {name}" and result.at_rest
    assert abs(_kept(result)[1, -1]) < 1e-6


def test_without_a_drive_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line says what was waited for."""
    monkeypatch.setattr(player, "CONNECT_S", 0.5)
    with pytest.raises(
        InputError, match=r"no drive: waited .* telemetry on /nobody/ecyl/reference"
    ):
        play(_task(tmp_path / "m.mcap"), namespace="nobody")
    assert not list(tmp_path.iterdir())
