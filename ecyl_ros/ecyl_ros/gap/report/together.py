"""What is said of several recordings of one machine: in a sentence, a table, and a section each."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from ...effects.catalogue import EFFECTS
from ..diagnosis import Diagnosis, FittedParameter
from ..listed import listed
from ..several.of_recording import OfRecording, OwnValue
from . import quantities as q
from . import stretch, words
from .markup import escape, table, typeset


def sentences(diagnosis: Diagnosis) -> str:
    """What the last recording says of the others' causes, and which values differ; may be empty."""
    return " ".join(one for one in (_unseen(diagnosis), *_differences(diagnosis)) if one)


def _unseen(diagnosis: Diagnosis) -> str:
    found = diagnosis.unseen
    if found is None or not diagnosis.closes or diagnosis.law is not None:
        return ""
    names = {one.source: one.name for one in diagnosis.recordings}
    others = listed([names[one] for one in found.named_on])
    last, share = names[found.source], q.percent(found.shrink)
    off = f"removes {share} of the gap on {last}, which was held out"
    if found.verdict == "within_sheet" and not diagnosis.causes:
        return f"As found on {others} alone, the sheet {off}."
    named = [one.effect for one in diagnosis.causes]
    if set(found.causes) == set(named):
        if len(named) > 1:
            return f"Named on {others} alone, they {off.replace('removes', 'remove', 1)}."
        return f"Named on {others} alone, it {off}."
    if found.causes:
        other = listed([words.with_article(one) for one in found.causes])
        return f"On {others} alone {other} would be named, which {off}."
    return f"On {others} alone nothing would be named; with {last} it can be."


def _differences(diagnosis: Diagnosis) -> list[str]:
    said = []
    for label, own in _by_value(diagnosis.recordings):
        known = [(one.name, value) for one, value in own if value is not None]
        known = [(name, value) for name, value in known if value.seen]
        if any(value.differs for _, value in known):
            each = listed([f"{_span(value)} in {name}" for name, value in known])
            said.append(f"Not the same in all: {label} {each}.")
    return said


def _by_value(
    recordings: Sequence[OfRecording],
) -> list[tuple[str, list[tuple[OfRecording, OwnValue | None]]]]:
    """Every value that one of them has, with what it is called, and as each has it."""
    keys = dict.fromkeys((one.of, one.name) for own in recordings for one in own.values)
    made = []
    for of, name in keys:
        row = [
            (own, next((one for one in own.values if (one.of, one.name) == (of, name)), None))
            for own in recordings
        ]
        made.append((_label(of, name), row))
    return made


def _label(of: str, name: str) -> str:
    if of not in EFFECTS:
        return words.constant(of)
    return f"{words.title(of)}, {q.parameter_label(name)}"


def _span(one: OwnValue) -> str:
    return q.with_interval(FittedParameter(one.name, one.unit, one.value, one.low, one.high))


def rows(diagnosis: Diagnosis) -> list[list[str]]:
    """A table for the terminal; empty for a single recording."""
    if not diagnosis.recordings:
        return []
    closes = diagnosis.closes
    head = ["recording", "s", "gap", "floor", "unit", "gap/floor"]
    made = [head + (["after/floor", "removed", "by the others"] if closes else [])]
    for one in diagnosis.recordings:
        row = [one.name, q.number(one.duration_s)]
        # Pooled over signals of several units it is a share of them.
        factor, unit = (1.0, one.unit) if one.unit else (100.0, "%")
        row += q.in_one_unit([factor * one.before], factor * one.floor, unit)
        row += [q.times(one.before, one.floor)]
        if closes:
            unseen = "-" if one.unseen is None else q.percent(one.unseen)
            row += [q.times(one.after, one.floor), q.percent(one.shrink), unseen]
        made.append(row)
    return made


def parts(diagnosis: Diagnosis, keys: str) -> list[str]:
    """The recordings side by side, and each by itself, as HTML; nothing of a single one.

    keys: to the curves of the pictures.
    """
    if not diagnosis.recordings:
        return []
    said = (
        "One set of causes and one sheet were found for all. Pictures: the held-out stretch with "
        "the largest gap; no parameter was fitted to it."
    )
    head, *body = rows(diagnosis)
    kinds = ["" if name in ("recording", "unit") else "num" for name in head]
    cells = [[escape(row[0]), *(typeset(cell) for cell in row[1:])] for row in body]
    caption = (
        "RMS on held-out stretches of each recording, in its own noise; of several signals "
        "together as a share of how far these vary. By the others: the gap "
        "that the same causes remove from the whole recording with the values that the other "
        "recordings give."
    )
    side_by_side = table(caption, list(zip(head, kinds, strict=True)), cells)
    each = [_article(diagnosis, one) for one in diagnosis.recordings]
    return [f"<p>{said}</p>", keys, side_by_side, *each]


def _article(diagnosis: Diagnosis, own: OfRecording) -> str:
    made = [
        [
            typeset(_label(one.of, one.name)),
            f"<b>{typeset(_span(one))}</b>" if one.differs else typeset(_span(one)),
            "not the same in all" if one.differs else "" if one.seen else "not determined here",
        ]
        for one in own.values
    ]
    values = ""
    if made:
        caption = "Values that this recording alone gives, with their 95 % intervals."
        values = table(caption, [("value", ""), ("here", "num"), ("", "")], made)
    return f"<article><h3>{escape(own.name)}</h3>{values}{_picture(diagnosis, own)}</article>"


def _picture(diagnosis: Diagnosis, own: OfRecording) -> str:
    """Its held-out stretch with the largest gap, on its own time."""
    series, (first, behind) = diagnosis.series, own.rows
    if behind <= first:
        return ""
    held = series.held_out.copy()
    held[:first] = held[behind:] = False
    time = series.time_s - series.time_s[first]
    alone = dataclasses.replace(
        diagnosis, series=dataclasses.replace(series, held_out=held, time_s=time)
    )
    chosen = stretch.worst(alone)
    return "" if chosen is None else stretch.figures(alone, chosen)
