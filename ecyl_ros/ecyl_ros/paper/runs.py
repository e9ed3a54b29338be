"""Every closed-loop run that the pages need, side by side on all cores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..analysis.bench.table1 import table_1_drive
from ..analysis.emd import decompose
from ..analysis.parallel import over
from ..analysis.spectrum import Line, amplitude_spectrum, dominant_lines, line_at
from ..analysis.tracking import TrackingAnalysis, analyse
from ..drive.engine import simulate
from ..drive.packed import choose_substeps
from ..drive.parameters import DriveParameters, PositionGains
from ..drive.plant import LOAD_ANGLE, initial_state
from ..drive.reference.spec import make_reference
from ..drive.telemetry import simulation_recording
from . import published
from .readings import (
    DAMPING,
    Reading,
    with_clearance,
    with_controller,
    with_stiffness,
    with_transmission,
)

DURATION_S = 20.0
ROD_DURATION_S = 5.0  # closed on the rod, when it is soon over or soon the same for ever
CLEARANCE_SHARES = (0.5, 0.75, 1.0, 1.25, 1.5)
# Where in its half clearance the load starts. At rest in the middle, as the paper's model; the
# others show how much of a figure is the start's.
STARTS = (0.0, -0.9, -0.3, 0.5, 0.9, -0.6, 0.2, 0.7)
SUBSTEPS = (1, 2, 4)
LOST_M = 1e-3  # an error beyond it, fifty times the reference, is no control


@dataclass(frozen=True)
class Case:
    """One run. `key` is its name: (reading, what was changed, to what, number of the start)."""

    key: tuple[str, str, float, int]
    drive: DriveParameters
    duration_s: float = DURATION_S
    start: float = 0.0
    substeps: int = 1  # times the automatic choice


@dataclass(frozen=True)
class Mode:
    """One IMF without its signal; see `analysis.emd.Imf`."""

    frequency_hz: float
    hilbert_hz: float
    amplitude_m: float
    std_m: float
    mixed: float
    edge_change: float


@dataclass(frozen=True)
class Ran:
    """What one run gave; the first half of it is not judged.

    Attributes:
        error_std_m, lag_s: of the error; lag NaN where there is none.
        imfs: modes of the error.
        line_1hz_m: amplitude of the error at the reference's frequency.
        error_line, relative_line: strongest line of the error, m, and of the relative angle, rad.
        similarity: correlation of IMF1 with the relative angle.
        peak_torque_nm: largest transmitted.
        lost_s: when the error passed 1 mm; None where it did not.
        analysis: signals and all, of the runs from rest; None of the others.
    """

    error_std_m: float
    lag_s: float
    imfs: tuple[Mode, ...]
    line_1hz_m: float
    error_line: Line | None
    relative_line: Line | None
    similarity: float
    peak_torque_nm: float
    lost_s: float | None
    analysis: TrackingAnalysis | None


def cases(readings: Sequence[Reading], starts: int) -> list[Case]:
    """The servo runs of Fig. 10 to 16 and Table 3, and those of what the paper leaves open."""
    found = []
    for reading in readings:
        for change, shares, changed in (
            ("stiffness", published.STIFFNESS_SHARES, with_stiffness),
            ("clearance", CLEARANCE_SHARES, with_clearance),
        ):
            for share in shares:
                if change == "clearance" and share == 1.0:
                    continue  # there already
                for number, start in enumerate(STARTS[:starts]):
                    key = (reading.key, change, share, number)
                    found.append(Case(key, changed(reading.drive, share), start=start))
    for reading in readings:
        if reading.key != "damped":
            found += _open_cases(reading)
    measured = table_1_drive()
    found.append(Case(("measured", "form", 0.0, 0), measured))
    return found


def _open_cases(reading: Reading) -> list[Case]:
    drive, key = reading.drive, reading.key
    per_metre = drive.transmission.rod_per_rotor
    position = drive.controller.position
    metre = PositionGains(kp=position.kp * per_metre, ki=position.ki * per_metre)
    rod = with_controller(drive, feedback="rod")
    series = with_controller(drive, form="series")
    found = [
        Case((key, "rod", 0.0, 0), rod, duration_s=ROD_DURATION_S),
        Case((key, "series", 0.0, 0), series),
        Case((key, "series", DAMPING, 0), with_transmission(series, contact_damping=DAMPING)),
        Case((key, "kp", 18.0, 0), with_controller(drive, position=replace(position, kp=18.0))),
        Case((key, "metre", 0.0, 0), with_controller(drive, position=metre)),
    ]
    found += [
        Case((key, "substeps", float(factor), 0), drive, substeps=factor) for factor in SUBSTEPS
    ]
    return found


def run_all(
    todo: Sequence[Case],
    *,
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> dict[tuple[str, str, float, int], Ran]:
    """Results by key; see `parallel.over`."""
    done = over(run_case, todo, jobs=jobs, progress=progress)
    return {case.key: ran for case, ran in zip(todo, done, strict=True)}


def run_case(case: Case) -> Ran:
    """Simulate and judge one case. An unstable loop is run as it is, until it is lost."""
    drive = case.drive
    reference = make_reference(published.REFERENCE, drive, case.duration_s)
    state = initial_state()
    state[LOAD_ANGLE] = case.start * 0.5 * drive.transmission.backlash
    rate = drive.sample_rate
    run = simulate(
        drive,
        lambda index: reference.sample(index / rate),
        case.duration_s,
        initial=state,
        substeps=case.substeps * choose_substeps(drive),
    )
    recording = simulation_recording(run, drive)
    error = recording.reference_position_m - recording.rod_position_m
    beyond = np.flatnonzero(~(np.abs(error) < LOST_M))
    if beyond.size:
        return _lost(float(recording.time_s[beyond[0]]))
    analysis = analyse(recording, 0.5 * case.duration_s)
    torque = run.signal("transmitted_torque_nm")[len(run.samples) // 2 :]
    relative = analysis.relative_angle_rad
    assert relative is not None  # the engine gives the load's angle
    lines = dominant_lines(amplitude_spectrum(relative, analysis.rate_hz), count=1)
    keep = case.key[3] == 0 and case.key[1] in ("stiffness", "clearance")
    short = case.duration_s < DURATION_S
    return Ran(
        error_std_m=analysis.error_std_m,
        lag_s=analysis.lag.lag_s,
        imfs=tuple(
            Mode(
                one.frequency_hz,
                one.hilbert_frequency_hz,
                one.amplitude,
                one.std,
                one.mixed,
                one.edge_change,
            )
            for one in analysis.emd.imfs
        ),
        line_1hz_m=(
            float("nan")
            if short
            else line_at(analysis.error_m, analysis.rate_hz, published.REFERENCE_HZ).amplitude
        ),
        error_line=analysis.lines[0] if analysis.lines else None,
        relative_line=lines[0] if lines else None,
        similarity=_similarity(analysis, relative),
        peak_torque_nm=float(np.abs(torque).max()),
        lost_s=None,
        analysis=analysis if keep else None,
    )


def _similarity(analysis: TrackingAnalysis, relative: np.ndarray) -> float:
    """Correlation of IMF1 with the relative angle, low-passed and thinned out as the error was."""
    if not analysis.emd.imfs:
        return float("nan")
    same = decompose(relative, analysis.rate_hz, analysis.emd.settings)
    smooth = same.residue + sum(one.values for one in same.imfs)
    return float(np.corrcoef(smooth, analysis.emd.imfs[0].values)[0, 1])


def _lost(when_s: float) -> Ran:
    nan = float("nan")
    return Ran(nan, nan, (), nan, None, None, nan, nan, when_s, None)
