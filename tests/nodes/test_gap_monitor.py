"""The gap monitor: fed with runs of known drives, its residuals and its words are as they must."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.reference.spec import make_reference
from ecyl_ros.gap.replay.sensor_noise import silent

from .conftest import SINE, node
from .monitor_bench import STATUS, SWING, Bench, recorded, values_of


@pytest.fixture
def bench() -> Iterator[Bench]:
    """A monitor of the bench drive, and who talks to it."""
    rclpy.init(args=[])
    made = Bench()
    yield made
    made.close()
    rclpy.try_shutdown()


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


def test_a_drive_that_starts_again_is_followed_again(bench: Bench) -> None:
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


def test_a_gap_in_the_stamps_restarts_the_twin(bench: Bench) -> None:
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
            heard_by = "recorder:=gap_monitor"  # they begin when the monitor hears them
            others = [
                node("controller", heard_by),
                node("reference", timed, heard_by, f'reference:="{SINE}"'),
            ]
            plant = node("plant", timed, heard_by)
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
