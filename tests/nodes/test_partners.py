"""Nodes that lose each other: they wait, say so, resume or end; none outlives the launcher."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Vector3Stamped
from sensor_msgs.msg import JointState

from ecyl_ros.drive.drive_file import resolve_drive
from ecyl_ros.nodes import wire
from ecyl_ros.nodes.reference import GENERATED_LOOKAHEAD
from ecyl_ros.nodes.wire import to_ns
from ecyl_ros.recording.reader import read_recording
from tests.domains import domain

from .conftest import SINE, Listener, ecyl_here, node, simulated, start

PARTNER = "ecyl/plant partner"


def _recording_run(folder: Path) -> tuple[subprocess.Popen, Path]:
    """A run as its user starts it, of which more than a chunk is on disk; and its recording."""
    out = folder / "run.mcap"
    arguments = ("--drive", "servo_1khz", "--reference", SINE, "--duration", 600)
    process = start("run", *arguments, "--out", out)
    assert _wait_until(lambda: out.exists() and out.stat().st_size > 300_000, 60.0)
    return process, out


def _nodes_of(process: subprocess.Popen, count: int) -> dict[str, int]:
    """Process numbers of a launcher's nodes by name."""
    pids = _children(process.pid)
    assert len(pids) == count
    return {Path(f"/proc/{pid}/cmdline").read_text().split("\0")[3]: pid for pid in pids}


def _children(pid: int) -> list[int]:
    tasks = Path(f"/proc/{pid}/task")
    found: list[int] = []
    for task in tasks.iterdir() if tasks.exists() else ():
        found += [int(word) for word in (task / "children").read_text().split()]
    return found


def _alive(pid: int) -> bool:
    try:
        return "Z" not in Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except FileNotFoundError:
        return False


def _wait_until(condition, seconds: float) -> bool:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if condition():
            return True
        time.sleep(0.05)
    return False


def test_nodes_that_are_killed_and_started_again_are_taken_up(
    listener: Listener, tmp_path: Path
) -> None:
    """Kill one node after the other within a lockstep run, start it again: the run has its end."""
    out = tmp_path / "run.mcap"
    timed, follows = "duration:=12.0", f'reference:="{SINE}"'  # 12 000 ticks, 3000 samples
    recorded = "recorder:=recorder"  # nobody begins before it hears them
    own = {
        "recorder": (timed, f"out:={out}"),
        "reference": (timed, follows, recorded),
        "controller": (recorded,),
        "plant": (timed, recorded),
    }
    now = [0.0]
    listener.create_subscription(
        JointState,
        "/ecyl/joint_states",
        lambda message: now.append(to_ns(message.header.stamp) * 1e-9),
        10,
    )
    nodes = {
        name: node(name, *own.get(name, ()), drive="servo_1khz")
        for name in ("recorder", "analyser", "reference", "controller", "plant")
    }
    for victim, at_s in (("controller", 1.0), ("reference", 3.0), ("analyser", 5.0)):
        assert listener.until(lambda at_s=at_s: now[-1] >= at_s, 60.0)
        nodes[victim].kill()
        nodes[victim].wait()
        if victim != "analyser":
            assert listener.until(lambda: "waiting for" in listener.messages.get(PARTNER, ""))
            assert nodes["plant"].poll() is None
        nodes[victim] = node(victim, *own.get(victim, ()), drive="servo_1khz")
    assert nodes["plant"].wait(60) == 0
    assert nodes["recorder"].wait(30) == 0
    recording = read_recording(out)
    # With a killed controller goes the telemetry of voltages that were on their way.
    assert 2990 <= len(recording) <= 3000
    error = abs(recording.rod_position_m - recording.reference_position_m)
    assert np.nanmax(error) < 2e-3
    # A killed reference takes the samples with it that it had told the controller only.
    assert np.isnan(error).sum() <= GENERATED_LOOKAHEAD + 2


def test_a_node_alone_says_what_it_waits_for_and_ends() -> None:
    """Without a partner each node warns, and ends with exit code 1 after `partner_timeout`."""
    with contextlib.ExitStack() as apart:
        nodes = [
            node(name, "partner_timeout:=6.0", domain=apart.enter_context(domain()))
            for name in ("plant", "controller", "reference", "analyser")
        ]
        for process in nodes:
            text, _ = process.communicate(timeout=60)
            assert process.returncode == 1, text
            assert "waiting for" in text and "gave up waiting for" in text, text
            assert "Traceback" not in text


def test_a_reference_ahead_of_a_plant_that_waits_goes_back_to_it(listener: Listener) -> None:
    """A message of the run before, heard after the new one's start: the samples come all the same.

    By hand: tick 0 is said, then a joint state of a plant that was killed at sample 500.
    """
    said: list[int] = []
    listener.create_subscription(
        JointState,
        "/ecyl/control/reference",
        lambda message: said.append(to_ns(message.header.stamp)),
        wire.latched(1000),
    )
    epoch = listener.create_publisher(Time, "/ecyl/control/epoch", wire.latched())
    waits = listener.create_publisher(Time, "/ecyl/control/waiting", 10)
    joints = listener.create_publisher(JointState, "/ecyl/joint_states", wire.lossless())
    epoch.publish(Time())
    node("reference", f'reference:="{SINE}"', drive="servo_1khz")
    assert listener.until(lambda: len(said) > 100 and joints.get_subscription_count() > 1)
    listener.until(lambda: False, 0.5)
    late = JointState(name=["rotor", "rod"], position=[0.0] * 2, velocity=[0.0] * 2)
    late.header.stamp.sec = 2
    joints.publish(late)
    assert listener.until(lambda: bool(said) and said[-1] > 2 * 10**9)
    said.clear()
    wanted = [4_000_000 * sample for sample in range(100)]

    def repeated() -> bool:
        waits.publish(Time())
        first = said.index(0) if 0 in said else len(said)
        return said[first : first + len(wanted)] == wanted

    assert listener.until(repeated)


def test_what_a_reference_takes_back_leaves_what_it_said_before(listener: Listener) -> None:
    """A setpoint changes samples from the fourth on before tick 8 is asked for: it is answered.

    By hand: the third sample, said before, is the one that tick 8 begins at.
    """
    answered: list[int] = []
    listener.create_subscription(
        Vector3Stamped,
        "/ecyl/control/voltage",
        lambda message: answered.append(to_ns(message.header.stamp)),
        wire.control(),
    )
    says = listener.create_publisher(JointState, "/ecyl/control/reference", wire.latched(100))
    asks = listener.create_publisher(JointState, "/ecyl/control/measurement", wire.control())
    node("controller", drive="servo_1khz")

    def say(sample: int) -> None:
        message = JointState(name=["rod"], position=[1e-6 * sample], velocity=[0.0])
        message.header.stamp = wire.to_time(4_000_000 * sample)
        says.publish(message)

    def ask(tick: int) -> bool:
        message = JointState(name=list(wire.MEASUREMENT_JOINTS))
        message.position, message.velocity = [0.0] * 4, [0.0] * 4
        message.effort = [0.0] * 4
        message.header.stamp = wire.to_time(1_000_000 * tick)

        def once_more() -> bool:
            asks.publish(message)
            return 1_000_000 * tick in answered

        return listener.until(once_more, 20.0)

    for sample in range(8):
        say(sample)
    assert all(ask(tick) for tick in range(8))
    for sample in range(3, 10):
        say(sample)
    listener.until(lambda: False, 0.3)
    assert ask(8) and ask(9)


def test_a_second_plant_is_refused(listener: Listener, tmp_path: Path) -> None:
    """Two plants on one domain: the second says so and ends with 2; the first is not disturbed."""
    arguments = ("--drive", "servo_1khz", "--reference", SINE, "--duration", 4.0)
    first = start("run", *arguments, "--out", tmp_path / "a.mcap")
    assert listener.until(lambda: listener.joints > 10)
    names = _nodes_of(first, 5)
    # However fast the machine, the first is still at work when the second comes.
    os.kill(names["controller"], signal.SIGSTOP)
    text, _ = node("plant", drive="servo_1khz").communicate(timeout=60)
    os.kill(names["controller"], signal.SIGCONT)
    assert "another plant" in text
    _, errors = first.communicate(timeout=120)
    assert first.returncode == 0, errors
    engine = simulated(tmp_path / "b.mcap", *arguments)
    assert (tmp_path / "a.mcap").read_bytes() == engine


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_stopped_launcher_leaves_no_node_and_a_recording(sent: int, tmp_path: Path) -> None:
    """Ctrl-C, SIGTERM or SIGKILL to the launcher: every node ends, the recording opens."""
    process, out = _recording_run(tmp_path)
    nodes = _nodes_of(process, 5).values()
    os.kill(process.pid, sent)
    process.communicate(timeout=60)
    assert _wait_until(lambda: not any(_alive(pid) for pid in nodes), 30.0)
    recording = read_recording(out)
    assert len(recording) > 1000
    if sent != signal.SIGKILL:
        assert process.returncode == 130
        # Closed in order: at most the sample on its way at that moment lacks a topic.
        assert all(" 1 of " in note and "samples missing" in note for note in recording.notes)


def test_a_killed_recorder_keeps_its_closed_chunks(tmp_path: Path) -> None:
    """SIGKILL the recorder in mid-run: the launcher says so, and what was flushed opens again.

    Until then plant and controller share a processor that the others keep off, if there are two.
    """
    process, out = _recording_run(tmp_path)
    nodes = _nodes_of(process, 5)
    found = {name: os.sched_getaffinity(pid) for name, pid in nodes.items()}
    os.kill(nodes["recorder"], signal.SIGKILL)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 1
    assert "recorder node ended early (signal SIGKILL)" in errors
    recording = read_recording(out)
    assert len(recording) > 1000 and recording.notes
    assert found["plant"] == found["controller"] and len(found["plant"]) == 1
    others = set.union(*(found[name] for name in ("recorder", "analyser", "reference")))
    usable = os.sched_getaffinity(0)
    assert others == (usable - found["plant"] if len(usable) > 1 else usable)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--drive", "nowhere.yaml"), "nowhere.yaml"),
        (("--reference", "waltz"), "waltz"),
        (("--duration", "-1"), "--duration"),
        (("--duration", "nan"), "--duration"),
        (("--skip", "9"), "--skip"),
        (("--reference", "sine:amplitude=1e-3,frequency=1,offset=0.5"), "stroke"),
    ],
)
@pytest.mark.parametrize("verb", ["run", "simulate"])
def test_bad_input_ends_with_one_line_and_exit_2(
    verb: str, arguments: tuple, expected: str, tmp_path: Path
) -> None:
    """Unusable flags, files and specs: exit 2, one line, no file begun."""
    out = tmp_path / "run.mcap"
    base = ["--drive", "bench", "--reference", SINE, "--duration", "0.1", "--out", str(out)]
    done = ecyl_here(verb, *base, *arguments)
    assert done.returncode == 2
    assert expected in done.stderr and len(done.stderr.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_an_unstable_rate_is_refused_with_the_smallest_that_holds(tmp_path: Path) -> None:
    """A drive file whose rate is too low for its gains never starts a node."""
    drive = tmp_path / "slow.yaml"
    drive.write_text(resolve_drive("paper").read_text().replace("100000.0", "20000.0"))
    done = ecyl_here(
        "run", "--drive", drive, "--reference", SINE, "--duration", 1, "--out", tmp_path / "o.mcap"
    )
    assert done.returncode == 2
    assert f"{drive}: controller.rate = 20000 Hz: the sampled loop is unstable" in done.stderr
    assert not (tmp_path / "o.mcap").exists()
