"""How a diagnosis looks in a notebook: tables without a style sheet of their own, and a picture."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from typing import Any

from matplotlib.figure import Figure

from ..errors import InputError
from ..gap.diagnosis import Diagnosis
from ..gap.report import quantities as q
from ..gap.report import words
from ..gap.report.markup import escape, typeset
from ..gap.report.stretch import telling_signals, worst
from ..gap.report.verdict import sentence

# Of a legend outside the axes; `loc="outside ..."` is newer than the matplotlib of Ubuntu 24.04.
_ABOVE: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0)}
# Colours that hold against each other for every eye (Okabe and Ito), recorded in grey behind.
_RECORDED, _BEFORE, _AFTER = "0.65", "#d55e00", "#0072b2"


def html(diagnosis: Diagnosis) -> str:
    """Verdict, causes, gap by signal, constants that are off, notes."""
    parts = [
        f"<h4>{escape(words.verdict(diagnosis.verdict))}</h4><p>{typeset(sentence(diagnosis))}</p>",
        _table(("cause", "parameter", "value", "95 % interval", "confidence"), _causes(diagnosis)),
        _table(("held out", "gap", "after", "noise floor", "unit"), _signals(diagnosis)),
        _table(("measured", "value", "95 % interval", "nominal"), _measured(diagnosis)),
        _table(("constant", "nominal", "found", "95 % interval", "pull"), _sheet(diagnosis)),
    ]
    shown = list(diagnosis.notes[: words.MOST_NOTES])
    if more := len(diagnosis.notes) - len(shown):
        shown.append(f"{more} more in the notes of the diagnosis")
    notes = "".join(f"<li>{typeset(one)}</li>" for one in shown)
    parts.append(f"<ul>{notes}</ul>" if notes else "")
    return f"<div>{''.join(parts)}</div>"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    body = "".join(
        "<tr>" + "".join(f"<td>{typeset(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    if not body:
        return ""
    names = "".join(f"<th>{escape(one)}</th>" for one in head)
    return f"<table><thead><tr>{names}</tr></thead><tbody>{body}</tbody></table>"


def _causes(diagnosis: Diagnosis) -> Iterable[Sequence[str]]:
    for one in diagnosis.causes:
        first = [words.title(one.effect), q.confidence(one.confidence)]
        for parameter in one.parameters:
            value, low, high, unit = q.interval(parameter)
            label = q.parameter_label(parameter.name)
            yield first[0], label, q.joined(value, unit), f"{low} to {high}", first[1]
            first = ["", ""]
        if not one.parameters:
            yield first[0], "", "", "", first[1]


def _signals(diagnosis: Diagnosis) -> Iterable[Sequence[str]]:
    for one in diagnosis.signals:
        figures = q.in_one_unit((one.gap, one.after), one.floor, one.unit, words.RAN_AWAY)
        yield words.signal(one.name), *figures


def _measured(diagnosis: Diagnosis) -> Iterable[Sequence[str]]:
    for one in diagnosis.measured:
        value, span, nominal = q.measured(one)
        yield q.parameter_label(one.name), value, span, nominal


def _sheet(diagnosis: Diagnosis) -> Iterable[Sequence[str]]:
    """The constants that the recording tells more of than the data sheet, furthest off first."""
    for one in sorted(diagnosis.sheet, key=lambda one: -abs(one.pull)):
        if one.seen:
            yield words.constant(one.parameter), *q.sheet_value(one)


class _Picture(Figure):
    """A figure that a notebook shows whether or not pyplot was set up for it."""

    def _repr_png_(self) -> bytes:
        shown = io.BytesIO()
        self.savefig(shown, format="png", dpi=90, bbox_inches="tight")
        return shown.getvalue()


def picture(diagnosis: Diagnosis) -> Figure:
    """A panel a signal: recorded, the nominal model, and the twin."""
    stretch = worst(diagnosis)
    if stretch is None:
        raise InputError(f"{diagnosis.source}: nothing was held out, so there is nothing to draw")
    series = diagnosis.series
    shown = telling_signals(diagnosis, stretch)
    figure = _Picture(figsize=(8.0, 2.0 * len(shown) + 0.6), layout="constrained")
    panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    time = series.time_s[stretch.rows]
    runs = [("nominal model", series.before, _BEFORE)]
    if diagnosis.closes:
        runs.append(("twin", series.after, _AFTER))
    for index, panel in zip(shown, panels, strict=True):
        recorded = series.recorded[index, stretch.rows]
        largest = max((abs(float(value)) for value in recorded if value == value), default=0.0)
        factor, unit = q.engineering(largest, diagnosis.signals[index].unit)
        panel.plot(time, factor * recorded, color=_RECORDED, linewidth=4.0, label="recorded")
        low, high = panel.get_ylim()
        for name, run, colour in runs:
            panel.plot(time, factor * run[index, stretch.rows], color=colour, lw=1.1, label=name)
        margin = 0.5 * (high - low)  # a model that runs away leaves the picture
        now_low, now_high = panel.get_ylim()
        panel.set_ylim(max(low - margin, now_low), min(high + margin, now_high))
        panel.set_ylabel(f"{words.signal(diagnosis.signals[index].name)}\n{unit}")
        panel.margins(x=0.0)
    panels[-1].set_xlabel("time, s")
    figure.legend(*panels[0].get_legend_handles_labels(), **_ABOVE, ncols=3)
    return figure
