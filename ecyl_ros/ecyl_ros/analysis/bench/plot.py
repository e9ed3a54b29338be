"""Fig. 9: the loop, its median curve, the three lines, the clearance points."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ...recording.atomic import replacing
from .identify import Identified
from .units import ARCMIN

SIZE = (9.0, 6.0)
DPI = 130
DRAWN = 6000  # readings of the loop


def figure(found: Identified) -> Any:
    """The figure, axes as in the paper: torque across, angle up."""
    from matplotlib.figure import Figure

    made = Figure(figsize=SIZE, layout="constrained")
    draw(made.add_subplot(), found)
    return made


def draw(axis: Any, found: Identified) -> None:
    """Draw into an axis; an inset shows the clearance."""
    inset = axis.inset_axes((0.56, 0.08, 0.41, 0.4))
    lines = found.fit.lines
    largest = float(np.abs(found.loop.torque_nm).max())
    corners = [t for t in (lines.t1, lines.t2) if np.isfinite(t)]
    levels = np.unique([*np.linspace(0.0, largest, 200), *corners])
    torque = np.concatenate((-levels[::-1], levels))
    half = lines.angle_rad(levels)
    half[0] = lines.half_clearance_rad
    angle = np.concatenate((-half[::-1], half)) / ARCMIN
    zero = found.fit.angle_zero_rad
    every = max(1, found.loop.torque_nm.size // DRAWN)
    shift = found.fit.torque_zero_nm
    read = (found.loop.torque_nm[::every] - shift, (found.loop.angle_rad[::every] - zero) / ARCMIN)
    point = found.clearance_torque_nm
    reach = 0.5 * found.clearance_rad.value / ARCMIN
    for one, small in ((axis, False), (inset, True)):
        one.plot(*read, ".", ms=1.5, color="0.72", label="readings", rasterized=True)
        one.plot(
            found.curve.torque_nm - shift,
            (found.curve.angle_rad - zero) / ARCMIN,
            ".",
            ms=4,
            color="C0",
            label="median curve",
        )
        one.plot(torque, angle, color="C3", lw=1.3, label="three lines")
        one.plot(
            [-point, point],
            [-reach, reach],
            "o",
            ms=6,
            mfc="gold",
            mec="0.2",
            label=f"at $\\mp${point:g} N m: {2.0 * reach:.2f} arcmin",
        )
        one.grid(True, linewidth=0.4, alpha=0.6)
        if small:
            one.set_xlim(-3.5 * point, 3.5 * point)
            one.set_ylim(-1.4 * reach, 1.4 * reach)
            one.tick_params(labelsize=8)
    axis.set_xlabel("torque / (N m)")
    axis.set_ylabel("angle of the input shaft / arcmin")
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(loc="upper left", frameon=False, markerscale=2)


def write_plot(found: Identified, folder: str | Path) -> Path:
    """Write hysteresis.png, whole or not at all; returns where."""
    path = Path(folder) / "hysteresis.png"
    made = figure(found)
    made.axes[0].set_title("Hysteresis loop, output locked")
    with replacing(path) as temporary:
        made.savefig(temporary, dpi=DPI)
    return path
