"""Pictures of a plan: motion, the two recordings it is predicted to give, how it compares."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from ..arrays import FloatArray
from ..gap.replay.replay import SIGNALS
from .hypotheses import Hypothesis
from .make import Plan

_INK, _FIRST, _SECOND, _QUIET = "#222222", "#0b6e99", "#c4541c", "#9aa0a6"
_SIZE = (9.0, 6.5)
_NAMES = {
    "rotor_position": "rotor position, floors",
    "rotor_velocity": "rotor velocity, floors",
    "current_q": "current i_q, floors",
    "voltage_q": "voltage u_q, floors",
    "rod_position": "rod position, floors",
}


def write_pictures(plan: Plan, folder: Path) -> list[Path]:
    """Write motion.png, predicted.png (of the pair told least) and separation.png."""
    folder.mkdir(parents=True, exist_ok=True)
    matplotlib.use("Agg")
    pictures = {"motion.png": _motion(plan)}
    if plan.pairs:
        pictures["predicted.png"] = _predicted(plan)
        pictures["separation.png"] = _separation(plan)
    written = []
    for name, picture in pictures.items():
        picture.savefig(folder / name, dpi=110)
        written.append(folder / name)
    return written


def _motion(plan: Plan) -> Figure:
    motion = plan.motion
    times = np.linspace(0.0, motion.duration_s, 4000)
    shown = np.array([motion.sample(one) for one in times.tolist()])
    rows = [
        ("position, mm", 1e3 * shown[:, 0]),
        ("speed, mm/s", 1e3 * shown[:, 1]),
        ("acceleration, m/s²", motion.accelerations(times.tolist())),
    ]
    figure = Figure(figsize=_SIZE, layout="constrained")
    axes = figure.subplots(len(rows), 1, sharex=True)
    for axis, (label, values) in zip(axes, rows, strict=True):
        axis.plot(times, values, color=_INK, linewidth=0.9)
        _plain(axis, label)
    axes[0].set_title("The planned motion", loc="left")
    axes[-1].set_xlabel("time, s")
    return figure


def _predicted(plan: Plan) -> Figure:
    """What each of the two would do to the signals, less what the healthy drive does."""
    worst = int(np.argmin(plan.predictions[0].apart))
    pair = plan.pairs[worst]
    replay = plan.base.fitter.replay
    sound = replay.simulate({})

    def shown(one: Hypothesis) -> FloatArray:
        moved = replay.simulate({one.effect: one.values}) - sound
        made: FloatArray = moved / replay.floor[:, None]
        return made

    first, second = shown(pair.first), shown(pair.second)
    names = [one.name for one in SIGNALS if one in replay.signals]
    figure = Figure(figsize=(9.0, 1.7 * len(names) + 1.0), layout="constrained")
    axes = np.atleast_1d(figure.subplots(len(names), 1, sharex=True))
    for axis, name, one, other in zip(axes, names, first, second, strict=True):
        axis.plot(replay.time_s, one, color=_FIRST, linewidth=0.8, label=_label(pair.first))
        axis.plot(replay.time_s, other, color=_SECOND, linewidth=0.8, label=_label(pair.second))
        axis.axhspan(-1.0, 1.0, color=_QUIET, alpha=0.25, linewidth=0)
        _plain(axis, _NAMES[name])
    axes[0].legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False)
    axes[-1].set_xlabel("time, s; difference from the healthy drive; band: one noise floor")
    return figure


def _separation(plan: Plan) -> Figure:
    figure = Figure(figsize=(9.0, 1.2 + 0.7 * len(plan.pairs) * 1.4), layout="constrained")
    axis = figure.subplots()
    count = len(plan.predictions)
    for row, one in enumerate(plan.predictions):
        places = [index + 0.8 * row / count for index in range(len(plan.pairs))]
        axis.barh(
            places,
            one.apart,
            height=0.7 / count,
            color=_FIRST if row == 0 else _QUIET,
            alpha=1.0 if row == 0 else 0.45 + 0.1 * row,
        )
        for place, value in zip(places, one.apart, strict=True):
            axis.text(value, place, f" {one.motion} {value:.2g}", va="center", fontsize=8)
    axis.axvline(plan.needed, color=_SECOND, linewidth=1.0)
    axis.set_yticks(
        [index + 0.4 for index in range(len(plan.pairs))],
        [pair.name.replace(" | ", "\n").replace("_", " ") for pair in plan.pairs],
    )
    axis.invert_yaxis()
    axis.margins(x=0.2)
    axis.set_xlabel("separation, noise floors; the line is what it takes")
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)
    return figure


def _label(one: Hypothesis) -> str:
    return f"{one.effect.replace('_', ' ')}, {one.size}"


def _plain(axis, label: str) -> None:
    axis.set_ylabel(label, fontsize=8)
    axis.tick_params(labelsize=8)
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)
