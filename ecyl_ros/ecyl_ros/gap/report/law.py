"""A described cause in the report: sentences, facts, and the curve with its band and its points."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...drive.law import LEAST_PERIODS
from ...recording.runs import runs_of
from ..describe.axis import Axis as Table
from ..describe.description import Description
from ..describe.words import VARIABLES as SPOKEN
from ..diagnosis import Diagnosis
from ..listed import listed
from . import quantities as q
from . import words
from .markup import figure
from .svg import Axis, Chart

_MOST_POINTS = 400
_CURVE = 200
_ROWS = 4  # curves of a law of two variables
_RARE = 1e-6  # a chance below this is told in words


def sentence(diagnosis: Diagnosis, law: Description) -> str:
    """What was found, in a few sentences."""
    share = q.percent(law.shrink)
    how = "Added to the model" if law.in_balance else "Played in the drive"
    text = (
        f"Nothing in the catalogue explains the gap, but it can be described: {law.words}. {how} "
        f"it removes {'all' if share == '100 %' else share} of the gap on "
        "held-out data"
    )
    if diagnosis.floor > 0.0:
        text += f"; the residual is {q.times(diagnosis.after, diagnosis.floor)} times the noise"
    text += "."
    if law.ports:
        others = listed([one.replace("_", " ") for one in law.ports], "or")
        text += f" This recording cannot tell it from the same at the port {others}."
    near = law.resembles
    if near is not None:
        text += (
            f" It most resembles {words.with_article(near.effect)}, which leaves a misfit of "
            f"{q.number(near.misfit)} noise floors; the law leaves {q.number(near.law_misfit)}."
        )
    return text


def facts(law: Description) -> list[tuple[str, str]]:
    """Name and text of what is worth knowing of a law."""
    played = law.law
    found = [("acts at", f"{played.port}, in {played.unit}")]
    found.append(("depends on", " and ".join(SPOKEN[one] for one in played.of) or "nothing"))
    for name, unit, places, period in zip(
        played.of, played.units, played.at, played.periods, strict=True
    ):
        shown = "" if unit == "1" else f" {unit}"
        span = f"{q.number(places[0])} to {q.number(places[-1])}{shown}"
        if period > 0.0:
            found.append(("repeats", f"with {SPOKEN[name]}, every {q.number(period)}{shown}"))
        elif name != "direction":
            found.append(("known for", f"{SPOKEN[name]} from {span}; beyond, the last value holds"))
    if played.time_constant_s > 0.0:
        found.append(("heat", f"time constant {q.number(played.time_constant_s)} s"))
    once = [SPOKEN[name] for name, turns in law.turns.items() if turns < LEAST_PERIODS]
    if "position" in played.of and once:
        found.append(
            ("or else", f"{' or '.join(once)}: the motion covers too little of a turn to decide")
        )
    values = np.array(played.values)[law.seen] if law.seen.any() else np.array(played.values)
    found.append(
        (
            "ranges from",
            f"{q.number(float(values.min()))} to {q.number(float(values.max()))} {played.unit}",
        )
    )
    found.append(("formula", law.formula or "no formula of few terms fits as well as the table"))
    found.append(("removes", f"{q.percent(law.shrink)} of the gap, held out"))
    if law.next_best:
        of, worse = law.next_best[0]
        names = " and ".join(SPOKEN[one] for one in of) or "no variable"
        found.append(("next best", f"{names}: {q.number(worse)} times the error of prediction"))
    rare = q.number(law.chance) if law.chance >= _RARE else "less than one in a million"
    found.append(("by chance", f"{rare}, by how each part follows from the others"))
    return found


def pictures(law: Description) -> list[str]:
    """The law's curve over the points it was read from, and the missing quantity over time."""
    found = []
    unknown = "" if law.in_balance else "flanks apart, "
    if law.law.of:
        chart = _curves(law)
        what = "Dots: what the recording lacks at this port. Line: the law"
        if len(law.law.of) == 1:
            what += ", with its 95 % band"
            if law.resembles is not None and law.resembles.curve is not None:
                name = words.with_article(law.resembles.effect)
                what += f". Red: what {name}, the nearest named effect, would give there"
        else:
            second = SPOKEN[law.law.of[1]]
            what += f", at values of {second} spread over the visited range"
        found.append(figure(str(chart), f"{what}."))
    found.append(
        figure(
            str(_course(law)),
            "The missing quantity over time with its 95 % band from the sensors' noise, and what "
            f"the law gives; shaded where it is not known: {unknown}at rest, after a reversal.",
        )
    )
    return found


def _curves(law: Description) -> Chart:
    played, points = law.law, law.points
    step = max(1, points.shape[1] // _MOST_POINTS)
    x, y = points[0, ::step], points[-1, ::step]
    if played.periods[0] > 0.0:
        x = np.mod(x, played.periods[0])
    unit = played.units[0]
    label = SPOKEN[played.of[0]] + ("" if unit == "1" else f", {unit}")
    places = np.array(played.at[0])
    table = np.array(played.values).reshape(len(places), -1)
    low, high = np.quantile(y, [0.01, 0.99])
    what = "level" if played.of_friction else "value"
    near = None if law.resembles is None else law.resembles.curve
    beside = () if near is None else (near[1],)
    chart = Chart(
        Axis.around(label, places, x),
        Axis.around(f"{what}, {played.unit}", np.array([low, high]), table, *beside),
        f"the law over {label}",
    )
    fine = np.linspace(places[0], places[-1], _CURVE)
    chart.dots(x, y)
    if table.shape[1] == 1:
        half = np.interp(fine, places, law.half)
        middle = _along(places, table[:, 0], played.periods[0], fine)
        chart.band(fine, middle - half, middle + half, "after")
        if near is not None:
            chart.curve(near[0], near[1], "before")
        chart.curve(fine, middle, "after")
        return chart
    for column in np.unique(np.linspace(0, table.shape[1] - 1, _ROWS).round().astype(int)):
        middle = _along(places, table[:, column], played.periods[0], fine)
        chart.curve(fine, middle, "after")
    return chart


def _along(places: FloatArray, values: FloatArray, period: float, x: FloatArray) -> FloatArray:
    found: FloatArray = values @ Table("", places, period).columns(x)
    return found


def _course(law: Description) -> Chart:
    course = law.course
    known = course.known
    low, high = np.quantile(course.values[known], [0.005, 0.995]) if known.any() else (-1.0, 1.0)
    chart = Chart(
        Axis(float(course.time_s[0]), float(course.time_s[-1]), "time, s"),
        Axis.around(f"missing, {course.unit}", np.array([low, high]), course.predicted[known]),
        "the missing quantity over time",
    )
    last = len(course.time_s) - 1
    for start, stop in runs_of(~known).tolist():
        chart.shade(float(course.time_s[min(start, last)]), float(course.time_s[min(stop, last)]))
    shown = np.where(known, course.values, np.nan)
    chart.curve(course.time_s, shown, "before")
    chart.curve(course.time_s, np.where(known, course.predicted, np.nan), "after")
    return chart
