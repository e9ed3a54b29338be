"""`ecyl inspect FILE`: what a recording holds, and which field could be which signal."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .outputs import add_overwrite, check_outputs

if TYPE_CHECKING:
    from rich.console import Console

    from ..recording.survey import StampFigures, Survey, TopicSurvey

FIELDS_SHOWN = 24  # per topic; --all shows the rest
GAPS_SHOWN = 3


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's flags."""
    parser.add_argument(
        "recording",
        type=Path,
        metavar="FILE",
        help="MCAP, sqlite3, CSV or MAT file, rosbag2 folder, or folder of CSV files",
    )
    parser.add_argument("--write-map", type=Path, metavar="OUT.yaml", help="write the proposed map")
    parser.add_argument("--json", type=Path, metavar="OUT", help="write the figures as JSON")
    parser.add_argument("--all", action="store_true", help="show every field of every topic")
    add_overwrite(parser)


def run(options: argparse.Namespace) -> int:
    """Look through the recording once; write what was asked for, print the rest."""
    from ..recording.atomic import write_text
    from ..recording.map import map_yaml
    from ..recording.propose import propose
    from ..recording.survey import survey

    check_outputs(
        {"--write-map": options.write_map, "--json": options.json},
        {"FILE": options.recording},
        overwrite=options.overwrite,
    )
    found = survey(options.recording)
    proposal = propose(found)
    text = ""
    if proposal.map is not None:
        lines = (f"proposed from {options.recording}; check it", *proposal.remarks)
        text = map_yaml(proposal.map, "\n".join(lines))
    if options.json is not None:
        data = {**found.as_json(), "map": text or None, "remarks": list(proposal.remarks)}
        write_text(options.json, json.dumps(data, indent=2, allow_nan=False) + "\n")
    if options.write_map is not None and text:
        write_text(options.write_map, text)
    for note in found.notes:
        print(f"ecyl inspect: {note}", file=sys.stderr)
    _print(found, all_fields=options.all)
    if text:
        print(f"\nProposed map{'' if options.write_map is None else f', {options.write_map}'}\n")
        print(text, end="")
    else:
        for remark in proposal.remarks:
            print(f"\nNo map proposed: {remark}")
        if options.write_map is not None:
            print(f"ecyl inspect: {options.write_map} is not written", file=sys.stderr)
    return 0


def _print(found: Survey, *, all_fields: bool) -> None:
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True)
    if not console.is_terminal:
        console = Console(highlight=False, width=500, color_system=None)
    _print_topics(console, found)
    for topic in found.topics:
        if topic.fields or topic.unread:
            _print_fields(console, topic, all_fields=all_fields)


def _plain(console: Console, text: str = "") -> None:
    console.print(text, markup=False, soft_wrap=True)


def _table(*columns: str) -> Any:
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for number, name in enumerate(columns):
        table.add_column(_verbatim(name), justify="right" if number else "left", no_wrap=True)
    return table


def _verbatim(text: str) -> Any:
    """Text without rich's own markup, which `Iq [mA]` looks like."""
    from rich.text import Text

    return Text("".join(c if c.isprintable() else "?" for c in text))


def _print_topics(console: Console, found: Survey) -> None:
    table = _table(
        "topic",
        "type",
        "samples",
        "from s",
        "to s",
        "Hz",
        "jitter ms",
        "lost",
        "repeated",
        "backward",
    )
    table.columns[1].justify = "left"
    origin = min((t.stamps.first_ns for t in found.topics if t.stamps is not None), default=0)
    for topic in found.topics:
        one = topic.stamps
        name = topic.name or "(rows)"
        if one is None:
            count = max((field.count for field in topic.fields), default=0)
            table.add_row(_verbatim(name), topic.type, str(count), *["-"] * 7)
            continue
        table.add_row(
            _verbatim(name),
            _verbatim(topic.type),
            str(one.count),
            f"{(one.first_ns - origin) / 1e9:.3f}",
            f"{(one.last_ns - origin) / 1e9:.3f}",
            f"{one.rate_hz:.6g}" if math.isfinite(one.rate_hz) else "-",
            f"{one.jitter_s * 1e3:.3g}" if math.isfinite(one.jitter_s) else "-",
            str(one.lost),
            str(one.repeated),
            str(one.backward),
        )
    console.print(table)
    for topic in found.topics:
        for line in _remarks(topic):
            _plain(console, f"{topic.name or '(rows)'}: {line}")


def _remarks(topic: TopicSurvey) -> list[str]:
    lines = []
    stamps = topic.stamps
    if topic.header is not None and topic.header.last_ns <= 0:
        lines.append("all header stamps are 0; the recorder's times are used")
    if stamps is not None and stamps.jumps:
        lines.append(f"its clock goes back by more than a second {stamps.jumps} times")
    if stamps is not None and stamps.gaps and _worth_telling(stamps):
        longest = ", ".join(f"{s:.4g} s at {at:.3f} s" for at, s in stamps.gaps[:GAPS_SHOWN])
        lines.append(f"longest gaps {longest}")
    clock = topic.clock
    if clock is not None and topic.header is not None and topic.header.last_ns > 0:
        told = f"recorded {_duration(clock.offset_s)} after its stamps"
        if abs(clock.drift) > 4.0 * clock.drift_error and abs(clock.drift) > 1e-7:
            told += f", {clock.drift * 1e6:+.2f} ppm"
        if clock.delay_s > 0.0:
            told += f", {_duration(clock.delay_s)} more in the median"
        if clock.offset_s or clock.delay_s:
            lines.append(told)
    return lines


def _worth_telling(stamps: StampFigures) -> bool:
    return stamps.gaps[0][1] > 3.0 * stamps.step_s


def _duration(seconds: float) -> str:
    if abs(seconds) < 1.0:
        return f"{seconds * 1e3:.4g} ms"
    return f"{seconds:.6f} s"


def _print_fields(console: Console, topic: TopicSurvey, *, all_fields: bool) -> None:
    _plain(console)
    if topic.unread:
        _plain(console, f"{topic.name}: not read: {topic.unread}")
        return
    names = " ".join(f"{path} = {', '.join(own[:12])}" for path, own in topic.names.items())
    shown = topic.fields if all_fields else topic.fields[:FIELDS_SHOWN]
    table = _table(f"{topic.name or 'column'}", "unit", "samples", "min", "max", "mean", "std")
    table.columns[1].justify = "left"
    for field in shown:
        row = [_verbatim(field.path[:70]), _verbatim(field.unit), str(field.count)]
        figures = (field.low, field.high, field.mean, field.std)
        row += [f"{value:.5g}" if math.isfinite(value) else "-" for value in figures]
        table.add_row(*row)
    console.print(table)
    if names:
        _plain(console, names)
    if len(shown) < len(topic.fields):
        _plain(console, f"and {len(topic.fields) - len(shown)} more fields (--all)")
