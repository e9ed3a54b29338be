"""The summary for the terminal: plain text that reads the same in a pipe."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from ..diagnosis import Diagnosis
from . import law, limits, together, words
from . import quantities as q
from .rivals import runner_up
from .verdict import sentence, telling_condition, when_in_words

_WIDTH = 96
_MOST_PAIRS = 2
_TEXT = ("held out", "recording", "unit")  # columns of words, set to the left


def summary(diagnosis: Diagnosis, written: Sequence[str] = ()) -> str:
    """Verdict, causes, where, runner-up, notes and the paths of what was written."""
    blocks = [
        textwrap.fill(sentence(diagnosis), _WIDTH),
        _causes(diagnosis),
        _law(diagnosis),
        _signals(diagnosis),
        _recordings(diagnosis),
        _measured(diagnosis),
        _sheet(diagnosis),
        _limits(diagnosis),
        "\n".join([*_where(diagnosis), *_runner_up(diagnosis), *_notes(diagnosis)]),
        "\n".join(f"{'written':<10}{_clean(one)}" for one in written),
    ]
    return "\n\n".join(block for block in blocks if block)


def _clean(text: str) -> str:
    """No control characters from files reach the terminal."""
    return "".join(c if c.isprintable() else "?" for c in text)


def _table(rows: Sequence[Sequence[str]], right: Sequence[int]) -> str:
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [
            cell.rjust(width) if column in right else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def _causes(diagnosis: Diagnosis) -> str:
    if not diagnosis.causes:
        return ""
    rows = [["cause", "parameter", "value", "95 % interval", "confidence", "removes"]]
    for one in diagnosis.causes:
        name = [words.title(one.effect), q.confidence(one.confidence), q.percent(one.shrink)]
        for parameter in one.parameters:
            value, low, high, unit = q.interval(parameter)
            span = q.ends(low, high) + (" (bound)" if parameter.at_bound else "")
            label = q.parameter_label(parameter.name)
            rows.append([name[0], label, q.joined(value, unit), span, name[1], name[2]])
            name = ["", "", ""]
        if not one.parameters:
            rows.append([name[0], "", "", "", name[1], name[2]])
    return _table(rows, (2, 4, 5))


def _law(diagnosis: Diagnosis) -> str:
    if diagnosis.law is None:
        return ""
    rows = [["the law", ""], *([name, text] for name, text in law.facts(diagnosis.law))]
    return "\n".join(
        textwrap.fill(
            f"{name:<14}{text}", _WIDTH, subsequent_indent=" " * 14, break_long_words=False
        ).rstrip()
        for name, text in rows
    )


def _signals(diagnosis: Diagnosis) -> str:
    if not diagnosis.signals:
        return ""
    both = diagnosis.closes
    head = ["held out", "gap", "after", "floor", "unit", "gap/floor", "after/floor"]
    rows = []
    for one in diagnosis.signals:
        shown = (one.gap, one.after) if both else (one.gap,)  # with no cause, after is before
        row = [words.signal(one.name), *q.in_one_unit(shown, one.floor, one.unit, words.RAN_AWAY)]
        rows.append(row + [q.times(value, one.floor) for value in shown])
    if not both:
        head = [name for name in head if not name.startswith("after")]
    return _table([head, *rows], [at for at, name in enumerate(head) if name not in _TEXT])


def _recordings(diagnosis: Diagnosis) -> str:
    """Several recordings side by side."""
    rows = [[_clean(cell) for cell in row] for row in together.rows(diagnosis)]
    if not rows:
        return ""
    return _table(rows, [at for at, name in enumerate(rows[0]) if name not in _TEXT])


def _measured(diagnosis: Diagnosis) -> str:
    if not diagnosis.measured:
        return ""
    rows = [["measured", "value", "95 % interval", "nominal", ""]]
    for one in diagnosis.measured:
        value, span, nominal = q.measured(one)
        rows.append([q.parameter_label(one.name), value, span, nominal, one.meaning])
    return _table(rows, (1,))


def _sheet(diagnosis: Diagnosis) -> str:
    """The constants that the recording tells more of than the data sheet, or that the model needed
    beyond their tolerance; furthest off first."""
    told = sorted((one for one in diagnosis.sheet if one.told), key=lambda one: -abs(one.pull))
    if not told:
        return ""
    rows = [["the sheet", "nominal", "found", "95 % interval", "pull"]]
    rows += [[words.constant(one.parameter), *q.sheet_value(one)] for one in told]
    unseen = [words.constant(one.parameter) for one in diagnosis.sheet if not one.told]
    below = [f"not determined here: {', '.join(unseen)}"] if unseen else []
    below += [words.MOVED_BY_GAP] if diagnosis.verdict == "unexplained" else []
    return "\n".join([_table(rows, (1, 2, 4)), *below])


def _limits(diagnosis: Diagnosis) -> str:
    """How large a fault could have hidden, of the five that matter, and what looks alike."""
    lines = [limits.sentence(diagnosis), *limits.pairs(diagnosis)[:_MOST_PAIRS]]
    return "\n".join(textwrap.fill(one, _WIDTH) for one in lines if one)


def _where(diagnosis: Diagnosis) -> list[str]:
    lines = []
    when = telling_condition(diagnosis)
    if when is not None:
        share = q.whole_percent(when.share)
        lines.append(f"{'when':<10}{share} of the gap {when_in_words(when)}")
    if diagnosis.ports and diagnosis.verdict not in ("no_gap", "within_sheet"):
        ports = ", ".join(
            f"{one.block.replace('_', ' ')} {q.number(one.ratio)}" for one in diagnosis.ports
        )
        lines.append(f"{'at ports':<10}{ports} times the floor")
    return lines


def _runner_up(diagnosis: Diagnosis) -> list[str]:
    best = runner_up(diagnosis)
    if best is None:  # where no cause is named, the verdict says what came closest
        return []
    closer = best.judged < diagnosis.misfit_after
    why = " (what it adds is too unsure, or too little, to be named)" if closer else ""
    return [
        f"{'next best':<10}{words.effect_set(best.effects)}: misfit {q.number(best.judged)} noise "
        f"floors{why}; with the named causes {q.number(diagnosis.misfit_after)}"
    ]


def _notes(diagnosis: Diagnosis) -> list[str]:
    lines = [f"{'note':<10}{_clean(one)}" for one in diagnosis.notes[: words.MOST_NOTES]]
    more = len(diagnosis.notes) - words.MOST_NOTES
    if more > 0:
        lines.append(f"{'':<10}{more} more in the report and in the JSON")
    return lines
