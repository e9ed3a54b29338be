"""`ecyl inspect FILE`: what a recording holds, and which field could be which signal."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .outputs import add_overwrite, check_outputs
from .recording_options import add_span, read_span

if TYPE_CHECKING:
    from rich.console import Console

    from ..recording.check import MapCheck
    from ..recording.map import SignalMap
    from ..recording.span import Span
    from ..recording.survey import StampFigures, Survey, TopicSurvey

FIELDS_SHOWN = 24  # per topic; --all shows the rest
GAPS_SHOWN = 3
CHECKED_S = 40.0  # of a large bag, whose signs are compared


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's flags."""
    parser.add_argument(
        "recording",
        type=Path,
        metavar="FILE",
        help="MCAP, sqlite3, CSV or MAT file, rosbag2 folder, or folder of CSV files",
    )
    parser.add_argument(
        "--map", type=Path, metavar="M.yaml", help="check this map against the recording"
    )
    add_span(parser)
    parser.add_argument("--write-map", type=Path, metavar="OUT.yaml", help="write the proposed map")
    parser.add_argument("--json", type=Path, metavar="OUT", help="write the figures as JSON")
    parser.add_argument("--all", action="store_true", help="show every field of every topic")
    add_overwrite(parser)


def run(options: argparse.Namespace) -> int:
    """Look through the recording once; write what was asked for, print the rest.

    Returns 2 where a map that was to be checked cannot be used.
    """
    span = read_span(options)
    check_outputs(
        {"--write-map": options.write_map, "--json": options.json},
        {"FILE": options.recording, "--map": options.map},
        overwrite=options.overwrite,
    )
    if options.map is not None:
        return _check(options, span)
    return _propose(options, span)


def _propose(options: argparse.Namespace, span: Span | None) -> int:
    from ..recording.atomic import write_text
    from ..recording.map import map_yaml
    from ..recording.propose import propose
    from ..recording.survey import survey

    found = survey(options.recording, span)
    proposal = propose(found)
    problems = [] if proposal.map is None else _sign_problems(options.recording, proposal.map)
    text = ""
    if proposal.map is not None:
        lines = (f"proposed from {options.recording}; check it", *problems, *proposal.remarks)
        text = map_yaml(proposal.map, "\n".join(lines))
    if options.json is not None:
        data = {
            **found.as_json(),
            "map": text or None,
            "remarks": list(proposal.remarks),
            "problems": problems,
        }
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


def _sign_problems(path: Path, signal_map: SignalMap) -> list[str]:
    """Signals whose signs contradict each other, as the proposed map reads them."""
    from ..errors import InputError
    from ..recording.load import load_stretch
    from ..recording.signs import wrong_signs

    try:
        recording = load_stretch(path, signal_map, CHECKED_S)
    except InputError:  # what keeps it from being read stands among the remarks
        return []
    return [one.text for one in wrong_signs(recording)]


def _check(options: argparse.Namespace, span: Span | None) -> int:
    """Hold the map against the recording; 2 where it cannot be used."""
    from ..errors import InputError
    from ..recording.atomic import write_text
    from ..recording.check import check_map

    if options.write_map is not None:
        raise InputError("--write-map writes the proposed map; expected it without --map")
    found = check_map(options.recording, options.map, span)
    if options.json is not None:
        write_text(options.json, json.dumps(found.as_json(), indent=2, allow_nan=False) + "\n")
    for line in found.lines():
        print(line, file=sys.stderr)
    for note in found.notes:
        print(f"ecyl inspect: {note}", file=sys.stderr)
    _print_check(found)
    if found.usable:
        return 0
    wrong = sum(one.fatal for one in found.problems)
    raise InputError(f"{options.map}: cannot be used: {wrong} mistakes, above line by line")


def _print_check(found: MapCheck) -> None:
    from rich.console import Console

    console = Console(highlight=False, width=500, color_system=None)
    if not found.signals:
        return
    table = _table("signal", "field", "unit", "samples", "min", "max", "mean", "std", "step")
    table.columns[1].justify = table.columns[2].justify = "left"
    for one in found.signals:
        row = [one.name, one.where[:70], one.unit, str(one.count)]
        row += [_figure(value) for value in (one.low, one.high, one.mean, one.std)]
        row.append("" if one.resolution is None else _figure(one.resolution))
        table.add_row(*map(_verbatim, row))
    console.print(table)
    _plain(console, f"\n{found.duration_s:.6g} s at {found.rate_hz:.6g} Hz")


def _figure(value: float) -> str:
    return f"{value:.5g}" if math.isfinite(value) else "-"


def _print(found: Survey, *, all_fields: bool) -> None:
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True)
    if not console.is_terminal:
        console = Console(highlight=False, width=500, color_system=None)
    _print_topics(console, found)
    for line in found.flaw_lines():
        _plain(console, line)
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
