import numpy as np
import pytest
from recording_samples import assert_same, made

from ecyl_ros.errors import InputError
from ecyl_ros.recording import Recording
from ecyl_ros.recording.csvfile import read_csv, write_csv


def test_values_survive_to_the_last_bit(tmp_path):
    """CSV out and in gives the same doubles, and NaN where a cell was empty."""
    recording = made(200, without=("voltage_d_v",))
    holes = np.array(recording.rod_position_m)
    holes[3:9] = np.nan
    holes[10] = 5e-324
    recording = Recording(
        stamp_ns=recording.stamp_ns, rod_position_m=holes, current_q_a=recording.current_q_a
    )
    write_csv(recording, tmp_path / "a.csv")
    assert_same(read_csv(tmp_path / "a.csv"), recording)


def test_other_column_names_are_mapped(tmp_path):
    """A column under another name is found by the mapping; unknown columns are ignored."""
    (tmp_path / "a.csv").write_text("t,pos,colour\n0,1.5,red\n1000,2.5,blue\n")
    recording = read_csv(tmp_path / "a.csv", columns={"stamp_ns": "t", "rod_position_m": "pos"})
    assert recording.rod_position_m.tolist() == [1.5, 2.5]
    assert recording.stamp_ns.tolist() == [0, 1000]


@pytest.mark.parametrize(
    "text, named",
    [
        ("", "empty"),
        ("a,b\n1,2\n", "stamp_ns"),
        ("stamp_ns,b\n1,2\n", "no column with a signal"),
        ("stamp_ns,rod_position_m\n1,2\n2\n", "line 3: 1 cells"),
        ("stamp_ns,rod_position_m\n1,2\n2,x\n", "line 3: rod_position_m is 'x'"),
        ("stamp_ns,rod_position_m\n1.5,2\n", "line 2: stamp_ns is '1.5'"),
        ("stamp_ns,rod_position_m\n1,2\n1,3\n", "line 3: stamp_ns does not increase"),
        ("stamp_ns,rod_position_m\n99999999999999999999,2\n", "line 2: stamp_ns"),
    ],
)
def test_unusable_tables_are_one_clear_line(tmp_path, text, named):
    """Each kind of broken table is an InputError naming file, line and column."""
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(InputError) as caught:
        read_csv(tmp_path / "a.csv")
    assert named in str(caught.value) and "a.csv" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_binary_and_missing_files_are_input_errors(tmp_path):
    """A picture and a missing file are refused by name."""
    (tmp_path / "a.csv").write_bytes(b"\x89PNG\xff\xfe\x00")
    for name in ("a.csv", "b.csv"):
        with pytest.raises(InputError, match=name):
            read_csv(tmp_path / name)
