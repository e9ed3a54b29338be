"""The pictures of these pages: `python docs/field/pictures.py FIELD OUT`.

FIELD is the folder that holds emps, laas_pmsm_cogging and sage_so101; OUT the folder to write to.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from ecyl_ros.drive.rigid.machine_file import load_machine
from ecyl_ros.effects.catalogue import rigid_forms
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.diagnosis import Diagnosis
from ecyl_ros.recording.load import load_recording
from ecyl_ros.recording.map_file import load_map

HERE = Path(__file__).parent
STARTED_S = 0.5  # the motor has come up to speed
RECORDED, BEFORE, AFTER = "#8a8f98", "#b4451f", "#1f4e9c"


def _load(field: Path, recording: str, name: str):
    return load_recording(field / recording, load_map(HERE / f"{name}.map.yaml"))


def _axes(columns: int):
    figure, axes = plt.subplots(1, columns, figsize=(9.0, 3.2), constrained_layout=True)
    for one in axes:
        one.spines[["top", "right"]].set_visible(False)
        one.grid(alpha=0.25)
    return figure, axes


def emps(field: Path, out: Path) -> None:
    """Friction over speed, and what either model leaves of the force."""
    recording = _load(field, "emps/DATA_EMPS.mat", "emps")
    found = diagnose(recording, load_machine(HERE / "emps.yaml"))
    published = diagnose(recording, load_machine(HERE / "emps_published.yaml"))
    series = found.series
    figure, (left, right) = _axes(2)
    friction = (series.recorded - series.before)[0]
    left.plot(series.speed * 1e3, friction, ".", ms=2, color=RECORDED, label="force less inertia")
    order = np.argsort(series.speed)
    model = (series.after - series.before)[0]
    left.plot(series.speed[order] * 1e3, model[order], ".", ms=1.5, color=AFTER, label="named")
    left.set(xlabel="speed / (mm/s)", ylabel="friction / N", ylim=(-65, 65))
    left.legend(frameon=False, markerscale=4)
    part = (series.time_s > 6.0) & (series.time_s < 12.4)
    for diagnosis, colour, label in (
        (published, BEFORE, "one friction both ways"),
        (found, AFTER, "friction by direction"),
    ):
        curves = diagnosis.series
        simulated = curves.before if diagnosis is published else curves.after
        residual = (curves.recorded - simulated)[0]
        right.plot(curves.time_s[part], residual[part], color=colour, lw=0.9, label=label)
    right.set(xlabel="time / s", ylabel="force left / N", ylim=(-9, 9))
    right.legend(frameon=False, loc="upper right")
    figure.savefig(out / "emps.png", dpi=110)


def emps_law(field: Path, out: Path) -> None:
    """The drag that is described where no friction may be named, beside the published friction."""
    recording = _load(field, "emps/DATA_EMPS.mat", "emps")
    frictions = [name for name in rigid_forms(linear=True) if "friction" in name]
    found = diagnose(recording, load_machine(HERE / "emps.yaml"), without=frictions)
    assert found.law is not None
    learned = found.law
    (speeds,), drag = learned.law.at, np.array(learned.law.values)
    speed, points = learned.points
    figure, axis = plt.subplots(figsize=(6.5, 3.4), constrained_layout=True)
    axis.spines[["top", "right"]].set_visible(False)
    axis.grid(alpha=0.25)
    axis.plot(1e3 * speed, points, ".", ms=1.5, color=RECORDED, label="drag that is missing")
    mm_per_s = 1e3 * np.array(speeds)
    axis.fill_between(
        mm_per_s, drag - learned.half, drag + learned.half, color=AFTER, alpha=0.2, lw=0.0
    )
    axis.plot(mm_per_s, drag, color=AFTER, label="law, with its 95 % band")
    for level, slope, way in ((20.14, 166.7, 1.0), (20.63, 240.4, -1.0)):
        along = way * np.linspace(2.0, 128.0, 2)
        label = "published friction" if way > 0.0 else None
        drawn = level + slope * np.abs(along) / 1e3
        axis.plot(along, drawn, "--", color=BEFORE, lw=1.2, label=label)
    axis.set(xlabel="speed / (mm/s)", ylabel="drag / N", ylim=(0.0, 65.0))
    axis.legend(frameon=False, markerscale=5, loc="lower left")
    figure.savefig(out / "emps_law.png", dpi=110)


def _orders(diagnosis: Diagnosis) -> tuple[np.ndarray, np.ndarray]:
    """Amplitude in N m of the gap at each whole order of the rotor angle, once it turns.

    Averages are over the angle: cogging makes the rotor linger where it holds it.
    """
    series = diagnosis.series
    rows = series.usable & (series.time_s > STARTED_S)
    angle, gap = series.position[rows], (series.recorded - series.before)[0][rows]
    weight = np.abs(series.speed[rows]) / np.abs(series.speed[rows]).sum()
    gap = gap - weight @ gap
    orders = np.arange(1, 161)
    return orders, np.array([2.0 * abs((weight * gap) @ np.exp(1j * k * angle)) for k in orders])


def laas(field: Path, out: Path) -> None:
    """The gap over the order of the rotor angle, as the speed loop sees it, in both states."""
    figure, axes = _axes(2)
    for axis, name, bare in zip(axes, ("speed_test", "speed_test1"), (1.0, 0.0), strict=True):
        recording = _load(field, f"laas_pmsm_cogging/{name}.txt", "laas")
        machine = load_machine(HERE / "laas_loop.yaml")
        for mode, colour, label in (
            (bare, BEFORE, "not compensated"),
            (1.0 - bare, AFTER, "compensated"),
        ):
            orders, size = _orders(diagnose(recording, machine, mode=mode))
            shift = 0.5 if mode == bare else -0.5
            axis.vlines(orders + shift, 0.0, size * 1e3, color=colour, lw=1.6, label=label)
        axis.set(xlabel="periods per turn", ylabel="torque gap / mN m", title=f"{name}.txt")
        axis.legend(frameon=False)
    figure.savefig(out / "laas.png", dpi=110)


def sage(field: Path, out: Path) -> None:
    """Position over command: the loop of the joint, and that of lag and dead band alone."""
    figure, axes = _axes(2)
    runs = ("friction_gravity", "backlash_detection")
    for axis, run in zip(axes, runs, strict=True):
        recording = _load(field, f"sage_so101/{run}", "sage")
        found = diagnose(recording, load_machine(HERE / "sage.yaml"))
        series = found.series
        part = (series.time_s > 20.0) & (series.time_s < 60.0)
        command, position = series.reference_m[part], series.recorded[0][part]
        axis.plot(command * 1e3, position * 1e3, color=RECORDED, lw=0.8, label="recorded")
        axis.plot(command * 1e3, command * 1e3, color=BEFORE, lw=0.8, label="if it followed")
        lag, band = (one.value for one in found.measured[:2])
        axis.set(
            xlabel="command / mrad",
            ylabel="position / mrad",
            title=f"{run}: lag {lag * 1e3:.0f} ms, dead band {band * 1e3:.0f} mrad",
        )
        axis.title.set_fontsize(9)
        axis.legend(frameon=False)
    figure.savefig(out / "sage.png", dpi=110)


if __name__ == "__main__":
    if len(sys.argv) != 3 or not Path(sys.argv[1]).is_dir():
        sys.exit(__doc__)
    target = Path(sys.argv[2])
    target.mkdir(parents=True, exist_ok=True)
    for draw in (emps, emps_law, laas, sage):
        draw(Path(sys.argv[1]), target)
