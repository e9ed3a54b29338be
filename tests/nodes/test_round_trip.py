"""Real time that knows its limits: the round trip is measured, what asks for more is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.stability import at_rate, check_stability
from ecyl_ros.errors import InputError
from ecyl_ros.nodes.realtime import with_transport_delay
from ecyl_ros.nodes.round_trip import RoundTrip, check_real_time, measure
from ecyl_ros.recording.reader import read_recording

from .conftest import SINE, ecyl_here


def _trip(p99_s: float) -> RoundTrip:
    return RoundTrip(median_s=p99_s / 2, p99_s=p99_s, middleware="rmw_x", together=False)


def test_the_rate_that_would_hold_is_named_and_does_hold() -> None:
    """Refused beyond a third of a tick; the rate in the message passes, and is stable."""
    drive = load_drive("servo_1khz")
    check_real_time(drive, "d.yaml", _trip(1 / 3000 - 1e-9))
    trip = _trip(6e-4)
    with pytest.raises(InputError, match=r"d\.yaml: controller\.rate = 1000 Hz.*--rate 550 "):
        check_real_time(drive, "d.yaml", trip)
    check_real_time(at_rate(drive, trip.rate), "d.yaml", trip)
    check_stability(at_rate(drive, trip.rate), "d.yaml")


def test_gains_that_need_more_than_the_machine_holds_are_said_so() -> None:
    """Where no stable rate holds, the message names other gains instead of --rate."""
    bench = with_transport_delay(load_drive("bench"))
    with pytest.raises(InputError, match="other gains, for with these they need 7267 Hz") as error:
        check_real_time(bench, "bench.yaml", _trip(5e-4))
    assert "--rate" not in str(error.value)


@pytest.mark.parametrize(("rate", "together"), [(500.0, False), (2.0, True)])
def test_a_round_trip_is_measured(rate: float, together: bool) -> None:
    """Positive, in order, shorter than the time-out, and it says between whom; at a slow drive's
    rate as well, of whose ticks a hundred seconds would be needed."""
    trip = measure(rate, together=together)
    assert 1e-6 < trip.median_s <= trip.p99_s < 0.5
    assert ("within one process" in str(trip)) == together


def test_real_time_that_cannot_be_held_starts_no_node(tmp_path: Path) -> None:
    """Profile paper asks for 100 kHz over topics: one line, exit code 2, no recording."""
    out = tmp_path / "o.mcap"
    done = ecyl_here(
        "run",
        "--drive",
        "paper",
        "--rate",
        3e5,
        "--reference",
        SINE,
        "--duration",
        1,
        "--realtime",
        "--out",
        out,
    )
    assert done.returncode == 2 and not out.exists()
    line = done.stderr.strip().splitlines()[-1]
    assert line.startswith("ecyl run: ") and "Traceback" not in done.stderr
    assert "leaves a round trip 1 us" in line and "round trip between" in line


def test_another_rate_gives_the_engines_bytes_at_that_rate(tmp_path: Path) -> None:
    """`--rate` reaches every node: the graph's file is the one `ecyl simulate --rate` writes."""
    arguments = ("--drive", "servo_1khz", "--rate", 500, "--reference", SINE, "--duration", 0.4)
    for verb, flags in (("run", ("--in-process",)), ("simulate", ())):
        done = ecyl_here(verb, *arguments, "--out", tmp_path / f"{verb}.mcap", *flags)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "run.mcap").read_bytes() == (tmp_path / "simulate.mcap").read_bytes()
    assert len(read_recording(tmp_path / "run.mcap")) == 100
