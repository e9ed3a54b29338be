"""Units that a map or a header tells: known, unknown, in conflict, counts and their step."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from ecyl_ros.cli.main import main
from ecyl_ros.errors import InputError
from ecyl_ros.recording.csvfile import read_csv, write_csv
from ecyl_ros.recording.headers import ending
from ecyl_ros.recording.load import load_recording
from ecyl_ros.recording.map import map_yaml
from ecyl_ros.recording.map_file import load_map, parse_map
from ecyl_ros.recording.mapped import read_mapped
from ecyl_ros.recording.propose import propose
from ecyl_ros.recording.signals import Recording
from ecyl_ros.recording.survey import survey
from ecyl_ros.recording.writer import write_recording


def table(tmp_path: Path, header: str, values: str = "0,1;0.001,2;0.002,4") -> Path:
    rows = values.replace(";", "\n")
    (tmp_path / "a.csv").write_text(f"{header}\n{rows}\n")
    return tmp_path / "a.csv"


def read(path: Path, **entry: object) -> Recording:
    (name, own), *_ = entry.items()
    return read_mapped(path, parse_map({"signals": {name: own}}, "m"))


@pytest.mark.parametrize(
    ("header", "si"),
    [
        ("t,pos [mm]", 1e-3),
        ("t,pos (um)", 1e-6),
        ("t,pos (in mm)", 1e-3),
        ("t,pos [µm]", 1e-6),
        ("t,pos_mm", 1e-3),
        ("t,pos", 1.0),
        ("t,pos (actual)", 1.0),
        ("t,pos\ns,mm", 1e-3),
        ("t,pos[1]", 1.0),
    ],
)
def test_a_header_tells_the_unit_where_the_map_does_not(
    tmp_path: Path, header: str, si: float
) -> None:
    """Brackets, a line of units and the end of a name are taken, and SI only where none is told."""
    path = table(tmp_path, header)
    column = header.split("\n")[0].split(",")[1]
    found = read(path, rod_position={"field": column})
    np.testing.assert_allclose(found.rod_position_m, np.array([1.0, 2.0, 4.0]) * si, rtol=1e-15)
    assert any("as the header of" in note for note in found.notes) == (si != 1.0)


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("speed_mm_s", "mm/s"),
        ("speed_mm_per_s", "mm/s"),
        ("feed_mm_per_min", "mm/min"),
        ("speed_rad_s", "rad/s"),
        ("rate_counts_s", "counts/s"),
        ("stamp_s", "s"),
        ("flux_v_s", "s"),
    ],
)
def test_a_rate_is_told_with_and_without_per(name: str, unit: str) -> None:
    """`_mm_s` is mm/s, not seconds; what is no rate of a known unit ends in seconds."""
    assert ending(name) == unit


@pytest.mark.parametrize(
    ("name", "unit"),
    [("command_nm", "N m"), ("torque_Nm", "N m"), ("stroke_um", "um"), ("travel_mm", "mm")],
)
def test_a_name_that_ends_in_nm_is_of_a_torque(name: str, unit: str) -> None:
    """Whatever else it says: no drive is commanded in nanometres. A length in nm is called one."""
    assert ending(name) == unit
    assert ending("stroke_nm", ("length",)) == "nm"


@pytest.mark.parametrize("header", ["t,pos [foo]", "t,pos (foo)", "t,pos\ns,foo"])
def test_an_unknown_unit_in_a_header_is_refused_by_name(tmp_path: Path, header: str) -> None:
    """A word that is no known unit is named with those that are, and never taken for SI."""
    path = table(tmp_path, header)
    column = header.split("\n")[0].split(",")[1]
    with pytest.raises(InputError, match=r"says foo, and unit foo is not known; known are m, cm"):
        read(path, rod_position={"field": column})
    told = read(path, rod_position={"field": column, "unit": "mm"})
    np.testing.assert_allclose(told.rod_position_m, [1e-3, 2e-3, 4e-3])
    proposal = propose(survey(path))
    assert proposal.map is None
    assert any("unit foo is not known" in remark for remark in proposal.remarks)


def test_an_unknown_unit_in_a_map_is_refused_by_name() -> None:
    """The word and the known ones are named; amperes RMS come with the factor they need."""
    with pytest.raises(
        InputError, match=r"unit furlong is not known; known are .*; expected one of m"
    ):
        parse_map({"signals": {"rod_position": {"field": "x", "unit": "furlong"}}}, "m")
    with pytest.raises(InputError, match=r"unit Arms is not known .*scale: 1\.4142"):
        parse_map({"signals": {"current_q": {"field": "i", "unit": "Arms"}}}, "m")
    with pytest.raises(InputError, match=r"time\.unit: is fortnight, expected one of s, ms"):
        parse_map(
            {"signals": {"rod_position": "x"}, "time": {"field": "t", "unit": "fortnight"}}, "m"
        )


def test_a_conflict_of_units_says_which_two(tmp_path: Path) -> None:
    """Map and header are both quoted; a scale says that the map converts, and is let pass."""
    path = table(tmp_path, "t,pos [um]")
    with pytest.raises(InputError) as raised:
        read(path, rod_position={"field": "pos [um]", "unit": "mm"})
    assert "signals.rod_position.unit: the map says mm, but the header of pos [um] says um" in str(
        raised.value
    )
    found = read(path, rod_position={"field": "pos [um]", "unit": "mm", "scale": 1e-3})
    np.testing.assert_allclose(found.rod_position_m, [1e-6, 2e-6, 4e-6])
    turned = table(tmp_path, "t,pos [deg]")
    with pytest.raises(
        InputError, match=r"says deg, which measures angle, but rod_position is length"
    ):
        read(turned, rod_position={"field": "pos [deg]"})


def test_the_header_of_a_time_tells_its_unit(tmp_path: Path) -> None:
    """`Time [ms]` is in ms; `Time [foo]` is refused by name."""
    path = table(tmp_path, "Time [ms],pos_mm", "0,1;1,2;2,4")
    assert read(path, rod_position="pos_mm").duration_s == pytest.approx(2e-3)
    path = table(tmp_path, "Time [foo],pos_mm", "0,1;1,2;2,4")
    with pytest.raises(InputError, match="unit foo is not known"):
        read(path, rod_position="pos_mm")


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ({"unit": "counts"}, "is in counts; expected what they are worth: counts_per_rev"),
        ({"unit": "counts", "counts_per_m": 1e6}, "counts_per_rev, not counts_per_m"),
        ({"unit": "rad", "counts_per_rev": 4096}, "goes with unit: counts, but unit is rad"),
        ({"counts_per_rev": 4096}, "goes with unit: counts, but unit is rad"),
        (
            {"unit": "counts", "counts_per_rev": 0},
            "counts_per_rev: is 0, expected a number above 0",
        ),
        ({"unit": "counts/s", "counts_per_rev": 4096}, "is counts/s, expected one of rad"),
        ({"resolution": -1}, "resolution: is -1, expected a number above 0"),
    ],
)
def test_counts_without_their_worth_are_refused(entry: dict, said: str) -> None:
    """A position in counts is never read as rad: what one is worth has to be told."""
    with pytest.raises(InputError) as raised:
        parse_map({"signals": {"rotor_position": {"field": "q", **entry}}}, "m")
    assert said in str(raised.value)


def test_counts_become_si_and_their_step_is_known(tmp_path: Path) -> None:
    """4096 counts are one turn, 10000 counts a metre; the recording knows the steps in SI."""
    path = table(tmp_path, "t,q,v,x", "0,0,0,0;0.001,1024,4096,10;0.002,2048,0,-20")
    tree = {
        "signals": {
            "rotor_position": {"field": "q", "unit": "counts", "counts_per_rev": 4096},
            "rotor_velocity": {"field": "v", "unit": "counts/s", "counts_per_rev": 4096},
            "rod_position": {"field": "x", "unit": "ticks", "counts_per_m": 1e4, "scale": 2},
        }
    }
    own = parse_map(tree, "m")
    found = read_mapped(path, own)
    np.testing.assert_allclose(found.rotor_position_rad, [0.0, math.pi / 2, math.pi])
    np.testing.assert_allclose(found.rotor_velocity_rad_per_s, [0.0, math.tau, 0.0])
    np.testing.assert_allclose(found.rod_position_m, [0.0, 2e-3, -4e-3])
    assert found.resolution == pytest.approx(
        {
            "rotor_position_rad": math.tau / 4096,
            "rotor_velocity_rad_per_s": math.tau / 4096,
            "rod_position_m": 2e-4,
        }
    )
    assert found.slice(0.001).resolution == found.resolution
    (tmp_path / "m.yaml").write_text(map_yaml(own))
    assert load_map(tmp_path / "m.yaml").signals == own.signals


def test_a_stated_resolution_is_kept_in_si(tmp_path: Path) -> None:
    """`resolution: 0.5` of a scale in um is 0.5e-6 m."""
    entry = {"field": "pos", "unit": "um", "resolution": 0.5}
    assert read(table(tmp_path, "t,pos"), rod_position=entry).resolution == {"rod_position_m": 5e-7}


@pytest.mark.parametrize(
    "header", ["t,motor_position [counts]", "t,motor_position_counts", "t,motor_position"]
)
def test_a_position_in_counts_is_not_proposed_as_rad(tmp_path: Path, header: str) -> None:
    """By unit, name or large whole numbers: it is left out, and the remark says what to add."""
    rows = ";".join(f"{i * 1e-3},{37 * i}" for i in range(100))
    proposal = propose(survey(table(tmp_path, header, rows)))
    assert proposal.map is None
    assert any("in counts" in one and "counts_per_rev: N" in one for one in proposal.remarks)


def test_injected_forces_are_signals(tmp_path: Path) -> None:
    """A force on the rod and a torque on the rotor are mapped, kept by CSV, NaN where not given."""
    path = table(tmp_path, "t,injected_force_kn,pos_mm", "0,1,0;0.001,2,1;0.002,-3,0")
    tree = {
        "signals": {
            "injected_force": {"field": "injected_force_kn", "unit": "kN"},
            "injected_torque": {"field": "injected_force_kn", "unit": "mN m"},
            "rod_position": "pos_mm",
        }
    }
    found = read_mapped(path, parse_map(tree, "m"))
    np.testing.assert_allclose(found.injected_force_n, [1e3, 2e3, -3e3])
    np.testing.assert_allclose(found.injected_torque_nm, [1e-3, 2e-3, -3e-3])
    assert not read(path, rod_position="pos_mm").has("injected_force_n")
    write_csv(found, tmp_path / "b.csv")
    np.testing.assert_array_equal(read_csv(tmp_path / "b.csv").injected_force_n, [1e3, 2e3, -3e3])
    assert "injected_force" in {one.name for one in propose(survey(path)).map.signals}  # type: ignore[union-attr]


def test_what_no_topic_carries_is_told_when_a_bag_is_written(tmp_path: Path) -> None:
    """Our own topics have no place for an injected force: it is skipped, and its name returned."""
    recording = Recording(
        stamp_ns=np.arange(3) * 10**6, rod_position_m=np.zeros(3), injected_force_n=np.ones(3)
    )
    assert write_recording(recording, tmp_path / "a.mcap") == ("injected_force_n",)
    assert not load_recording(tmp_path / "a.mcap").has("injected_force_n")


def test_inspect_says_what_is_wrong_with_a_unit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`ecyl inspect` prints the unknown unit by name and proposes no signal of it."""
    assert main(["inspect", str(table(tmp_path, "t,rod_position [foo]"))]) == 0
    out = capsys.readouterr().out
    assert "unit foo is not known; known are m, cm" in out and "rod_position:" not in out


def test_a_column_called_time_is_in_seconds_unless_its_steps_say_that_it_is_not(
    tmp_path: Path,
) -> None:
    """Rows 400 apart are in us, and a remark says that this is guessed; rows 1 apart are in s, and
    one says that this is slow; rows 0.1 apart are, without a word."""
    for step, unit, said in (
        (400, "us", ["guessed from the steps"]),
        (1, "s", ["goes up by 1: few drives are logged so slowly"]),
        (0.1, "s", []),
    ):
        rows = "\n".join(f"{step * row},{math.sin(0.01 * row)}" for row in range(300))
        path = tmp_path / f"{step}.csv"
        path.write_text(f"time,rotor_position [rad]\n{rows}\n")
        proposal = propose(survey(path))
        assert proposal.map is not None and proposal.map.time is not None
        assert proposal.map.time.unit == unit
        remarks = [one for one in proposal.remarks if one.startswith("time:")]
        assert len(remarks) == len(said)
        assert all(told in one for told, one in zip(said, remarks, strict=True))
