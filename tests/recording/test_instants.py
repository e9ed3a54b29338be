"""Instants of tables: dates, seconds since 1970 by their size, and tables of every spelling."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pytest

from ecyl_ros.errors import InputError
from ecyl_ros.recording.map import map_yaml
from ecyl_ros.recording.map_file import parse_map
from ecyl_ros.recording.mapped import read_mapped
from ecyl_ros.recording.propose import propose
from ecyl_ros.recording.signals import Recording
from ecyl_ros.recording.survey import survey

POSITION = {"signals": {"rod_position": {"field": "pos", "unit": "mm"}}}
BEGIN = datetime(2024, 5, 1, 12, 0, 0, tzinfo=UTC)


def read(path: Path, **more: object) -> Recording:
    return read_mapped(path, parse_map({**POSITION, **more}, "m"))


def dates(form: str, count: int = 60, step_us: int = 2_000) -> list[str]:
    """Dates of one form, by the standard library."""
    out = []
    for i in range(count):
        at = BEGIN + timedelta(microseconds=i * step_us)
        text = at.isoformat(sep=" " if " " in form else "T", timespec="microseconds")
        if form.endswith("offset"):
            moved = at.astimezone(timezone(timedelta(hours=2)))
            text = moved.isoformat(sep="T", timespec="microseconds")
        bare = text.removesuffix("+00:00")
        out.append({"Z": bare + "Z", "none": bare, "comma": bare.replace(".", ",")}.get(form, text))
    return out


@pytest.mark.parametrize("form", ["Z", "none", "offset", "with blank", "comma"])
def test_dates_are_read_to_the_nanosecond(tmp_path: Path, form: str) -> None:
    """ISO 8601 with T or blank, fraction, Z, offset or none gives the instants since 1970."""
    rows = "\n".join(f"{date};{i}" for i, date in enumerate(dates(form)))
    (tmp_path / "a.csv").write_text(f"timestamp;pos\n{rows}\n")
    found = read(tmp_path / "a.csv", time="timestamp")
    first = int(BEGIN.timestamp()) * 10**9
    np.testing.assert_array_equal(found.stamp_ns, first + np.arange(60) * 2_000_000)
    proposal = propose(survey(tmp_path / "a.csv"))
    assert any("timestamp holds dates" in one for one in proposal.remarks)
    assert "unit: iso8601" in map_yaml(proposal.map)  # type: ignore[arg-type]


def test_rows_without_a_date_are_left_out(tmp_path: Path) -> None:
    """A missing date costs its row and is told; a date of no such kind is refused with its line."""
    rows = [f"{date},{i}" for i, date in enumerate(dates("Z", 6))]
    rows[3] = ",3"
    (tmp_path / "a.csv").write_text("time,pos\n" + "\n".join(rows) + "\n")
    found = read(tmp_path / "a.csv")
    np.testing.assert_allclose(found.rod_position_m, [0.0, 1e-3, 2e-3, 4e-3, 5e-3])
    assert any("1 rows without time left out" in note for note in found.notes)
    rows[3] = "2024-05-41T12:00:00Z,3"
    (tmp_path / "a.csv").write_text("time,pos\n" + "\n".join(rows) + "\n")
    with pytest.raises(InputError, match="line 2: time is '2024-05-01"):
        read(tmp_path / "a.csv")


def test_dates_and_a_unit_of_time_contradict_each_other(tmp_path: Path) -> None:
    """A map that calls dates ms, or numbers dates, is refused."""
    rows = "\n".join(f"{date},{i}" for i, date in enumerate(dates("Z", 6)))
    (tmp_path / "a.csv").write_text(f"time,pos\n{rows}\n")
    with pytest.raises(InputError, match=r"time\.unit is ms, but column time holds dates"):
        read(tmp_path / "a.csv", time={"field": "time", "unit": "ms"})
    with pytest.raises(InputError, match="column pos holds numbers, no dates"):
        read(tmp_path / "a.csv", time={"field": "pos", "unit": "iso8601"})


@pytest.mark.parametrize(("unit", "per_s"), [("s", 1), ("ms", 10**3), ("us", 10**6), ("ns", 10**9)])
def test_seconds_since_1970_are_told_by_their_size(tmp_path: Path, unit: str, per_s: int) -> None:
    """Of a column that is merely called time, 19 digits are ns and 13 ms; the guess is stated."""
    first = 1_714_564_800
    times = [first * per_s + i * per_s // 100 if per_s > 1 else first + i / 100 for i in range(50)]
    rows = "\n".join(f"{t!r},{i}" for i, t in enumerate(times))
    (tmp_path / "a.csv").write_text(f"time,pos\n{rows}\n")
    found = read(tmp_path / "a.csv")
    expected = first * 10**9 + np.arange(50) * 10**7
    np.testing.assert_allclose(found.stamp_ns - expected, 0, atol=0 if per_s > 1 else 300)
    assert any(f"time is taken for {unit} since 1970" in note for note in found.notes)
    proposal = propose(survey(tmp_path / "a.csv"))
    assert any(f"time: {unit} since 1970 is guessed" in one for one in proposal.remarks)


@pytest.mark.parametrize(
    "text",
    [
        "time,pos,\n0,1,\n0.001,2.5,\n0.002,-3,\n",
        "time,pos\n0,1,\n0.001,2.5,\n0.002,-3,\n",
        "time;pos;\n0;1;\n0,001;2,5;\n0,002;-3;\n",
        "time;pos\n0;0,0\n0;0\n0,001;2,5\n".replace("0;0,0\n0;0", "0;1"),
        "0;1\n0,001;2,5\n0,002;-3\n",
        "0,000;1,0\n0,001;2,5\n0,002;-3,0\n",
        "# rig 7, serial 0815\n# time, pos\n# s, mm\n0,1\n0.001,2.5\n0.002,-3\n# end\n",
        "// made today\n// time;pos\n0;1\n0,001;2,5\n0,002;-3",
        "% time pos\n0 1\n% a remark\n0.001 2.5\n0.002 -3\n0.00",
        "time,pos\n0,1\n0.001,2.5\n# paused\n0.002,-3\n",
    ],
)
def test_tables_as_machines_write_them(tmp_path: Path, text: str) -> None:
    """Delimiters at line ends, comments anywhere, decimal commas from the first line: one table."""
    (tmp_path / "a.csv").write_text(text)
    tree: dict = {"time": "time", **POSITION}
    if text[0].isdigit():
        tree = {
            "time": "column_1",
            "signals": {"rod_position": {"field": "column_2", "unit": "mm"}},
        }
    found = read_mapped(tmp_path / "a.csv", parse_map(tree, "m"))
    np.testing.assert_allclose(found.rod_position_m[:2], [1e-3, 2.5e-3], rtol=1e-15)
    np.testing.assert_allclose(found.time_s[:2], [0.0, 1e-3], atol=1e-12)
    if "-3" in text:
        np.testing.assert_allclose(found.rod_position_m[2:], [-3e-3], rtol=1e-15)


def test_a_number_that_breaks_off_costs_its_row(tmp_path: Path) -> None:
    """A file cut within its last number loses that row; one without a last line end does not."""
    rows = "\n".join(f"{i * 1e-3:.3f},{np.sin(i):.6f}" for i in range(40))
    (tmp_path / "a.csv").write_text(f"time,pos\n{rows}")
    assert len(read(tmp_path / "a.csv")) == 40
    (tmp_path / "a.csv").write_text(f"time,pos\n{rows[:-4]}")
    found = read(tmp_path / "a.csv")
    assert len(found) == 39
    assert any("breaks off within a number" in note for note in found.notes)


def test_rows_whose_time_was_never_set_are_left_out(tmp_path: Path) -> None:
    """Rows of zeros, their time too, at the end of a buffer are no samples at time 0."""
    random = np.random.default_rng(1)
    rows = [f"{5 + i * 1e-3:.3f},{random.normal():.4f},{random.normal():.4f}" for i in range(200)]
    rows += ["0.000,0.0000,0.0000"] * 30
    (tmp_path / "a.csv").write_text("time,pos,i\n" + "\n".join(rows) + "\n")
    found = read(tmp_path / "a.csv")
    assert len(found) == 200
    assert found.duration_s == pytest.approx(0.199)
    assert any("30 rows without time left out" in note for note in found.notes)
