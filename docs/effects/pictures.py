"""The pictures of the effect pages: `python docs/effects/pictures.py [NAME ...]`, all unless named.

Each effect is put into the bench drive at the size in examples.py and recorded as `ecyl simulate`
records; the nominal model is replayed beside it, as in a diagnosis. Dark: the healthy drive.
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from examples import EXAMPLES, faulty_and_nominal, record
from matplotlib.axes import Axes
from panels import LEFT, OVER, SPECTRUM, TRACES, Run
from PIL import Image

from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.gap.replay.evidence import Smoother, gather
from ecyl_ros.gap.replay.replay import SIGNALS, Replay
from ecyl_ros.recording.atomic import replacing
from ecyl_ros.recording.signals import Recording

plt.rcParams["axes.labelsize"] = 9

HERE = Path(__file__).parent
HEALTHY, FAULTY = "#4a525c", "#e07a4f"
COLOURS = 48  # in a palette of its own: a quarter of the size


def watch(recording: Recording, nominal: DriveParameters) -> Run:
    """Replay the nominal drive beside a recording."""
    replay = Replay(recording, nominal, "recording")
    columns = replay.full({})
    evidence = gather(replay, {})
    smooth, motor = Smoother(evidence.time_s), evidence.drive.motor
    current = evidence.current_a
    rest = smooth(evidence.voltage_v) - motor.resistance * smooth(current)
    rest -= motor.inductance * smooth(current, 1)
    rest -= motor.back_emf_constant * smooth(evidence.rotor_speed_rad_s)
    return Run(recording, evidence, {one.name: columns[one.column] for one in SIGNALS}, rest)


def runs_of(name: str) -> tuple[Run, Run]:
    """(healthy, with the effect), each with noise of its own."""
    faulty, nominal = faulty_and_nominal(name)
    example = EXAMPLES[name]
    return watch(record(nominal, example), nominal), watch(record(faulty, example), nominal)


def _spectrum(axis: Axes, run: Run, left: str, colour: str, highest_hz: float) -> None:
    label, values = LEFT[left]
    gap = np.nan_to_num(values(run))
    size = 2.0 * np.abs(np.fft.rfft((gap - gap.mean()) * np.hanning(len(gap)))) / (0.5 * len(gap))
    rate = 1.0 / np.median(np.diff(run.evidence.time_s))
    frequency = np.fft.rfftfreq(len(gap), 1.0 / rate)
    part = frequency <= highest_hz
    axis.plot(frequency[part], size[part], color=colour, lw=1.0)
    axis.set(
        xlabel="frequency / Hz",
        ylabel=label.replace(" /", ", amplitude /"),
        ylim=(0, None),
    )


def draw(name: str) -> bytes:
    """The picture of one effect as PNG."""
    example = EXAMPLES[name]
    healthy, faulty = runs_of(name)
    styles = (
        (faulty, {"color": FAULTY, "lw": 1.5, "label": "with the effect"}),
        (healthy, {"color": HEALTHY, "lw": 0.8, "label": "healthy"}),
    )
    figure, axes = plt.subplots(1, 3, figsize=(10.2, 3.0), constrained_layout=True)
    first, last = example.zoom
    for axis, trace in zip(axes, example.traces, strict=False):
        label, signal = TRACES[trace]
        for run, style in styles:
            time = run.recording.time_s
            part = (time >= first) & (time <= last)
            axis.plot(time[part], signal(run)[part], **style)
        axis.set(xlabel="time / s", ylabel=label, xlim=example.zoom)
    left, over = example.against
    for run, style in styles:
        if over == SPECTRUM:
            _spectrum(axes[2], run, left, style["color"], example.highest_hz)
            continue
        (y_label, y), (x_label, x) = LEFT[left], OVER[over]
        axes[2].plot(x(run), y(run), ".", ms=1.6, color=style["color"])
        axes[2].set(xlabel=x_label, ylabel=y_label)
    lines, names = axes[0].get_legend_handles_labels()
    figure.legend(lines, names, frameon=False, ncols=2, loc="outside upper left")
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
        axis.grid(alpha=0.25)
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=80)
    plt.close(figure)
    small = io.BytesIO()
    picture = Image.open(buffer).convert("RGB").quantize(COLOURS)
    picture.save(small, "PNG", optimize=True)
    return small.getvalue()


if __name__ == "__main__":
    names = sys.argv[1:] or list(EXAMPLES)
    for unknown in sorted(set(names) - set(EXAMPLES)):
        sys.exit(f"no effect called {unknown}; expected some of {', '.join(EXAMPLES)}")
    for one in names:
        data = draw(one)
        with replacing(HERE / f"{one}.png") as path:
            path.write_bytes(data)
        print(f"{one}.png  {len(data) / 1e3:.1f} kB", flush=True)
