"""The picture in README: `python docs/first_look.py OUT.png`.

Residual of one recorded signal with the data sheet and with the twin, and the gap of all signals.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import ecyl_ros as ec
from ecyl_ros.gap.diagnosis import Diagnosis

RECORDING = Path(__file__).parent.parent / "bags" / "worn_drive.mcap"
SIGNAL = "rotor_position"
SHOWN_S = (4.0, 6.5)
FLOOR, BEFORE, AFTER = "#8a8f98", "#b4451f", "#1f4e9c"


def _residual(axis: plt.Axes, found: Diagnosis) -> None:
    """One signal's residual over some of the recording."""
    series = found.series
    at = [one.name for one in found.signals].index(SIGNAL)
    part = (series.time_s >= SHOWN_S[0]) & (series.time_s <= SHOWN_S[1])
    for simulated, colour, label in (
        (series.before, BEFORE, "residual, data sheet"),
        (series.after, AFTER, "residual, twin"),
    ):
        residual = (series.recorded - simulated)[at][part] * 1e3
        axis.plot(series.time_s[part], residual, color=colour, lw=1.0, label=label)
    axis.set(xlabel="time / s", ylabel="rotor position, residual / mrad")
    axis.legend(frameon=False, ncols=2, loc="lower center", bbox_to_anchor=(0.5, 1.0))


def _signals(axis: plt.Axes, found: Diagnosis) -> None:
    """Every signal's held-out gap before and after."""
    names = [one.name.replace("_", " ") for one in found.signals]
    rows = np.arange(len(names))
    before = [one.gap / one.floor for one in found.signals]
    after = [one.after / one.floor for one in found.signals]
    axis.barh(rows - 0.19, before, 0.36, color=BEFORE, label="data sheet")
    axis.barh(rows + 0.19, after, 0.36, color=AFTER, label="twin")
    axis.axvline(1.0, color=FLOOR, lw=1.2, label="noise floor")
    axis.set(xscale="log", xlim=(0.1, None), xlabel="held-out gap / noise floor")
    axis.set_yticks(rows, names)
    axis.invert_yaxis()
    axis.legend(
        frameon=False, ncols=3, loc="lower center", bbox_to_anchor=(0.3, 1.0), handlelength=1.0
    )


def draw(out: Path) -> None:
    """Diagnose the recording and draw what is left of it."""
    found = ec.diagnose(ec.read(RECORDING), "bench")
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(9.6, 3.2), width_ratios=(3, 2), constrained_layout=True
    )
    for axis in (left, right):
        axis.spines[["top", "right"]].set_visible(False)
        axis.grid(alpha=0.25)
    _residual(left, found)
    _signals(right, found)
    figure.savefig(out, dpi=100)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    draw(Path(sys.argv[1]))
