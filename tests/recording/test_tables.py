"""CSV and MAT files of other makes."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from recording_samples import assert_same, made
from scipy.io import loadmat, savemat
from scipy.io.matlab import MatlabOpaque

from ecyl_ros.errors import InputError
from ecyl_ros.recording.csvfile import write_csv
from ecyl_ros.recording.csvtable import CsvTable
from ecyl_ros.recording.load import load_recording
from ecyl_ros.recording.map_file import parse_map
from ecyl_ros.recording.mapped import contract_map, read_mapped
from ecyl_ros.recording.matcheck import MatError, check_mat
from ecyl_ros.recording.mattable import MatTable
from ecyl_ros.recording.messages import typestore
from ecyl_ros.recording.propose import propose
from ecyl_ros.recording.survey import survey

SHARED = Path(__file__).parents[3] / "shared" / "field"
field = pytest.mark.skipif(not SHARED.is_dir(), reason="no ../shared/field beside the repository")
POSITION = {"signals": {"rod_position": {"field": "pos", "unit": "mm"}}}


def mapped(path: Path, tree: dict | None = None, **more: object) -> np.ndarray:
    """The rod's position, m, of a file with a column `pos` in mm."""
    return read_mapped(path, parse_map({**(tree or POSITION), **more}, "m")).rod_position_m


@pytest.mark.parametrize(
    "text",
    [
        "time,pos\n0,1\n0.001,2.5\n0.002,-3\n",
        "\ufefftime,pos\r\n0,1\r\n0.001,2.5\r\n0.002,-3\r\n",
        "time;pos\n0;1\n0,001;2,5\n0,002;-3\n",
        "# rig 7\ntime\tpos\n0\t1\n0.001\t2.5\n0.002\t-3",
        "% time pos\n0 1\n0.001 2.5\n0.002 -3\n",
        'time , "pos" , note\n0, 1, start\n0.001, 2.5, "a, b"\n0.002, -3,\n',
        "time,pos\ns,mm\n0,1\n0.001,2.5\n0.002,-3\n\n\n",
        "time,pos\n0,1\n0.001,2.5\n0.002,-3\n0.003",
        "time\tpos\t\n0\t1\t\n0.001\t2.5\t\n0.002\t-3\t\n",
    ],
)
def test_the_same_table_in_many_spellings(tmp_path: Path, text: str) -> None:
    """Delimiter, decimal sign, byte mark, comments, quotes, units and a cut end change nothing."""
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    np.testing.assert_allclose(mapped(tmp_path / "a.csv"), [1e-3, 2.5e-3, -3e-3], rtol=1e-15)


def test_metadata_in_cells_above_a_table_are_no_rows(tmp_path: Path) -> None:
    """Pairs of label and value as a data acquisition writes them; the second column of instants
    has the first one's name, and the labels of the line of units are no units."""
    above = (
        "Timestamp,2020-03-16 17:04:51,Timestamp,2020-03-16 17:04:51\n"
        "Interval,0.0005,Interval,0.0005\n"
        'Channel name,"pos",Channel name,"force"\n'
        "Unit,mm,Unit,V\n"
    )
    rows = "".join(f"{0.5 * i},{i},{0.5 * i},{2 * i}\n" for i in range(20))
    (tmp_path / "a.csv").write_text(above + rows)
    tree = {
        "time": {"field": "Channel name", "unit": "ms"},
        "signals": {"rod_position": "pos", "voltage_q": "force"},
    }
    recording = read_mapped(tmp_path / "a.csv", parse_map(tree, "m"))
    np.testing.assert_allclose(recording.rod_position_m, 1e-3 * np.arange(20), rtol=1e-12)
    np.testing.assert_allclose(recording.voltage_q_v, 2.0 * np.arange(20), rtol=1e-12)
    assert np.diff(recording.stamp_ns)[0] == 500_000
    assert any("is read as Channel name.1" in note for note in recording.notes)


def test_columns_of_one_name_are_numbered(tmp_path: Path) -> None:
    """The third of three columns called pos is pos.2, and instants may be called by their unit."""
    rows = "".join(f"{0.5 * i},0,1,{i}\n" for i in range(20))
    (tmp_path / "a.csv").write_text("Time,A,B,C\nms,pos,pos,pos\n" + rows)
    tree = {"signals": {"rod_position": {"field": "pos.2", "unit": "mm"}}}
    recording = read_mapped(tmp_path / "a.csv", parse_map(tree, "m"))
    np.testing.assert_allclose(recording.rod_position_m, 1e-3 * np.arange(20), rtol=1e-12)
    assert np.diff(recording.stamp_ns)[0] == 500_000


@pytest.mark.parametrize(
    ("before", "header", "left_out"),
    [
        ("Machine: X\nOperator: Y, Z\n\n", "time,pos,note\n", "2 lines"),
        ("Date,2024-01-01\n", "time,pos,note\ns,mm,\n", "1 line"),
        ("Motor,Motor,Load\n", "time,pos,note\n", "1 line"),
        ("# rig 7\n", "time,pos,note\n", ""),
    ],
)
def test_what_a_logger_writes_above_a_table_is_left_out(
    tmp_path: Path, before: str, header: str, left_out: str
) -> None:
    """The values are those of the table alone, and a note says how many lines went."""
    rows = "".join(f"{0.001 * i:.3f},{i},\n" for i in range(20))
    (tmp_path / "a.csv").write_text(before + header + rows)
    recording = read_mapped(tmp_path / "a.csv", parse_map(POSITION, "m"))
    np.testing.assert_allclose(recording.rod_position_m, 1e-3 * np.arange(20), rtol=1e-12)
    told = [note for note in recording.notes if "before the table" in note]
    assert bool(told) == bool(left_out) and all(left_out in note for note in told)


def test_missing_values_and_rows_without_a_time(tmp_path: Path) -> None:
    """Empty cells and words for missing are NaN; a row without a time is left out and told."""
    (tmp_path / "a.csv").write_text("t,pos\n0,1\n1,\n2,NaN\n,7\n4,null\n5,2\n")
    recording = read_mapped(tmp_path / "a.csv", parse_map(POSITION, "m"))
    np.testing.assert_array_equal(recording.rod_position_m, [1e-3, *[np.nan] * 3, 2e-3])
    assert any("1 rows without t left out" in note for note in recording.notes)


def test_stamps_in_ns_keep_every_digit(tmp_path: Path) -> None:
    """A stamp of 19 digits comes back to the ns, though a float64 holds 16."""
    stamps = 1_700_000_000_123_456_789 + np.arange(5) * 1_000_003
    rows = "\n".join(f"{stamp},{i}" for i, stamp in enumerate(stamps.tolist()))
    (tmp_path / "a.csv").write_text(f"stamp_ns,pos\n{rows}\n")
    recording = read_mapped(tmp_path / "a.csv", parse_map(POSITION, "m"))
    np.testing.assert_array_equal(recording.stamp_ns, stamps)


def test_blocks_join_to_the_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file read in blocks of 1000 bytes gives what it gives in one."""
    recording = made(300)
    write_csv(recording, tmp_path / "a.csv")
    whole = [one for part in CsvTable(tmp_path / "a.csv").columns() for one in part.values.items()]
    monkeypatch.setattr("ecyl_ros.recording.csvtext.BLOCK_BYTES", 1000)
    parts = list(CsvTable(tmp_path / "a.csv").columns())
    assert len(parts) > 20
    for name, values in whole:
        np.testing.assert_array_equal(np.concatenate([p.values[name] for p in parts]), values)


def test_our_own_csv_needs_no_map(tmp_path: Path) -> None:
    """What `write_csv` wrote is read as it was, and the contract's map refuses a table's topics."""
    recording = made(60)
    write_csv(recording, tmp_path / "a.csv")
    assert_same(load_recording(tmp_path / "a.csv"), recording)
    with pytest.raises(InputError, match="has no topics"):
        read_mapped(tmp_path / "a.csv", contract_map())


def test_a_table_is_played_on_our_own_topics(tmp_path: Path) -> None:
    """`ecyl replay` with a map makes of a CSV a bag of our topics that holds its signals."""
    from ecyl_ros.cli.replay import _mapped

    (tmp_path / "a.csv").write_text("t,pos\n-1,1\n-0.5,2.5\n0,-3\n")
    (tmp_path / "m.yaml").write_text("signals: {rod_position: {field: pos, unit: mm}}\n")
    bag = _mapped(tmp_path / "a.csv", tmp_path / "m.yaml")
    assert list(bag.topics) == ["/ecyl/joint_states"]
    assert bag.topics["/ecyl/joint_states"].log_time_ns == [0, 500_000_000, 1_000_000_000]
    types = typestore()
    data = bag.topics["/ecyl/joint_states"].data
    values = [types.deserialize_cdr(one, "sensor_msgs/msg/JointState").position[1] for one in data]
    np.testing.assert_allclose(values, [1e-3, 2.5e-3, -3e-3], rtol=1e-15)


def test_without_a_map_a_foreign_table_asks_for_one(tmp_path: Path) -> None:
    """A CSV of other names is refused with the way to a map."""
    (tmp_path / "a.csv").write_text("t,pos\n0,1\n1,2\n")
    with pytest.raises(InputError, match=r"--map M\.yaml; ecyl inspect proposes one"):
        load_recording(tmp_path / "a.csv")


@pytest.mark.parametrize(
    ("text", "more", "said"),
    [
        ("t,pos\n0,1\n1,2,3\n", {}, "line 3: 3 cells, expected 2"),
        ("t,pos\n0,1\n1\n2,3\n", {}, "line 3: 1 cells, expected 2"),
        ("t,pos\n0,1\n1,two\n", {}, "line 3: pos is 'two', expected a number"),
        ("t,x\n0,1\n", {}, "no column pos; found t, x"),
        ("a,pos\n0,1\n", {}, "no column of"),
        ("t,pos\n0,1\n1,2\n", {"time": "when"}, "no column when"),
        ("t,pos,pos.1,pos\n0,1,1,1\n", {}, "two columns are called pos.1"),
        ("", {}, "is empty"),
        ("t,pos\n,1\n,2\n", {}, "no row has a number in t"),
        ("t,pos\n1e12,1\n2e12,2\n", {}, "expected a time"),
        ("t,pos\r0,1\r1,2\r", {}, "a carriage return within a line"),
        (
            "\n".join(",".join(["0.5"] * 300) for _ in range(3)),
            {},
            "3 rows of 300 columns, expected a signal in each column: transpose the table",
        ),
    ],
)
def test_tables_that_cannot_be_read_are_refused(
    tmp_path: Path, text: str, more: dict, said: str
) -> None:
    """Line, column and what was expected are named, in one line."""
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(InputError) as raised:
        mapped(tmp_path / "a.csv", **more)
    assert said in str(raised.value) and "\n" not in str(raised.value)


def test_a_folder_of_tables_and_cells_of_lists(tmp_path: Path) -> None:
    """Two CSV files are two topics; `positions[1]` is the second number of a cell's list."""
    times = np.arange(0, 3, 0.02)
    command = "\n".join(f'C,{t * 1e6:.1f},"[0.0, {np.sin(t):.9f}]"' for t in times)
    state = "\n".join(f'S,{t * 1e6:.1f},"[1.0, {np.sin(t - 0.1):.9f}]"' for t in times + 0.004)
    (tmp_path / "command.csv").write_text(f"type,timestamp,positions\n{command}\n")
    (tmp_path / "state.csv").write_text(f"type,timestamp,positions\n{state}\n")
    tree = {
        "time": {"field": "timestamp", "unit": "us"},
        "signals": {
            "reference_position": "command.positions[1]",
            "rod_position": {"topic": "state", "field": "positions[1]"},
        },
    }
    recording = read_mapped(tmp_path, parse_map(tree, "m"))
    seconds = recording.stamp_ns / 1e9
    np.testing.assert_allclose(recording.rod_position_m, np.sin(seconds - 0.1), atol=1e-8)
    known = np.isfinite(recording.reference_position_m)
    np.testing.assert_allclose(
        recording.reference_position_m[known], np.sin(seconds)[known], atol=1e-6
    )
    assert known.all()


def test_mat_vectors_matrices_and_structures(tmp_path: Path) -> None:
    """Columns of vectors, matrices and nested structures are found by path, in all versions."""
    time = np.arange(50) * 1e-3
    pair = np.column_stack([time * 2, time * 3])
    for version, options in {"4": {"format": "4"}, "5": {}, "7": {"do_compression": True}}.items():
        tree: dict = {"t": time, "pos": pair, "kp": 5.0}
        if version != "4":
            tree["out"] = {"signals": [{"values": time * 7}, {"values": pair.T}]}
        savemat(tmp_path / "a.mat", tree, **options)
        entry = {"signals": {"rod_position": "pos[1]"}}
        np.testing.assert_array_equal(mapped(tmp_path / "a.mat", entry), time * 3)
        if version != "4":
            entry = {"signals": {"rod_position": "out.signals[1].values[0]"}}
            np.testing.assert_array_equal(mapped(tmp_path / "a.mat", entry), time * 2)
        assert "kp" not in MatTable(tmp_path / "a.mat").names
    with pytest.raises(InputError, match="no variable q; found t, pos"):
        mapped(tmp_path / "a.mat", {"signals": {"rod_position": "q"}})
    with pytest.raises(InputError, match="different lengths"):
        mapped(tmp_path / "a.mat", {"signals": {"rod_position": "kp"}})


def test_rows_as_matlab_writes_a_matrix_are_read(tmp_path: Path) -> None:
    """Commas, a semicolon at the end of each row, names and units in comments: no row and no
    column is lost, and of the units the known ones count."""
    rows = "".join(f"{i}.0,0.5,{0.25 * i},1.5;\n" for i in range(40))
    text = "%Motor\n%step,voltage,position,velocity\n%[#],[V],[turns],[turns/s]\n" + rows
    (tmp_path / "a.csv").write_text(text)
    table = CsvTable(tmp_path / "a.csv")
    assert table.names == ["step", "voltage", "position", "velocity"]
    assert table.units == {"voltage": "V", "position": "turns", "velocity": "turns/s"}
    (columns,) = table.columns()
    np.testing.assert_array_equal(columns.values["velocity"], np.full(40, 1.5))
    np.testing.assert_array_equal(columns.values["step"], np.arange(40.0))


def test_a_line_of_units_with_a_percentage_has_its_names_above(tmp_path: Path) -> None:
    """A drive's export: metadata, names, units; the column without a name is time by its unit, and
    per cent are left to the map."""
    rows = "".join(f"{12.8 * i:.3f};{-100 - i % 3};{-24.1 - i % 5}\n" for i in range(200))
    head = "Date:;2020-07-08\nSampling period:;12.800\n;Velocity actual value;Torque actual value\n"
    (tmp_path / "a.csv").write_text(head + "ms;rpm;%\n" + rows)
    found = propose(survey(tmp_path / "a.csv"))
    assert found.map is not None and found.map.time is not None
    assert (found.map.time.field, found.map.time.unit) == ("column_1", "ms")
    (only,) = found.map.signals
    assert (only.name, only.field, only.unit) == ("rotor_velocity", "Velocity actual value", "rpm")
    assert any("unit % is of a rated value" in one for one in found.remarks)


def test_a_mat_vector_of_another_length_is_told(tmp_path: Path) -> None:
    """Instants that no signal is as long as are left out, and the note says so with both lengths;
    of a few parameters nothing is said."""
    samples = {"x": np.arange(60.0), "u": np.arange(60.0), "k": np.arange(3.0)}
    savemat(tmp_path / "a.mat", samples | {"t": np.arange(55.0)})
    table = MatTable(tmp_path / "a.mat")
    assert sorted(table.names) == ["u", "x"]
    (note,) = table.notes
    assert "60 rows" in note and note.endswith(": t (55)")


def test_objects_of_matlab_classes_are_no_signals(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A timeseries, as scipy hands it over (name, system, class, references), is told by its name
    with what to save instead, beside arrays that are read."""
    kinds = [("s0", "O"), ("s1", "O"), ("s2", "O"), ("arr", "O")]
    references = np.array([[3707764736], [2], [1], [1], [6], [5]], dtype=np.uint32)
    series = np.empty(1, dtype=kinds)
    series[0] = (b"sig_volt", b"MCOS", b"timeseries", references)
    given = {"None": MatlabOpaque(series), "x": np.arange(60.0)}
    monkeypatch.setattr("scipy.io.loadmat", lambda *_, **__: given)
    savemat(tmp_path / "a.mat", {"x": np.arange(60.0)})
    table = MatTable(tmp_path / "a.mat")
    assert table.names == ["x"]
    (note,) = table.notes
    assert "sig_volt is an object of MATLAB's class timeseries" in note and "Data" in note
    del given["x"]
    with pytest.raises(InputError, match=r"holds no vector of numbers .sig_volt is an object"):
        MatTable(tmp_path / "a.mat")


def test_mat_files_are_refused_where_scipy_would_end_the_process(tmp_path: Path) -> None:
    """A type of data that does not exist, which scipy looks up unchecked, is named by its byte."""
    savemat(tmp_path / "a.mat", {"t": np.arange(50.0)})
    data = bytearray((tmp_path / "a.mat").read_bytes())
    at = data.index((9).to_bytes(4, "little") + (400).to_bytes(4, "little"))
    data[at : at + 4] = (60).to_bytes(4, "little")
    (tmp_path / "a.mat").write_bytes(data)
    with pytest.raises(InputError, match=f"the numbers at byte {at}: 400 bytes of type 60"):
        MatTable(tmp_path / "a.mat")


def test_the_check_of_mat_files_refuses_none_that_scipy_reads() -> None:
    """Of scipy's own hundred test files, those that scipy reads pass, and damaged ones do not."""
    import scipy.io.matlab

    folder = Path(scipy.io.matlab.__file__).parent / "tests" / "data"
    files = sorted(folder.glob("*.mat"))
    if not files:
        pytest.skip("scipy comes without its test files here")
    for path in files:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                loadmat(path)
                good = True
            except Exception:
                good = False
        try:
            check_mat(path)
            passed = True
        except MatError:
            passed = False
        assert passed or not good, path.name


@field
def test_emps_has_the_tracking_error_that_others_found() -> None:
    """The stage's position error is 578 um RMS (the benchmark's), from its MAT file by a map."""
    tree = {
        "time": "t",
        "signals": {
            "reference_position": "qg",
            "rod_position": "qm",
            "effort": {"field": "vir", "unit": "N", "scale": 35.1507},
        },
    }
    recording = read_mapped(SHARED / "emps" / "DATA_EMPS.mat", parse_map(tree, "m"))
    error = recording.reference_position_m - recording.rod_position_m
    assert len(recording) == 24841
    assert np.sqrt(np.mean(error**2)) == pytest.approx(578e-6, abs=1e-6)
    raw = loadmat(SHARED / "emps" / "DATA_EMPS.mat")["vir"][:, 0]
    np.testing.assert_allclose(recording.rod_force_n, 35.1507 * raw, rtol=1e-12)


@field
def test_laas_shows_less_swing_in_one_state_of_its_flag() -> None:
    """Velocity deviates by 3.46 rad/s in one state and 0.64 in the other, as its authors found."""
    tree = {
        "rate": 1000,
        "signals": {
            "rotor_velocity": "Velocity",
            "mode": "Function Activated",
            "current_q": "Iq",
        },
    }
    path = SHARED / "laas_pmsm_cogging" / "speed_test.txt"
    recording = read_mapped(path, parse_map(tree, "m")).slice(0.5)  # it starts from rest
    spread = sorted(
        float(np.std(recording.rotor_velocity_rad_per_s[recording.mode == state]))
        for state in (0.0, 1.0)
    )
    assert spread == pytest.approx([0.64, 3.46], abs=0.01)


@field
def test_sage_folders_are_read_by_joint() -> None:
    """State and command of one of six servos, 50 Hz, on one grid, with the encoder's steps."""
    tree = {
        "time": {"field": "timestamp", "unit": "us"},
        "signals": {
            "reference_position": {"topic": "control", "field": "positions[4]", "unit": "rad"},
            "rotor_position": {"topic": "state_motor", "field": "positions[4]"},
        },
    }
    recording = read_mapped(SHARED / "sage_so101" / "triangle_wave", parse_map(tree, "m"))
    assert recording.rate_hz == pytest.approx(50.0, rel=0.01)
    steps = np.diff(recording.rotor_position_rad)
    counts = steps[steps != 0.0] / (2.0 * np.pi / 4096)
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    assert np.isfinite(recording.reference_position_rad).all()
