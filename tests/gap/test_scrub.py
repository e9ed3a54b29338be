"""A diagnosis written as MCAP, and the layouts that show it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from report_samples import of_each_verdict

from ecyl_ros.errors import InputError
from ecyl_ros.gap.replay.replay import SIGNALS
from ecyl_ros.gap.report.layouts import layouts
from ecyl_ros.gap.report.scrub import ROOT, WINDOW_S, topic, write_scrub
from ecyl_ros.nodes import wire
from ecyl_ros.recording import TOPICS
from ecyl_ros.recording.topics import TopicSpec, renamed

SAMPLES = of_each_verdict()
LAYOUTS = Path(__file__).parents[2] / "ecyl_ros" / "layouts"


def decoded(path: Path) -> dict[str, list]:
    """Topic -> (log time in ns, message), by the mcap package's own reader."""
    out: dict[str, list] = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for one in reader.iter_decoded_messages():
            out.setdefault(one.channel.topic, []).append(
                (one.message.log_time, one.decoded_message)
            )
    return out


def test_curves_and_residuals_are_those_of_the_diagnosis(tmp_path: Path) -> None:
    """Recorded, before and after come back as they were, and residuals are their differences."""
    diagnosis = SAMPLES["explained"]
    write_scrub(diagnosis, tmp_path / "a.mcap")
    found = decoded(tmp_path / "a.mcap")
    series = diagnosis.series
    for row, signal in enumerate(diagnosis.signals):
        curves = {
            name: np.array([m.data for _, m in found[topic(signal.name, name)]])
            for name in ("recorded", "before", "after", "residual_before", "residual_after")
        }
        known = np.isfinite(series.recorded[row])
        np.testing.assert_array_equal(curves["recorded"], series.recorded[row][known])
        np.testing.assert_array_equal(curves["before"], series.before[row])
        expected = (series.recorded[row] - series.after[row])[known]
        np.testing.assert_array_equal(curves["residual_after"], expected)
    stamps = [stamp for stamp, _ in found[f"{ROOT}/reference"]]
    np.testing.assert_allclose(np.array(stamps) / 1e9, series.time_s, atol=1e-9)


def test_the_misfit_is_the_rms_over_the_floors(tmp_path: Path) -> None:
    """A curve of the misfit equals the RMS of all judged residuals over their floors in 0.1 s."""
    diagnosis = SAMPLES["explained"]
    write_scrub(diagnosis, tmp_path / "a.mcap")
    found = decoded(tmp_path / "a.mcap")[f"{ROOT}/misfit/before"]
    series = diagnosis.series
    stamp, message = found[len(found) // 2]
    at = int(np.argmin(np.abs(series.time_s - stamp / 1e9)))
    rows = (series.time_s <= series.time_s[at]) & (series.time_s > series.time_s[at] - WINDOW_S)
    rows |= np.isclose(series.time_s, series.time_s[at] - WINDOW_S, atol=1e-12)
    rows &= series.usable
    floors = np.array([one.floor for one in diagnosis.signals])[:, None]
    ratios = ((series.recorded - series.before) / floors)[:, rows]
    expected = np.sqrt(np.nanmean(ratios**2))
    assert message.data == pytest.approx(expected, rel=0.02)


def test_events_and_summary_say_what_the_diagnosis_says(tmp_path: Path) -> None:
    """The summary names each cause with its confidence; the log begins with the verdict."""
    diagnosis = SAMPLES["explained"]
    write_scrub(diagnosis, tmp_path / "a.mcap")
    found = decoded(tmp_path / "a.mcap")
    (_, summary), *rest = found[f"{ROOT}/summary"]
    assert not rest
    assert [one.name for one in summary.status[1:]] == [one.effect for one in diagnosis.causes]
    assert summary.status[0].values[0].value == "explained"
    events = [message for _, message in found[f"{ROOT}/events"]]
    assert any(cause.title.split()[0] in events[0].msg for cause in diagnosis.causes)
    stamps = [message.stamp.sec * 10**9 + message.stamp.nanosec for message in events]
    assert stamps == sorted(stamps)
    assert all(re.search(r"gap of [\d.]+ noise floors", e.msg) for e in events if e.level == 30)


def test_an_unexplained_gap_has_no_causes(tmp_path: Path) -> None:
    """The summary of a diagnosis without causes holds the verdict alone, as a warning."""
    write_scrub(SAMPLES["unexplained"], tmp_path / "a.mcap")
    (_, summary), *_ = decoded(tmp_path / "a.mcap")[f"{ROOT}/summary"]
    assert len(summary.status) == 1
    assert bytes([summary.status[0].level]) == b"\x01"


def test_nothing_half_written(tmp_path: Path) -> None:
    """A folder in the way is refused and nothing is left beside it."""
    (tmp_path / "a.mcap").mkdir()
    with pytest.raises(InputError, match="cannot be written"):
        write_scrub(SAMPLES["explained"], tmp_path / "a.mcap")
    assert [one.name for one in tmp_path.iterdir()] == ["a.mcap"]


def test_the_layouts_are_those_that_the_code_writes() -> None:
    """The files of ecyl_ros/layouts hold what `python -m ecyl_ros.gap.report.layouts` writes."""
    for name, text in layouts().items():
        assert (LAYOUTS / name).read_text(encoding="utf-8") == text


def test_every_curve_of_the_layouts_exists(tmp_path: Path) -> None:
    """Each path of both tools' layouts is a field of a topic that is recorded or written."""
    write_scrub(SAMPLES["explained"], tmp_path / "a.mcap")
    written = set(decoded(tmp_path / "a.mcap"))
    held = {f"{ROOT}/{one}/" for one in ("rotor_position", "voltage_q")}  # not in the sample
    drive = {topic.name: topic for topic in TOPICS}
    for name in ("foxglove_diagnosis.json", "plotjuggler_diagnosis.xml"):
        text = (LAYOUTS / name).read_text(encoding="utf-8")
        found = re.findall(rf"{ROOT}/[a-z_/]+", text)
        assert len(found) > 20
        for one in found:
            own = one.removesuffix("/data")
            assert own in written or any(own.startswith(start) for start in held), one
    tree = json.loads((LAYOUTS / "foxglove_drive.json").read_text(encoding="utf-8"))
    paths = [p["value"] for panel in tree["configById"].values() for p in panel.get("paths", ())]
    drive |= {one.name: one for one in residuals()}
    levels = {f"/{wire.GAP_OVER_NOISE}/{one.name}" for one in SIGNALS}
    assert len(paths) == 9 + 4 + len(levels)
    assert {path.removesuffix(".data") for path in paths if path.endswith(".data")} == levels
    for path in paths:
        if path.endswith(".data"):
            continue
        own, field = path.split(".", 1)
        index = re.search(r"\[(\d)\]", field)
        spec = drive[own]
        fields = {
            f"{key.rpartition('.')[2]}[{spec.joints.index(key.rpartition('.')[0])}]"
            if index
            else key
            for key in spec.signals
            if not index or key.rpartition(".")[0] in spec.joints
        }
        assert field in fields, path
    root = Xml.parse(LAYOUTS / "plotjuggler_gap_monitor.xml").getroot()
    names = [curve.attrib["name"] for curve in root.iter("curve")]
    assert {name.removesuffix("/data") for name in names if name.endswith("/data")} == levels
    for name in names:
        if name.endswith("/data"):
            continue
        own = next(key for key in drive if name.startswith(f"{key}/"))
        assert name.removeprefix(f"{own}/").replace("/", ".") in drive[own].signals


def test_without_a_gap_monitor_plotjuggler_asks_for_nothing_of_it() -> None:
    """Its layout of a drive's topics has no curve that a drive alone lacks: it would warn."""
    root = Xml.parse(LAYOUTS / "plotjuggler_drive.xml").getroot()
    names = [curve.attrib["name"] for curve in root.iter("curve")]
    assert len(names) == 9
    assert not any(name.startswith(f"/{wire.GAP_OVER_NOISE.split('/over')[0]}") for name in names)


def residuals() -> list[TopicSpec]:
    """The gap monitor's topics of residuals: as the drive's own, by other names."""
    names = {
        "joint_states": wire.GAP_JOINT_STATES,
        "current": wire.GAP_CURRENT,
        "voltage": wire.GAP_VOLTAGE,
    }
    made = renamed({key: f"/{name}" for key, name in names.items()})
    return [one for one in made if one.key != "reference"]


def test_every_panel_of_a_foxglove_layout_has_its_place() -> None:
    """All panels are named in a tab's layout once, and nothing else is."""
    for name in ("foxglove_drive.json", "foxglove_diagnosis.json"):
        tree = json.loads((LAYOUTS / name).read_text(encoding="utf-8"))
        panels = set(tree["configById"]) - {tree["layout"]}
        placed = re.findall(
            r'"([A-Za-z]+![a-z0-9]+)"', json.dumps(tree["configById"][tree["layout"]])
        )
        assert sorted(placed) == sorted(panels)


def test_plotjuggler_layouts_are_as_its_loader_takes_them() -> None:
    """Splitters hold as many parts as they say, with a share each; every dock has one plot.

    The loader indexes shares and children by the count, and passes over what it does not know.
    """
    for name in (one for one in layouts() if one.startswith("plotjuggler")):
        root = Xml.parse(LAYOUTS / name).getroot()
        assert root.tag == "root"
        (tabs,) = root.findall("tabbed_widget")
        assert tabs.attrib == {"name": "Main Window", "parent": "main_window"}
        titles = [tab.attrib["tab_name"] for tab in tabs.findall("Tab")]
        assert len(set(titles)) == len(titles) > 1
        for tab in tabs.findall("Tab"):
            (splitter,) = tab.findall("Container/DockSplitter")
            assert tab.attrib["containers"] == "1" and splitter.attrib["orientation"] in "|-"
            shares = [float(one) for one in splitter.attrib["sizes"].split(";")]
            assert int(splitter.attrib["count"]) == len(shares) == len(splitter)
            assert sum(shares) == pytest.approx(1.0, abs=1e-4)
            for area in splitter:
                assert area.tag == "DockArea"
                (plot,) = area.findall("plot")
                assert plot.attrib["mode"] == "TimeSeries" and plot.attrib["style"] == "Lines"
                colors = [curve.attrib["color"] for curve in plot.findall("curve")]
                assert colors and all(re.fullmatch("#[0-9a-f]{6}", one) for one in colors)
                assert len(set(colors)) == len(colors)
        assert 0 <= int(tabs.find("currentTabIndex").attrib["index"]) < len(titles)
