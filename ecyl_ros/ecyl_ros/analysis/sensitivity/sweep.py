"""A sweep: one closed-loop run per point, judged as `ecyl analyse` does."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...drive.drive_file import drive_from_flat
from ...drive.engine import simulate
from ...drive.reference.setpoint import SetpointFollower
from ...drive.reference.spec import make_reference
from ...drive.stability import check_stability
from ...drive.telemetry import simulation_recording
from ...errors import InputError
from ..parallel import over
from ..report import as_json
from ..tracking import TrackingAnalysis, analyse
from .vary import Point

KEPT = ("error_std_m", "error_rms_m", "error_max_m", "lag_s", "gain", "spectrum", "imfs")


@dataclass(frozen=True)
class Experiment:
    """What every drive of a sweep has to do: follow `reference` (a SPEC) for `duration_s`; the
    first `skip_s` are not judged."""

    reference: str = "sine:amplitude=2e-5,frequency=1"
    duration_s: float = 20.0
    skip_s: float = 10.0


@dataclass(frozen=True)
class Outcome:
    """Figures of one point, named as in the JSON of `ecyl analyse`; None with the reason in
    `error` where the drive cannot run."""

    figures: Mapping[str, Any] | None
    error: str | None = None


def run_drive(flat: Mapping[str, Any], experiment: Experiment, source: str) -> TrackingAnalysis:
    """Simulate a drive given by its flat parameters, and analyse it.

    Raises:
        InputError: an unstable drive, a reference it may not follow, or nothing left to judge.
    """
    drive = drive_from_flat(flat, source)
    check_stability(drive, source)
    reference = make_reference(experiment.reference, drive, experiment.duration_s)
    if isinstance(reference, SetpointFollower):
        raise InputError("--reference setpoint needs the node graph; expected another")
    rate = drive.sample_rate
    run = simulate(drive, lambda index: reference.sample(index / rate), experiment.duration_s)
    return analyse(simulation_recording(run, drive), experiment.skip_s)


def sweep(
    points: Sequence[Point],
    experiment: Experiment,
    source: str,
    *,
    jobs: int | None = None,
    dask: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Outcome]:
    """Outcomes in the order of `points`; see `parallel.over`."""
    tasks = [(dict(point.flat), experiment, source) for point in points]
    return over(_outcome, tasks, jobs=jobs, dask=dask, progress=progress)


def _outcome(task: tuple[Mapping[str, Any], Experiment, str]) -> Outcome:
    try:
        figures = as_json(run_drive(*task))
    except InputError as error:
        return Outcome(None, str(error))
    return Outcome({name: figures[name] for name in KEPT})
