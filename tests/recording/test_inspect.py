"""`ecyl inspect`, the map it proposes, the stretch that is taken of a long recording."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest
from foreign_bags import as_sqlite, foreign_mcap
from mcap.writer import Writer
from recording_samples import assert_same, made

from ecyl_ros.cli.main import main
from ecyl_ros.recording import Recording
from ecyl_ros.recording.candidates import candidates_of
from ecyl_ros.recording.load import load_recording, load_stretch
from ecyl_ros.recording.map import SignalMap
from ecyl_ros.recording.map_file import load_map
from ecyl_ros.recording.mapped import contract_map, read_mapped
from ecyl_ros.recording.messages import definition, typestore
from ecyl_ros.recording.propose import propose
from ecyl_ros.recording.stretch import pick_stretches
from ecyl_ros.recording.survey import FieldSurvey, TopicSurvey, survey
from ecyl_ros.recording.writer import write_recording

START_NS = 1_700_000_000_000_000_000


def test_figures_are_those_of_the_samples(tmp_path: Path) -> None:
    """Counts, ranges, means and deviations equal numpy's over the whole, for every field."""
    recording = made(3000)
    write_recording(recording, tmp_path / "a.mcap")
    topics = {one.name: one for one in survey(tmp_path / "a.mcap").topics}
    fields = {one.path: one for one in topics["/ecyl/joint_states"].fields}
    rotor = recording.rotor_velocity_rad_per_s
    found = fields["velocity[0]"]
    assert (found.count, found.low, found.high) == (3000, rotor.min(), rotor.max())
    assert found.mean == pytest.approx(rotor.mean(), abs=1e-12)
    assert found.std == pytest.approx(rotor.std(), rel=1e-9)
    assert found.travel == pytest.approx(np.abs(np.diff(rotor)).sum(), rel=1e-12)
    assert found.turns == int((np.diff(np.sign(np.diff(rotor))) != 0).sum())
    stamps = topics["/ecyl/voltage"].stamps
    assert stamps is not None
    assert (stamps.count, stamps.rate_hz, stamps.lost, stamps.gaps) == (3000, 1000.0, 0, ())
    assert (stamps.first_ns, stamps.last_ns) == tuple(recording.stamp_ns[[0, -1]])


def late(path: Path, *, gaps: tuple[tuple[int, int], ...], drift: float) -> None:
    """Float64 with header-less times, and JointStates whose clock differs, with samples lost."""
    types = typestore().types
    kind = "sensor_msgs/msg/JointState"
    random = np.random.default_rng(2)
    lost = {i for begin, count in gaps for i in range(begin, begin + count)}
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("ros2", "test")
        schema = writer.register_schema(kind, "ros2msg", definition(kind).encode())
        channel = writer.register_channel("/joints", "cdr", schema)
        for i in range(20_000):
            if i in lost:
                continue
            stamp = START_NS + i * 1_000_000
            log = stamp + 3_000_000_000 + round(i * 1e6 * drift) + round(random.exponential(3e5))
            message = types[kind](
                header=types["std_msgs/msg/Header"](
                    stamp=types["builtin_interfaces/msg/Time"](
                        sec=stamp // 10**9, nanosec=stamp % 10**9
                    ),
                    frame_id="",
                ),
                name=["motor"],
                position=np.array([float(i)]),
                velocity=np.zeros(0),
                effort=np.zeros(0),
            )
            data = bytes(typestore().serialize_cdr(message, kind))
            writer.add_message(channel, log, data, log)
        writer.finish()


def test_gaps_and_clocks_are_measured(tmp_path: Path) -> None:
    """Lost samples are counted, gaps placed to the ms, offset and drift of the clock found."""
    late(tmp_path / "a.mcap", gaps=((5000, 40), (9000, 1), (15000, 700)), drift=25e-6)
    (topic,) = survey(tmp_path / "a.mcap").topics
    stamps, clock = topic.stamps, topic.clock
    assert stamps is not None and clock is not None
    assert stamps.lost == 741
    expected = [(14.999, 0.701), (4.999, 0.041), (8.999, 0.002)]
    np.testing.assert_allclose(stamps.gaps[:3], expected, atol=1e-9)
    assert clock.offset_s == pytest.approx(3.0, abs=2e-4)
    assert clock.drift == pytest.approx(25e-6, abs=3.0 * clock.drift_error + 2e-6)
    assert clock.drift_error < 5e-6
    assert clock.delay_s == pytest.approx(3e-4 * np.log(2.0), rel=0.2)


@pytest.mark.parametrize("kind", ["mcap", "db3"])
def test_the_proposed_map_reads_the_recording(tmp_path: Path, kind: str) -> None:
    """Of a ros2_control machine's bag the joint that moves is found, and its signals, by name."""
    foreign_mcap(tmp_path / "a.mcap")
    if kind == "db3":
        as_sqlite(tmp_path / "a.mcap", tmp_path / "a.db3")
    out = tmp_path / "m.yaml"
    assert main(["inspect", str(tmp_path / f"a.{kind}"), "--write-map", str(out)]) == 0
    recording = read_mapped(tmp_path / f"a.{kind}", load_map(out))
    expected = 0.01 * np.sin(0.1 * np.arange(60))
    np.testing.assert_array_equal(recording.reference_position_m, expected)
    measured = recording.rod_position_m
    assert min(np.abs(measured - expected).max(), np.abs(measured - expected - 1e-5).max()) < 1e-12
    assert recording.has("rod_force_n")


def test_our_own_topics_are_recognised(tmp_path: Path) -> None:
    """Of our own recording the map holds every signal that was measured, and reads the same."""
    recording = made(40, without=("rod_velocity_m_per_s", "voltage_d_v"))
    write_recording(recording, tmp_path / "a.mcap")
    proposal = propose(survey(tmp_path / "a.mcap"))
    assert proposal.map is not None
    assert_same(read_mapped(tmp_path / "a.mcap", proposal.map), recording)


@pytest.mark.parametrize(
    ("header", "expected"),
    [
        (
            "time_ms,cmd_pos_mm,motor_angle_deg,motor_speed_rpm,Iq [A]",
            {
                "reference_position": "mm",
                "rotor_position": "deg",
                "rotor_velocity": "rpm",
                "current_q": "A",
            },
        ),
        (
            "t,setpoint,rodPosition,motorTorque",
            {"rod_position": "m", "effort": "N m"},
        ),
        ("t,a,b,c", {}),
        ("t,theta,vbus_current,bus_voltage,iq", {"rotor_position": "rad", "current_q": "A"}),
        ("t,theta,DCBusVoltage,IBusCurrent,iq", {"rotor_position": "rad", "current_q": "A"}),
    ],
)
def test_columns_are_recognised_by_their_names(
    tmp_path: Path, header: str, expected: dict[str, str]
) -> None:
    """Words and units in the names of columns decide; names without meaning propose nothing."""
    columns = header.count(",") + 1
    rows = "\n".join(",".join(str(i * (k + 1)) for k in range(columns)) for i in range(30))
    (tmp_path / "a.csv").write_text(f"{header}\n{rows}\n")
    found = propose(survey(tmp_path / "a.csv")).map
    names = {} if found is None else {one.name: one.unit for one in found.signals}
    assert names == expected
    if "time_ms" in header:
        assert found is not None and found.time is not None
        assert (found.time.field, found.time.unit) == ("time_ms", "ms")


@pytest.mark.parametrize(
    ("header", "expected", "because"),
    [
        (
            "time,position,velocity,torque",
            {"rotor_position": "rad", "rotor_velocity": "rad/s", "effort": "N m"},
            'for "torque" names a torque',
        ),
        (
            "time,position,velocity,force",
            {"rod_position": "m", "rod_velocity": "m/s", "effort": "N"},
            'for "force" names a force',
        ),
        (
            "time,target_position,slide_mm,velocity,effort",
            {
                "reference_position": "m",
                "rod_position": "mm",
                "rod_velocity": "m/s",
                "effort": "N",
            },
            'for "slide_mm" is in mm',
        ),
        (
            "t,joint_position,joint_velocity,current",
            {"rotor_position": "rad", "rotor_velocity": "rad/s", "current_q": "A"},
            "names a joint",
        ),
        (
            "t,q_cmd,qd_cmd,q,q_dot,q_ddot,tau_measured",
            {
                "reference_position": "rad",
                "reference_velocity": "rad/s",
                "rotor_position": "rad",
                "rotor_velocity": "rad/s",
                "effort": "N m",
            },
            "",
        ),
        (
            "t,q1,q2,dq_1,dq_2,tau1,tau2",
            {"rotor_position": "rad", "rotor_velocity": "rad/s", "effort": "N m"},
            "joint 1 moves most of 1, 2",
        ),
        (
            "t,vel_meas1,vel_meas2,pos_meas1,pos_meas2,tau_con1,tau_con2,tau_meas1,tau_meas2",
            {"rotor_position": "rad", "rotor_velocity": "rad/s", "effort": "N m"},
            "joint 1 moves most of 1, 2",
        ),
        (
            "t,Drive 0 Velocity,Drive 1 Velocity,Drive 0 Angle,Drive 1 Angle,Drive 0 Torque,"
            "Drive 1 Torque",
            {"rotor_position": "rad", "rotor_velocity": "rad/s", "effort": "N m"},
            "joint 0 moves most of 0, 1",
        ),
        (
            "t,hip_vel,knee_vel,hip_pos,knee_pos,knee_tau,knee_target_pos",
            {
                "reference_position": "rad",
                "rotor_position": "rad",
                "rotor_velocity": "rad/s",
                "effort": "N m",
            },
            "joint knee moves most of",
        ),
        (
            "t,position,velocity,current",
            {"rod_position": "m", "rod_velocity": "m/s", "current_q": "A"},
            "the name leaves open whether it is rotor_velocity",
        ),
    ],
)
@pytest.mark.parametrize("size", [0.4, 2.5])
def test_signals_of_one_axis_are_proposed_together(
    tmp_path: Path, header: str, expected: dict[str, str], because: str, size: float
) -> None:
    """Position and speed are both of an angle or both of a length, whatever their ranges, as one
    unit, a torque, a force or a joint tells; derivatives are speeds, and joints are kept apart."""
    count = header.count(",")
    rows = [
        f"{0.01 * i:.2f},"
        + ",".join(f"{size / (1 + k // 7) * np.sin(0.1 * (k + 1) * i):.5f}" for k in range(count))
        for i in range(300)
    ]
    (tmp_path / "a.csv").write_text("\n".join([header, *rows]) + "\n")
    proposed = propose(survey(tmp_path / "a.csv"))
    assert proposed.map is not None
    assert {one.name: one.unit for one in proposed.map.signals} == expected
    assert because in "\n".join(proposed.remarks)
    fields = [one.field for one in proposed.map.signals]
    assert not {"q2", "dq_2", "tau2", "q_ddot", "tau_con1"}.intersection(fields)
    assert not any(one.startswith(("hip", "Drive 1")) or one.endswith("meas2") for one in fields)


def test_the_joint_that_moves_most_is_told_by_its_travel(tmp_path: Path) -> None:
    """A shoulder that holds 90 N m swinging moves less than a wrist that turns under 3 N m."""
    rows = [
        f"{0.01 * i:.2f},{0.3 * np.sin(0.1 * i):.5f},{1.2 * np.sin(0.1 * i):.5f},"
        f"{90.0 * np.cos(0.1 * i):.4f},{3.0 * np.cos(0.1 * i):.4f}"
        for i in range(300)
    ]
    (tmp_path / "a.csv").write_text("\n".join(["t,q0,q1,tau0,tau1", *rows]) + "\n")
    assert "joint 1 moves most of 0, 1" in "\n".join(propose(survey(tmp_path / "a.csv")).remarks)


def test_readings_of_one_quantity_are_no_joints() -> None:
    """Numbers are joints' where two quantities bear them; two encoders alone are one drive's."""
    for header, places in (
        ("pos1,pos2,speed,current", {""}),
        ("pos1,pos2,speed1,speed2,current", {"1", "2", ""}),
        ("elbow_pos,left_knee_pos", {"elbow", "left knee"}),
        ("frame_angle_rad,wheel_speed_rad_s,current_A", {"frame", "wheel", ""}),
    ):
        fields = tuple(
            FieldSurvey(one, "", 9, 0.0, 1.0, 0.5, 0.1, 2.0, 3, 0.0) for one in header.split(",")
        )
        found = candidates_of(TopicSurvey("", "CSV", None, None, None, {}, fields))
        assert {one.place for one in found} == places


def test_a_first_column_that_goes_up_evenly_is_of_instants(tmp_path: Path) -> None:
    """Without names: its unit by its steps, and a map to write by hand is shown."""
    rows = "".join(f"{2e-3 * i:.3f},{(i % 7) / 7:.4f}\n" for i in range(200))
    (tmp_path / "a.csv").write_text(rows)
    found = survey(tmp_path / "a.csv")
    assert found.time is not None and (found.time.field, found.time.unit) == ("column_1", "s")
    (said,) = propose(found).remarks
    told = re.search(r"\{.*\}", said)
    assert told is not None
    (tmp_path / "m.yaml").write_text(told[0])
    recording = read_mapped(tmp_path / "a.csv", load_map(tmp_path / "m.yaml"))
    assert recording.rotor_position_rad[3] == 0.4286


@pytest.mark.parametrize(("at_rest", "kept"), [(35.0, False), (0.0, True)])
def test_a_supplys_voltage_is_not_proposed_as_the_motors(
    tmp_path: Path, at_rest: float, kept: bool
) -> None:
    """A voltage that stays while the motor turns back is the supply's, and is left out aloud."""
    time_s = np.arange(500) * 0.01
    speed = 6.0 * np.sin(3.0 * time_s)
    table = np.column_stack([time_s, speed, at_rest + 0.1 * speed])
    path = tmp_path / "bench.csv"
    header = "t_s,motor speed [rad/s],voltage [V]"
    np.savetxt(path, table, delimiter=",", comments="", header=header)
    proposed = propose(survey(path))
    assert proposed.map is not None
    assert ("voltage_q" in {one.name for one in proposed.map.signals}) is kept
    assert any("supply" in one for one in proposed.remarks) is not kept


def test_a_sensors_volts_are_not_the_motors(tmp_path: Path) -> None:
    """Volts beside the same reading in mm are no voltage; a column that no name explains is told,
    and a temperature is not."""
    time_s = np.arange(500) * 0.01
    x = 6.0 * np.sin(3.0 * time_s)
    path = tmp_path / "bench.csv"
    header = "t_s,laser_V,laser_mm,load,temp"
    table = np.column_stack([time_s, 3.0 + 0.1 * x, x, np.cos(time_s), time_s])
    np.savetxt(path, table, delimiter=",", comments="", header=header)
    proposed = propose(survey(path))
    assert proposed.map is not None
    assert {one.name: one.field for one in proposed.map.signals} == {"rod_position": "laser_mm"}
    assert any(one.startswith("laser_V is left out") for one in proposed.remarks)
    (unread,) = [one for one in proposed.remarks if "the name says no signal" in one]
    assert unread.startswith("load:")


def test_a_header_without_rows_is_seen_as_empty(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A logger that wrote its header and no more gives no samples, in a line, not a traceback."""
    path = tmp_path / "begun.csv"
    path.write_text("time [s],motor position [rad]\n")
    assert main(["inspect", str(path)]) == 0
    assert re.search(r"\(rows\) +CSV +0 ", capsys.readouterr().out)
    drive = tmp_path / "axis.yaml"
    drive.write_text("/**: {ros__parameters: {drive: {kind: follower, output: rotary}}}\n")
    given = tmp_path / "map.yaml"
    field = "{field: 'motor position [rad]', unit: rad}"
    given.write_text(f"schema: ecyl.map/1\nsignals: {{rotor_position: {field}}}\n")
    assert main(["diagnose", str(path), "--map", str(given), "--drive", str(drive)]) == 2
    assert "begun.csv: the table: no samples" in capsys.readouterr().err


def test_a_rod_counted_the_other_way_is_seen(tmp_path: Path) -> None:
    """A position whose range mirrors the reference's is proposed with sign -1, and a remark."""
    time = np.arange(2000) * 1e-3
    rod = np.sin(5.0 * time) + 0.5
    rows = "\n".join(f"{t:.3f},{r:.6f},{-r:.6f}" for t, r in zip(time, rod, strict=True))
    (tmp_path / "a.csv").write_text(f"t,target_mm,slide_mm\n{rows}\n")
    proposal = propose(survey(tmp_path / "a.csv"))
    assert proposal.map is not None
    assert {one.name: one.sign for one in proposal.map.signals} == {
        "reference_position": 1,
        "rod_position": -1,
    }
    assert any("mirrors" in remark for remark in proposal.remarks)


def test_json_and_outputs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """JSON holds what is printed; existing outputs and the recording itself are never replaced."""
    late(tmp_path / "a.mcap", gaps=((5000, 40),), drift=0.0)
    out = tmp_path / "i.json"
    assert main(["inspect", str(tmp_path / "a.mcap"), "--json", str(out)]) == 0
    data = json.loads(out.read_text())
    assert data["schema"] == "ecyl.inspection/1"
    (topic,) = data["topics"]
    assert topic["header"]["lost"] == 40
    assert "rotor_position" in data["map"]
    printed = capsys.readouterr().out
    assert "longest gaps 41 ms" in printed or "longest gaps 0.041 s" in printed
    assert main(["inspect", str(tmp_path / "a.mcap"), "--json", str(out)]) == 2
    assert main(["inspect", str(tmp_path / "a.mcap"), "--json", str(tmp_path / "a.mcap")]) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert main(["inspect", str(tmp_path / "a.mcap"), "--json", str(out), "--overwrite"]) == 0


def lively(path: Path, seconds: int, begin: float, length: float) -> Recording:
    """A recording at 500 Hz that rests, but for a stretch of moves."""
    time = np.arange(seconds * 500) / 500.0
    random = np.random.default_rng(4)
    moving = (time >= begin) & (time < begin + length)
    rod = np.where(moving, 0.01 * np.sin(2.0 * np.pi * 0.7 * (time - begin)), 0.0)
    recording = Recording(
        stamp_ns=START_NS + (np.arange(time.size) * 2_000_000),
        reference_position_m=rod,
        rod_position_m=rod + random.normal(scale=1e-6, size=rod.size),
        rotor_position_rad=rod * 600.0,
        current_q_a=np.gradient(np.gradient(rod)) * 1e3 + random.normal(scale=1e-3, size=rod.size),
    )
    write_recording(recording, path)
    return recording


def test_the_liveliest_stretch_of_a_long_recording_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 200 s that move for 12 s alone, the 20 s taken hold these, sample for sample."""
    whole = lively(tmp_path / "a.mcap", 200, 121.3, 12.0)
    assert_same(load_stretch(tmp_path / "a.mcap", None, 20.0), load_recording(tmp_path / "a.mcap"))
    monkeypatch.setattr("ecyl_ros.recording.load.WHOLE_BYTES", 0)
    part = load_stretch(tmp_path / "a.mcap", None, 20.0)
    begin = (part.stamp_ns[0] - START_NS) / 1e9
    assert begin <= 121.3 and begin + 20.0 >= 133.3
    assert len(part) == 10_000
    assert_same(part, whole.slice(begin, begin + 20.0 - 1e-9))
    assert "200 s long: judged from" in part.notes[0]
    assert "travel, reversals, range" in part.notes[0]


def test_a_stretch_with_its_samples_lost_is_no_good_one(tmp_path: Path) -> None:
    """Of two equally lively stretches the one without losses is taken."""
    time = np.arange(100_000) / 500.0
    rod = np.where((time > 30) & (time < 50) | (time > 130) & (time < 150), np.sin(4 * time), 0.0)
    keep = np.ones(time.size, dtype=bool)
    keep[(time > 33) & (time < 48)] = np.random.default_rng(1).random(7499) > 0.7
    recording = Recording(
        stamp_ns=(START_NS + np.arange(time.size) * 2_000_000)[keep],
        reference_position_m=rod[keep],
        rod_position_m=rod[keep],
    )
    write_recording(recording, tmp_path / "a.mcap")
    own = contract_map_of("rod", "reference")
    found = pick_stretches(tmp_path / "a.mcap", own, 20.0)
    assert found is not None
    assert (found.chosen[0].start_ns - START_NS) / 1e9 == pytest.approx(130.0, abs=1.5)
    assert pick_stretches(tmp_path / "a.mcap", own, 300.0) is None


def contract_map_of(*starts: str) -> SignalMap:
    """The part of our own map whose signals begin so, of positions."""
    own = contract_map()
    kept = tuple(
        one for one in own.signals if one.name in {f"{start}_position" for start in starts}
    )
    return dataclasses.replace(own, signals=kept)


def test_a_unit_may_be_spoken_and_whole_steps_of_time_are_a_counters(tmp_path: Path) -> None:
    """`Angle in deg` is in deg; a column called time that goes up by 2 or 3 is in ms, and that is
    said."""
    rows = "".join(f"{900 + 5 * (i // 2) + 2 * (i % 2)},{i % 90}.5\n" for i in range(300))
    (tmp_path / "a.csv").write_text(f"time,Angle in deg\n{rows}")
    found = propose(survey(tmp_path / "a.csv"))
    assert found.map is not None and found.map.time is not None
    assert found.map.time.unit == "ms"
    assert {one.name: one.unit for one in found.map.signals} == {"rotor_position": "deg"}
    assert any("ms is guessed from the steps of time" in one for one in found.remarks)
