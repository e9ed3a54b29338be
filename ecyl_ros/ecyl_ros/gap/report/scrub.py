"""The diagnosis as an MCAP file: what was recorded, what the models give, what is left, and when.

Standard messages on one topic per curve, at the recording's own stamps, so that Foxglove,
PlotJuggler and `ros2 bag play` scrub through it beside the recording.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...recording.atomic import replacing
from ...recording.messages import typestore
from ...recording.topics import TopicSpec
from ...recording.writer import RecordingWriter
from ..diagnosis import Diagnosis
from . import quantities, words
from .verdict import sentence

ROOT = "/ecyl/diagnosis"
REFERENCE = f"{ROOT}/reference"
MISFIT = f"{ROOT}/misfit"
HELD_OUT = f"{ROOT}/held_out"
EVENTS = f"{ROOT}/events"
SUMMARY = f"{ROOT}/summary"
CURVES = ("recorded", "before", "after", "residual_before", "residual_after")
FLOAT64, BOOL = "std_msgs/msg/Float64", "std_msgs/msg/Bool"
LOG, DIAGNOSTICS = "rcl_interfaces/msg/Log", "diagnostic_msgs/msg/DiagnosticArray"

WINDOW_S = 0.1  # of the running misfit
_MOST_EVENTS = 20  # stretches in which the gap is largest
_LOUD = 3.0  # floors, from which on a stretch is an event
_INFO, _WARN = 20, 30
_CDR = b"\0\1\0\0"


def topic(signal: str, curve: str) -> str:
    """Topic of one curve of a signal; see `CURVES`."""
    return f"{ROOT}/{signal}/{curve}"


def write_scrub(diagnosis: Diagnosis, path: str | Path) -> None:
    """Write the file, whole or not at all.

    Topics, all below `/ecyl/diagnosis`: `SIGNAL/recorded`, `SIGNAL/before` and `SIGNAL/after`
    (simulated with the nominal model, and with the causes), `SIGNAL/residual_before` and
    `SIGNAL/residual_after` (recorded minus simulated), in SI units; `reference`; `misfit/before`
    and `misfit/after`, the RMS of all residuals over their noise floors within 0.1 s; `held_out`,
    whether a sample was kept from the fit; `events`, a log of where the gap is largest and what
    was not judged; `summary`, verdict and causes.

    Raises:
        InputError: the file cannot be written.
    """
    series = diagnosis.series
    stamps = series.start_ns + np.round(series.time_s * 1e9).astype(np.int64)
    curves = _curves(diagnosis)
    specs = [_spec(name, FLOAT64) for name in curves]
    specs += [_spec(HELD_OUT, BOOL), _spec(EVENTS, LOG), _spec(SUMMARY, DIAGNOSTICS)]
    events = sorted(_events(diagnosis, stamps, curves), key=lambda one: one[0])
    with (
        replacing(path) as temporary,
        RecordingWriter(temporary, topics=specs, overwrite=True) as writer,
    ):
        first = int(stamps[0])
        writer.write(SUMMARY, _summary(diagnosis, first), first)
        waiting = 0
        for i, stamp in enumerate(stamps.tolist()):
            while waiting < len(events) and events[waiting][0] <= stamp:
                at, level, text = events[waiting]
                writer.write(EVENTS, _log(at, level, text), at)
                waiting += 1
            for name, values in curves.items():
                value = values[i]
                if value == value:
                    writer.write(name, _CDR + struct.pack("<d", value), stamp)
            held = bool(series.held_out[i])
            if i == 0 or held != bool(series.held_out[i - 1]):
                writer.write(HELD_OUT, _CDR + struct.pack("<?", held), stamp)


def _spec(name: str, kind: str) -> TopicSpec:
    return TopicSpec(key=name, name=name, type=kind, frame_id="")


def _curves(diagnosis: Diagnosis) -> dict[str, FloatArray]:
    """Topic -> float64[n]."""
    series = diagnosis.series
    curves: dict[str, FloatArray] = {REFERENCE: series.reference_m}
    left: dict[str, list[FloatArray]] = {"before": [], "after": []}
    for row, signal in enumerate(diagnosis.signals):
        recorded = series.recorded[row]
        values = {"recorded": recorded}
        for which, simulated in (("before", series.before[row]), ("after", series.after[row])):
            values[which] = simulated
            residual = recorded - simulated
            values[f"residual_{which}"] = residual
            judged = np.where(series.usable, residual, np.nan)
            left[which].append(judged / max(signal.floor, 1e-300))
        curves.update({topic(signal.name, curve): values[curve] for curve in CURVES})
    for which, parts in left.items():
        curves[f"{MISFIT}/{which}"] = _running_rms(series.time_s, np.array(parts))
    return curves


def _running_rms(time_s: FloatArray, ratios: FloatArray) -> FloatArray:
    """RMS over all signals of the last `WINDOW_S`, NaN where nothing was judged within."""
    known = np.isfinite(ratios)
    summed = (np.where(known, ratios, 0.0) ** 2).sum(axis=0)
    squares = np.concatenate([[0.0], np.cumsum(summed)])
    counts = np.concatenate([[0], np.cumsum(known.sum(axis=0))])
    begins = np.searchsorted(time_s, time_s - WINDOW_S)
    ends = np.arange(1, time_s.size + 1)
    held = counts[ends] - counts[begins]
    with np.errstate(invalid="ignore", divide="ignore"):
        rms = np.sqrt(np.maximum(squares[ends] - squares[begins], 0.0) / held)
    return np.where(held > 0, rms, np.nan)


def _events(
    diagnosis: Diagnosis, stamps: NDArray[np.int64], curves: dict[str, FloatArray]
) -> Iterator[tuple[int, int, str]]:
    """Stamp, level and text of what is worth a look."""
    series = diagnosis.series
    yield int(stamps[0]), _INFO, sentence(diagnosis)
    edges = np.flatnonzero(np.diff(series.usable.astype(np.int8))) + 1
    if not series.usable[0]:
        yield int(stamps[0]), _INFO, "not judged from here: the replay is settling"
    for edge in edges.tolist():
        text = "judged from here" if series.usable[edge] else "not judged from here: no samples"
        yield int(stamps[edge]), _INFO, text
    misfit = curves[f"{MISFIT}/before"]
    window = np.floor(series.time_s / WINDOW_S).astype(np.int64)
    # The last sample of a window holds the RMS of just that window.
    last = np.append(np.flatnonzero(np.diff(window)), window.size - 1)
    loud = [i for i in last.tolist() if misfit[i] > _LOUD]
    after = curves[f"{MISFIT}/after"]
    for i in sorted(loud, key=lambda one: -misfit[one])[:_MOST_EVENTS]:
        rows = window == window[i]
        worst = max(
            diagnosis.signals,
            key=lambda one: _rms(curves[topic(one.name, "residual_before")][rows]) / one.floor,
        )
        text = (
            f"gap of {misfit[i]:.1f} noise floors within {WINDOW_S:g} s, most in "
            f"{words.signal(worst.name)}"
        )
        if diagnosis.added:
            text += f"; {after[i]:.1f} with the {diagnosis.added}"
        yield int(stamps[i]), _WARN, text


def _rms(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else 0.0


def _stamp(stamp_ns: int) -> Any:
    time = typestore().types["builtin_interfaces/msg/Time"]
    return time(sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)


def _log(stamp_ns: int, level: int, text: str) -> bytes:
    message = typestore().types[LOG](
        stamp=_stamp(stamp_ns),
        level=level,
        name="ecyl diagnose",
        msg=text,
        file="",
        function="",
        line=0,
    )
    return bytes(typestore().serialize_cdr(message, LOG))


def _summary(diagnosis: Diagnosis, stamp_ns: int) -> bytes:
    """Verdict and causes, a status each; the level is a warning where something is left."""
    types = typestore().types
    pair = types["diagnostic_msgs/msg/KeyValue"]
    status = types["diagnostic_msgs/msg/DiagnosticStatus"]

    def values(pairs: dict[str, str]) -> list[Any]:
        return [pair(key=key, value=value) for key, value in pairs.items()]

    parts = [
        status(
            level=0 if diagnosis.verdict in ("no_gap", "explained") else 1,
            name="verdict",
            message=sentence(diagnosis),
            hardware_id=Path(diagnosis.drive).stem,
            values=values(
                {
                    "verdict": diagnosis.verdict,
                    "block": diagnosis.block or "none",
                    "gap before": f"{diagnosis.before:.6g}",
                    "gap after": f"{diagnosis.after:.6g}",
                    "floor": f"{diagnosis.floor:.6g}",
                    "shrink": f"{diagnosis.shrink:.4f}",
                }
            ),
        )
    ]
    for cause in diagnosis.causes:
        fitted = {}
        for one in cause.parameters:
            value, low, high, unit = quantities.interval(one)
            fitted[one.name] = f"{quantities.joined(value, unit)} ({low} to {high})"
        parts.append(
            status(
                level=1,
                name=cause.effect,
                message=words.heading(cause.effect),
                hardware_id=Path(diagnosis.drive).stem,
                values=values({"confidence": f"{cause.confidence:.2f}", **fitted}),
            )
        )
    header = types["std_msgs/msg/Header"](stamp=_stamp(stamp_ns), frame_id="")
    message = types[DIAGNOSTICS](header=header, status=parts)
    return bytes(typestore().serialize_cdr(message, DIAGNOSTICS))
