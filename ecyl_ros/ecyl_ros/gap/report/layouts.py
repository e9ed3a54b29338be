"""Layouts of Foxglove and PlotJuggler for the topics of a drive and of the gap monitor beside it,
and for a diagnosis written as MCAP.

`python -m ecyl_ros.gap.report.layouts FOLDER` writes the files of `ecyl_ros/layouts`. Foxglove: a
JSON of panels by id (`Kind!id`), and how they are split. PlotJuggler: an XML of tabs, docks and
curves by name, in which a JointState's fields go by joint (`/topic/joint/position`) and those of
other messages by path (`/topic/vector/x`).
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

from ...recording.topics import CURRENT, JOINT_STATES, REFERENCE, VOLTAGE
from ..replay.replay import SIGNALS
from . import words
from .scrub import CURVES, EVENTS, MISFIT, SUMMARY, topic
from .scrub import REFERENCE as SCRUB_REFERENCE

# What the gap monitor publishes beside the drive's topics (`nodes/wire.py` has the names, too).
GAP = "/ecyl/gap"
OVER_NOISE = f"{GAP}/over_noise"
DIAGNOSTICS = "/diagnostics"
# Told apart by those who see red and green alike.
BLUE, ORANGE, GREEN, GREY = "#0072b2", "#e69f00", "#009e73", "#7f7f7f"
VERMILION, SKY = "#d55e00", "#56b4e9"


@dataclass(frozen=True)
class Curve:
    """One curve: its names in both tools, and how the legend calls it."""

    foxglove: str
    plotjuggler: str
    label: str
    color: str
    stamped: bool = True


@dataclass(frozen=True)
class Plot:
    """Some curves over one axis."""

    title: str
    curves: tuple[Curve, ...]


@dataclass(frozen=True)
class Page:
    """Plots below each other; extra: panels that Foxglove alone has, with their settings."""

    title: str
    plots: tuple[Plot, ...]
    extra: tuple[tuple[str, dict[str, Any]], ...] = ()


def _joint(
    name: str, joints: Sequence[str], joint: str, field: str, label: str, color: str
) -> Curve:
    return Curve(f"{name}.{field}[{joints.index(joint)}]", f"{name}/{joint}/{field}", label, color)


def _vector(name: str, part: str, label: str, color: str) -> Curve:
    return Curve(f"{name}.vector.{part}", f"{name}/vector/{part}", label, color)


def _float(name: str, label: str, color: str) -> Curve:
    return Curve(f"{name}.data", f"{name}/data", label, color, stamped=False)


def _summary(name: str) -> tuple[str, dict[str, Any]]:
    """Foxglove's panel of the diagnostics on a topic."""
    settings = {"topicToRender": name, "minLevel": 0, "pinnedIds": [], "hardwareIdFilter": ""}
    return "DiagnosticSummary", {**settings, "sortByLevel": False}


def drive_pages() -> tuple[Page, ...]:
    """Of the topics that a running drive publishes and a recording holds."""
    asked, joints = REFERENCE.joints, JOINT_STATES.joints
    reference, states = REFERENCE.name, JOINT_STATES.name
    return (
        Page(
            "motion",
            (
                Plot(
                    "rod position, m",
                    (
                        _joint(reference, asked, "rod", "position", "reference", ORANGE),
                        _joint(states, joints, "rod", "position", "measured", BLUE),
                    ),
                ),
                Plot(
                    "rotor position, rad",
                    (_joint(states, joints, "rotor", "position", "measured", BLUE),),
                ),
                Plot(
                    "rotor velocity, rad/s",
                    (_joint(states, joints, "rotor", "velocity", "measured", BLUE),),
                ),
            ),
        ),
        Page(
            "motor",
            (
                Plot(
                    "rotor torque, N m",
                    (_joint(states, joints, "rotor", "effort", "torque constant x i_q", BLUE),),
                ),
                Plot(
                    "current, A",
                    (
                        _vector(CURRENT.name, "y", "i_q", BLUE),
                        _vector(CURRENT.name, "x", "i_d", ORANGE),
                    ),
                ),
                Plot(
                    "voltage, V",
                    (
                        _vector(VOLTAGE.name, "y", "u_q", BLUE),
                        _vector(VOLTAGE.name, "x", "u_d", ORANGE),
                    ),
                ),
            ),
        ),
    )


def gap_page() -> Page:
    """Of the topics of the gap monitor: how far machine and model are apart now."""
    states, joints = f"{GAP}/joint_states", JOINT_STATES.joints
    colors = (BLUE, ORANGE, GREEN, VERMILION, SKY)
    levels = tuple(
        _float(f"{OVER_NOISE}/{one.name}", words.signal(one.name), color)
        for one, color in zip(SIGNALS, colors, strict=True)
    )
    return Page(
        "gap",
        (
            Plot("running rms of the gap over noise; 2 is a gap", levels),
            Plot(
                "rotor position, residual, rad",
                (_joint(states, joints, "rotor", "position", "rotor", BLUE),),
            ),
            Plot(
                "rod position, residual, m",
                (_joint(states, joints, "rod", "position", "rod", BLUE),),
            ),
            Plot(
                "current, residual, A",
                (_vector(f"{GAP}/current", "y", "i_q", BLUE),),
            ),
            Plot(
                "voltage, residual, V",
                (_vector(f"{GAP}/voltage", "y", "u_q", BLUE),),
            ),
        ),
        (_summary(DIAGNOSTICS),),
    )


def diagnosis_pages() -> tuple[Page, ...]:
    """Of what `ecyl diagnose --write-mcap` writes."""
    colors = dict(zip(CURVES, (GREY, ORANGE, GREEN, ORANGE, GREEN), strict=True))
    labels = {
        "recorded": "recorded",
        "before": "nominal model",
        "after": "with the causes",
        "residual_before": "nominal model",
        "residual_after": "with the causes",
    }

    def curves(signal: str, names: Sequence[str]) -> tuple[Curve, ...]:
        return tuple(_float(topic(signal, name), labels[name], colors[name]) for name in names)

    overview = Page(
        "overview",
        (
            Plot(
                "gap over the noise floor, rms of 0.1 s",
                (
                    _float(f"{MISFIT}/before", "nominal model", ORANGE),
                    _float(f"{MISFIT}/after", "with the causes", GREEN),
                ),
            ),
            Plot("reference, m", (_float(SCRUB_REFERENCE, "reference", GREY),)),
        ),
        (
            _summary(SUMMARY),
            ("RosOut", {"topicToRender": EVENTS, "minLogLevel": 1, "searchTerms": []}),
        ),
    )
    pages = [
        Page(
            words.signal(one.name),
            (
                Plot(f"{words.signal(one.name)}, {one.unit}", curves(one.name, CURVES[:3])),
                Plot(f"residual, {one.unit}", curves(one.name, CURVES[3:])),
            ),
        )
        for one in SIGNALS
    ]
    return (overview, *pages)


def foxglove(pages: Sequence[Page]) -> str:
    """The layout as Foxglove imports it: one tab per page."""
    panels: dict[str, Any] = {}
    tabs = []
    for number, page in enumerate(pages):
        names = []
        for place, plot in enumerate(page.plots):
            name = f"Plot!ecyl{number}{place}"
            panels[name] = _foxglove_plot(plot)
            names.append(name)
        for place, (kind, settings) in enumerate(page.extra):
            name = f"{kind}!ecyl{number}{place}"
            panels[name] = settings
            names.append(name)
        tabs.append({"title": page.title, "layout": _stacked(names)})
    panels["Tab!ecyl"] = {"activeTabIdx": 0, "tabs": tabs}
    tree = {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": "Tab!ecyl",
    }
    return json.dumps(tree, indent=2) + "\n"


def _foxglove_plot(plot: Plot) -> dict[str, Any]:
    return {
        "foxglovePanelTitle": plot.title,
        "lichtblickPanelTitle": plot.title,
        "paths": [
            {
                "value": curve.foxglove,
                "label": curve.label,
                "color": curve.color,
                "enabled": True,
                "timestampMethod": "headerStamp" if curve.stamped else "receiveTime",
            }
            for curve in plot.curves
        ],
        "xAxisVal": "timestamp",
        "isSynced": True,
        "showLegend": True,
        "legendDisplay": "left",
        "showPlotValuesInLegend": True,
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "sidebarDimension": 240,
    }


def _stacked(names: Sequence[str]) -> Any:
    """Panels of equal height below each other."""
    if len(names) == 1:
        return names[0]
    return {
        "first": names[0],
        "second": _stacked(names[1:]),
        "direction": "column",
        "splitPercentage": round(100.0 / len(names), 2),
    }


def plotjuggler(pages: Sequence[Page]) -> str:
    """The layout as PlotJuggler loads it: one tab per page."""
    root = Xml.Element("root")
    tabs = Xml.SubElement(root, "tabbed_widget", {"name": "Main Window", "parent": "main_window"})
    for page in pages:
        tab = Xml.SubElement(tabs, "Tab", {"tab_name": page.title, "containers": "1"})
        share = ";".join([f"{1.0 / len(page.plots):.6f}"] * len(page.plots))
        splitter = Xml.SubElement(
            Xml.SubElement(tab, "Container"),
            "DockSplitter",
            {"orientation": "-", "sizes": share, "count": str(len(page.plots))},
        )
        for plot in page.plots:
            area = Xml.SubElement(splitter, "DockArea", {"name": plot.title})
            style = {"mode": "TimeSeries", "style": "Lines", "flip_x": "false", "flip_y": "false"}
            drawn = Xml.SubElement(area, "plot", style)
            Xml.SubElement(drawn, "limitY")
            for curve in plot.curves:
                Xml.SubElement(drawn, "curve", {"name": curve.plotjuggler, "color": curve.color})
    Xml.SubElement(tabs, "currentTabIndex", {"index": "0"})
    Xml.SubElement(root, "use_relative_time_offset", {"enabled": "1"})
    Xml.indent(root, " ")
    return f"<?xml version='1.0' encoding='UTF-8'?>\n{Xml.tostring(root, encoding='unicode')}\n"


def layouts() -> dict[str, str]:
    """File name -> text of all layouts."""
    return {
        "foxglove_drive.json": foxglove((*drive_pages(), gap_page())),
        "foxglove_diagnosis.json": foxglove(diagnosis_pages()),
        # Apart: PlotJuggler warns of every curve that is not there, as without a gap monitor.
        "plotjuggler_drive.xml": plotjuggler(drive_pages()),
        "plotjuggler_gap_monitor.xml": plotjuggler((*drive_pages(), gap_page())),
        "plotjuggler_diagnosis.xml": plotjuggler(diagnosis_pages()),
    }


if __name__ == "__main__":
    for file_name, text in layouts().items():
        Path(sys.argv[1], file_name).write_text(text, encoding="utf-8")
