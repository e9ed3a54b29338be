"""The study loop: record each case's machine, diagnose it without its label, keep what was said."""

from __future__ import annotations

import json
import signal
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any

from ...errors import InputError
from ...recording.signals import Recording
from .case import Case
from .drives import Drives
from .subject import Sheet, Subject
from .workers import WorkerDied, in_processes

FIRST = "the first alone"  # of several recordings, as a baseline
LIMIT_S = 600.0  # a diagnosis that takes longer counts as failed


class StudyError(Exception):
    """The study could not go on; what was said until then is with the caller."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise TimeoutError in the block after `seconds`, where the platform and thread allow it."""
    main = threading.current_thread() is threading.main_thread()
    if not (main and hasattr(signal, "setitimer")):
        yield
        return

    def late(number: int, frame: Any) -> None:
        raise TimeoutError(f"no answer within {seconds:g} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@dataclass(frozen=True)
class Outcome:
    """What was said of one case.

    Attributes:
        index: of the case.
        diagnosis: as in section 4 of the contract; None where it failed.
        error: why it failed, one line; None where it did not.
        seconds: the diagnosis took.
        baselines: by name, {"named": [effect, ...], "seconds": s}; empty where none ran.
    """

    index: int
    diagnosis: dict[str, Any] | None
    error: str | None
    seconds: float
    baselines: dict[str, dict[str, Any]] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """Plain data; `Outcome(**data)` is the way back."""
        return asdict(self)

    @property
    def causes(self) -> list[dict[str, Any]]:
        """The causes named, in the order listed."""
        return list(self.diagnosis["causes"]) if self.diagnosis else []

    @property
    def named(self) -> list[str]:
        """Their effects."""
        return [cause["effect"] for cause in self.causes]


def examine(case: Case, drives: Drives, subject: Subject, baselines: bool) -> Outcome:
    """Record the case and have it diagnosed; a diagnosis that raises is an outcome, too.

    The subject sees the recording, the machine's sheet and what it must leave out, nothing else;
    of a case of several recordings, all of them. The first alone is then a baseline.
    """
    recording, drive, more = drives.given(case)
    said, error = None, None
    begin = time.perf_counter()
    try:
        with time_limit(LIMIT_S):
            every = (recording, *more) if more else recording
            said = subject(every, drive, frozenset(case.withheld))
        said = json.loads(json.dumps(said, allow_nan=False))  # what cannot be written is no answer
        _check(said)
    except Exception as failure:  # whatever it is, it must not end the study
        last = traceback.extract_tb(failure.__traceback__)[-1]
        place = f"{last.filename.rsplit('/', 1)[-1]}:{last.lineno}"
        said, error = None, f"{type(failure).__name__} at {place}: {failure}"
    seconds = time.perf_counter() - begin
    others = {}
    for name, baseline in drives.baselines.items() if baselines and not more else ():
        begin = time.perf_counter()
        named = baseline(recording, drive)
        others[name] = {"named": named, "seconds": time.perf_counter() - begin}
    if baselines and more:
        begin = time.perf_counter()
        named = _named_alone(recording, drive, subject, case)
        others[FIRST] = {"named": named, "seconds": time.perf_counter() - begin}
    return Outcome(case.index, said, error, seconds, others)


def _named_alone(recording: Recording, drive: Sheet, subject: Subject, case: Case) -> list[str]:
    """What is named on the first of several recordings; nothing where it cannot be judged."""
    try:
        said = subject(recording, drive, frozenset(case.withheld))
    except InputError:
        return []
    return [cause["effect"] for cause in said["causes"]]


def _check(said: dict[str, Any]) -> None:
    """Raise ValueError where a diagnosis lacks what is scored."""
    for key in ("verdict", "location", "causes", "gap"):
        if key not in said:
            raise ValueError(f"the diagnosis has no {key!r}")
    for cause in said["causes"]:
        for key in ("effect", "confidence", "parameters"):
            if key not in cause:
                raise ValueError(f"a cause has no {key!r}")


def run_study(
    cases: Sequence[Case],
    drives: Drives,
    subject: Subject,
    *,
    baselines: bool = True,
    workers: int = 2,
    dask: str | None = None,
    on_outcome: Callable[[Outcome], None] | None = None,
) -> list[Outcome]:
    """Examine all cases in `workers` processes; outcomes in the order of the cases.

    dask: see `workers.in_processes`. on_outcome: called with each outcome as it comes, in any
    order. Raises StudyError if a worker is killed.
    """
    examined = partial(examine, drives=drives, subject=subject, baselines=baselines)
    outcomes: dict[int, Outcome] = {}
    try:
        for outcome in in_processes(examined, cases, workers, dask):
            outcomes[outcome.index] = outcome
            if on_outcome is not None:
                on_outcome(outcome)
    except WorkerDied:
        missing = [str(case.index) for case in cases if case.index not in outcomes]
        raise StudyError(
            f"a worker process died at one of the cases {', '.join(missing[: 2 * workers])}"
        ) from None
    return [outcomes[case.index] for case in cases]
