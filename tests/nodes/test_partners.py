"""Nodes that lose each other: they wait, say so, resume or end; none outlives the launcher."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import resolve_drive
from ecyl_ros.nodes.reference import GENERATED_LOOKAHEAD
from ecyl_ros.recording.reader import read_recording

from .conftest import SINE, ecyl, node, simulated, start


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


@pytest.mark.parametrize("victim", ["controller", "reference", "analyser"])
def test_a_node_that_is_killed_and_started_again_is_taken_up(victim: str, tmp_path: Path) -> None:
    """Kill one node in the middle of a lockstep run, start it again: the run reaches its end."""
    out = tmp_path / "run.mcap"
    timed = "duration:=12.0"  # 12 000 ticks: a fast machine is not through before the kill
    nodes = {
        "recorder": node("recorder", timed, f"out:={out}"),
        "analyser": node("analyser"),
        "reference": node("reference", timed, f'reference:="{SINE}"'),
        "controller": node("controller"),
        "plant": node("plant", timed),
    }
    try:
        assert _wait_until(lambda: out.exists() and out.stat().st_size > 0, 60.0)
        time.sleep(1.5)
        nodes[victim].kill()
        nodes[victim].wait()
        if victim != "analyser":
            time.sleep(1.0)
            assert nodes["plant"].poll() is None  # it waits
        nodes[victim] = node(
            victim, *([timed, f'reference:="{SINE}"'] if victim == "reference" else [])
        )
        assert nodes["plant"].wait(60) == 0
        assert nodes["recorder"].wait(20) == 0
    finally:
        for process in nodes.values():
            process.kill()
            process.wait()
    recording = read_recording(out)
    assert len(recording) == 12_000
    error = abs(recording.rod_position_m - recording.reference_position_m)
    assert np.nanmax(error) < 2e-3
    # A killed reference takes the samples with it that it had told the controller only.
    ahead = GENERATED_LOOKAHEAD + 2
    assert np.isnan(error).sum() <= (ahead if victim == "reference" else 1)


def test_a_node_alone_says_what_it_waits_for_and_ends() -> None:
    """Without a partner each node warns, and ends with exit code 1 after `partner_timeout`."""
    nodes = {
        name: node(name, "partner_timeout:=6.0", domain=95 + index)
        for index, name in enumerate(("plant", "controller", "reference", "analyser"))
    }
    try:
        for name, process in nodes.items():
            text, _ = process.communicate(timeout=40)
            assert process.returncode == 1, (name, text)
            assert "waiting for" in text and "gave up waiting for" in text, (name, text)
            assert "Traceback" not in text
    finally:
        for process in nodes.values():
            process.kill()


def test_a_second_plant_is_refused(tmp_path: Path) -> None:
    """Two plants on one domain: the second says so and ends with 2; the first is not disturbed."""
    # Long enough for the second to find the first still at work, however fast the machine.
    arguments = ("--drive", "bench", "--reference", SINE, "--duration", 8.0)
    first = start("run", *arguments, "--out", tmp_path / "a.mcap")
    try:
        assert _wait_until(lambda: (tmp_path / "a.mcap").exists(), 60.0)
        time.sleep(1.0)
        second = node("plant")
        text, _ = second.communicate(timeout=30)
        assert second.returncode == 2, text
        assert "another plant" in text
        _, errors = first.communicate(timeout=120)
        assert first.returncode == 0, errors
    finally:
        first.kill()
    engine = simulated(tmp_path / "b.mcap", *arguments)
    assert (tmp_path / "a.mcap").read_bytes() == engine


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_stopped_launcher_leaves_no_node_and_a_recording(sent: int, tmp_path: Path) -> None:
    """Ctrl-C, SIGTERM or SIGKILL to the launcher: every node ends, the recording opens."""
    out = tmp_path / "run.mcap"
    process = start("run", "--drive", "bench", "--reference", SINE, "--duration", 600, "--out", out)
    assert _wait_until(lambda: out.exists() and out.stat().st_size > 300_000, 60.0)
    nodes = _children(process.pid)
    assert len(nodes) == 5
    os.kill(process.pid, sent)
    process.communicate(timeout=20)
    assert _wait_until(lambda: not any(_alive(pid) for pid in nodes), 10.0)
    recording = read_recording(out)
    assert len(recording) > 1000
    if sent != signal.SIGKILL:
        assert process.returncode == 130
        # Closed in order: at most the sample on its way at that moment lacks a topic.
        assert all(" 1 of " in note and "samples missing" in note for note in recording.notes)


def test_plant_and_controller_share_a_processor(tmp_path: Path) -> None:
    """The launcher keeps the others off the processor of plant and controller, if there are two."""
    out = tmp_path / "run.mcap"
    process = start("run", "--drive", "bench", "--reference", SINE, "--duration", 600, "--out", out)
    try:
        assert _wait_until(lambda: out.exists() and out.stat().st_size > 300_000, 60.0)
        found = {
            Path(f"/proc/{pid}/cmdline").read_text().split("\0")[3]: os.sched_getaffinity(pid)
            for pid in _children(process.pid)
        }
    finally:
        process.terminate()
        process.communicate(timeout=20)
    assert len(found) == 5
    assert found["plant"] == found["controller"] and len(found["plant"]) == 1
    others = set.union(*(found[name] for name in ("recorder", "analyser", "reference")))
    usable = os.sched_getaffinity(0)
    assert others == (usable - found["plant"] if len(usable) > 1 else usable)


def test_a_killed_recorder_keeps_its_closed_chunks(tmp_path: Path) -> None:
    """SIGKILL the recorder in mid-run: the launcher says so, and what was flushed opens again."""
    out = tmp_path / "run.mcap"
    process = start("run", "--drive", "bench", "--reference", SINE, "--duration", 600, "--out", out)
    assert _wait_until(lambda: out.exists() and out.stat().st_size > 300_000, 60.0)
    recorder = next(
        pid
        for pid in _children(process.pid)
        if "recorder" in Path(f"/proc/{pid}/cmdline").read_text()
    )
    os.kill(recorder, signal.SIGKILL)
    _, errors = process.communicate(timeout=20)
    assert process.returncode == 1
    assert "recorder node ended early (signal SIGKILL)" in errors
    recording = read_recording(out)
    assert len(recording) > 1000 and recording.notes


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
    done = ecyl(verb, *base, *arguments)
    assert done.returncode == 2
    assert expected in done.stderr and len(done.stderr.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_an_unstable_rate_is_refused_with_the_smallest_that_holds(tmp_path: Path) -> None:
    """A drive file whose rate is too low for its gains never starts a node."""
    drive = tmp_path / "slow.yaml"
    drive.write_text(resolve_drive("paper").read_text().replace("100000.0", "20000.0"))
    done = ecyl(
        "run", "--drive", drive, "--reference", SINE, "--duration", 1, "--out", tmp_path / "o.mcap"
    )
    assert done.returncode == 2
    assert f"{drive}: controller.rate = 20000 Hz: the sampled loop is unstable" in done.stderr
    assert not (tmp_path / "o.mcap").exists()
