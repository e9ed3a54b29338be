"""The index of a fleet: as a page, sorted by gap, with a trend of every machine, and as CSV."""

from __future__ import annotations

import csv
import io
import urllib.parse
from collections.abc import Sequence
from datetime import UTC, datetime

from ... import __version__
from ...number_of import number_of
from ..listed import listed
from ..report import quantities as q
from ..report import words
from ..report.markup import escape, figure, table, typeset
from ..report.style import CSS
from .entry import Entry
from .trend import MARKS, trend

_EARLIEST_NS = 946_684_800 * 10**9  # 2000: stamps before it are of a simulated clock
_COLUMNS = (
    "recording",
    "machine",
    "start",
    "duration_s",
    "verdict",
    "gap_floors",
    "after_floors",
    "shrink",
    "block",
    "cause",
    "parameter",
    "value",
    "low",
    "high",
    "unit",
    "confidence",
    "error",
)


def by_gap(entries: Sequence[Entry]) -> list[Entry]:
    """The largest gap first, then what could not be diagnosed; by name where these are equal."""
    return sorted(entries, key=lambda one: (bool(one.error), -one.gap, one.name))


def start(one: Entry) -> str:
    """When a recording began, UTC; its stamp in s where that is no date."""
    if one.error:
        return ""
    if one.start_ns < _EARLIEST_NS:
        return f"{one.start_ns * 1e-9:.3f} s"
    return datetime.fromtimestamp(one.start_ns // 10**9, UTC).strftime("%Y-%m-%d %H:%M:%S")


def as_csv(entries: Sequence[Entry]) -> str:
    """One row per recording, and one more for every further cause; SI."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(_COLUMNS)
    for one in by_gap(entries):
        head = [one.name, one.machine, start(one)]
        if one.error:
            writer.writerow([*head, *[""] * (len(_COLUMNS) - 4), one.error])
            continue
        head += [f"{one.duration_s:.6g}", one.verdict, f"{one.gap:.6g}", f"{one.after:.6g}"]
        head += [f"{one.shrink:.6g}", one.block or ""]
        sure = "" if one.confidence is None else f"{one.confidence:.4g}"
        for size in one.causes or (None,):
            if size is None:
                writer.writerow([*head, *[""] * 6, sure, ""])
                continue
            spans = [f"{value:.9g}" for value in (size.value, size.low, size.high)]
            writer.writerow([*head, size.effect, size.parameter, *spans, size.unit, sure, ""])
    return out.getvalue()


def as_html(entries: Sequence[Entry], folder: str, drive: str) -> str:
    """The page."""
    failed = [one for one in entries if one.error]
    body = [_head(entries, folder, drive), _table(entries), _trends(entries)]
    if failed:
        rows = [[escape(one.name), escape(one.error)] for one in by_gap(failed)]
        said = table("No diagnosis was made of these.", [("recording", ""), ("why", "")], rows)
        body.append(f"<section><h2>Not diagnosed</h2>{said}</section>")
    body.append(f'<p class="quiet">ecyl_ros {escape(__version__)}</p>')
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Diagnoses of {escape(folder)}</title>\n<style>{CSS}{MARKS}</style>\n</head>\n"
        "<body>\n" + "\n".join(part for part in body if part) + "\n</body>\n</html>\n"
    )


def _head(entries: Sequence[Entry], folder: str, drive: str) -> str:
    counts: dict[str, int] = {}
    for one in entries:
        kind = "not diagnosed" if one.error else words.verdict(one.verdict).lower()
        counts[kind] = counts.get(kind, 0) + 1
    said = listed([f"{number} {kind}" for kind, number in sorted(counts.items())])
    machines = len({one.machine for one in entries})
    return (
        f'<header><h1>{len(entries)} recordings</h1><p class="verdict">{typeset(said)}.</p>'
        f'<p class="quiet from">{escape(folder)} against {escape(drive)}, '
        f"{number_of(machines, 'machine')}</p></header>"
    )


def _table(entries: Sequence[Entry]) -> str:
    head = [("recording", ""), ("machine", ""), ("from", ""), ("gap", "num"), ("verdict", "")]
    head += [("place", ""), ("cause", ""), ("size", "num"), ("confidence", "num")]
    rows = []
    for one in by_gap([entry for entry in entries if not entry.error]):
        page = urllib.parse.quote(f"recordings/{one.name}.html")
        sure = "" if one.confidence is None else q.confidence(one.confidence)
        rows.append(
            [
                f'<a href="{page}">{escape(one.name)}</a>',
                escape(one.machine),
                escape(start(one)),
                typeset(q.number(one.gap)),
                typeset(words.verdict(one.verdict).lower()),
                typeset(words.block(one.block)) if one.block else "",
                typeset(one.cause),
                typeset(one.size),
                typeset(sure),
            ]
        )
    caption = (
        "By gap: misfit of the nominal model in noise floors, 1 is noise. Every name leads to the "
        "report of that recording."
    )
    return f"<section><h2>By gap</h2>{table(caption, head, rows)}</section>" if rows else ""


def _trends(entries: Sequence[Entry]) -> str:
    machines: dict[str, list[Entry]] = {}
    for one in entries:
        if not one.error:
            machines.setdefault(one.machine, []).append(one)
    parts = []
    for name in sorted(machines):
        made = trend(machines[name])
        if made:
            pictures = "".join(figure(picture, typeset(caption)) for picture, caption in made)
            parts.append(f'<h3>{escape(name)}</h3><div class="pair">{pictures}</div>')
    if not parts:
        return ""
    return f"<section><h2>Over time</h2>{''.join(parts)}</section>"
