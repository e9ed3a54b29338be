"""The story of an investigation as one HTML page: what was open, which motion, what it decided."""

from __future__ import annotations

import urllib.parse
from pathlib import Path

import numpy as np

from .. import __version__
from ..errors import InputError
from ..gap.report import quantities as q
from ..gap.report import words
from ..gap.report.markup import escape, figure, key, table, typeset
from ..gap.report.style import CSS
from ..gap.report.svg import Axis, Chart
from ..number_of import number_of
from ..recording.atomic import write_text
from ..recording.reader import read_recording
from ..recording.signals import Recording
from .played import missed
from .story import DECIDED, ENDED, Step, Story

_HEADS = {DECIDED: "Decided", ENDED: "Ended early"}


def write_page(story: Story, path: Path) -> None:
    """Write the page, whole or not at all; InputError where that cannot be."""
    body = [_head(story), _answer(story), *(_step(one) for one in story.steps), _foot()]
    write_text(
        path,
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Investigation of {escape(story.machine)}</title>\n"
        f"<style>{CSS}a {{ color: var(--after); }}</style>\n</head>\n<body>\n"
        + "\n".join(part for part in body if part)
        + "\n</body>\n</html>\n",
    )


def _head(story: Story) -> str:
    motions = number_of(len(story.steps), "motion")
    heading = _HEADS.get(story.outcome, "Still open")
    said = f"After {motions}: {story.said}." if story.said else f"{motions} so far."
    return (
        f'<header><h1>{heading}</h1><p class="verdict">{typeset(said)}</p>'
        f'<p class="quiet from">{escape(story.machine)} against {escape(Path(story.drive).name)}'
        "</p></header>"
    )


def _answer(story: Story) -> str:
    last = story.last
    if last is None:
        return ""
    return f"<section><h2>What is known now</h2><p>{typeset(last.sentence)}</p></section>"


def _step(step: Step) -> str:
    """One motion, from the question to the answer."""
    facts = [("was open", typeset(step.why)), ("the motion", _link(step.motion.name))]
    facts.append(("took", typeset(f"{step.duration_s:g} s")))
    if step.played.recording is not None:
        name = step.played.recording.name
        facts.append(("recorded", f"{_link(name)}, {step.played.samples} samples"))
    facts += [
        ("tracking error", _within(step.played.error_m, step.bounds.error_m, "m")),
        ("current", _within(step.played.current_a, step.bounds.current_a, "A")),
    ]
    if step.played.missed_ticks:
        facts.append(("missed", typeset(missed(step.played))))
    if step.played.ended is not None:
        facts.append(("ended by", f"<b>{typeset(step.played.ended)}</b>"))
    if step.diagnosis is not None:
        facts.append(("decided", typeset(step.sentence)))
        facts.append(("the diagnosis", _link(f"{step.stem}.html")))
        left = step.left.why if step.left is not None else "nothing"
        facts.append(("leaves open", typeset(left)))
    items = "".join(f"<dt>{name}</dt><dd>{text}</dd>" for name, text in facts)
    parts = [f"<dl>{items}</dl>", _pictures(step), _predicted(step)]
    return f"<section><h2>Motion {step.number}</h2>{''.join(parts)}</section>"


def _link(name: str) -> str:
    return f'<a href="{urllib.parse.quote(name)}">{escape(name)}</a>'


def _within(value: float, bound: float, unit: str) -> str:
    return typeset(f"up to {q.amount(value, unit)}, bound {q.amount(bound, unit)}")


def _pictures(step: Step) -> str:
    if step.played.recording is None:
        return ""
    try:
        shown = read_recording(step.played.recording)
    except InputError:
        return ""  # ended before a sample was whole
    if len(shown) < 2:
        return ""
    pictures = "".join(figure(*one) for one in (_places(shown), _errors(shown, step)))
    legend = key(("recorded", "reference"), ("after", "drive"), ("floor", "bound"))
    return f'{legend}<div class="pair">{pictures}</div>'


def _seconds(shown: Recording) -> np.ndarray:
    return (shown.stamp_ns - shown.stamp_ns[0]) * 1e-9


def _places(shown: Recording) -> tuple[str, str]:
    time = _seconds(shown)
    wanted, came = 1e3 * shown.reference_position_m, 1e3 * shown.rod_position_m
    chart = Chart(
        Axis(0.0, float(time[-1]), "time, s"),
        Axis.around("rod position, mm", wanted, came),
        "reference and rod position over time",
    )
    chart.curve(time, wanted, "recorded")
    chart.curve(time, came, "after")
    return str(chart), "Reference and rod."


def _errors(shown: Recording, step: Step) -> tuple[str, str]:
    time, bound = _seconds(shown), step.bounds.error_m
    error = 1e3 * (shown.reference_position_m - shown.rod_position_m)
    most = 1e3 * np.array([-bound, bound])
    chart = Chart(
        Axis(0.0, float(time[-1]), "time, s"),
        Axis.around("tracking error, mm", error, most),
        "tracking error over time, with its bound",
    )
    chart.curve(time, error, "after")
    for level in most.tolist():
        chart.level(level, "floor")
    return str(chart), "Tracking error; beyond the bound the drive is brought to rest."


def _predicted(step: Step) -> str:
    """What the motion was predicted to separate, beside usual ones."""
    plan = step.plan
    if plan is None or not plan.pairs:
        return ""
    head = [("separation, noise floors", ""), *((one.motion, "num") for one in plan.predictions)]
    rows = []
    for row, pair in enumerate(plan.pairs):
        names = f"{words.title(pair.first.effect)} or {words.title(pair.second.effect)}"
        cells = [typeset(f"{one.apart[row]:.2f}") for one in plan.predictions]
        rows.append([typeset(names), f"<b>{cells[0]}</b>", *cells[1:]])
    caption = (
        "Predicted before anything moved, beside usual motions of the same limits and time. A "
        f"diagnosis separates two effects from {plan.needed:.2f} on."
    )
    return table(caption, head, rows)


def _foot() -> str:
    return f'<p class="quiet">ecyl_ros {escape(__version__)}</p>'
