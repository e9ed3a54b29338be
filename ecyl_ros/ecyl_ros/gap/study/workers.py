"""Work spread over processes; `analysis.ended_together` ends them with the study."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from joblib import Parallel, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError

Item = TypeVar("Item")
Result = TypeVar("Result")


class WorkerDied(Exception):
    """A worker process was killed, or ran out of memory."""


def in_processes(
    function: Callable[[Item], Result], items: Sequence[Item], workers: int
) -> Iterator[Result]:
    """Results in any order as they come; with one worker in this process, one after another.

    Raises WorkerDied if a worker is killed.
    """
    if not items:
        return
    spread = Parallel(n_jobs=min(workers, len(items)), return_as="generator_unordered")
    try:
        with warnings.catch_warnings():
            # A worker whose memory has grown is replaced in between: nothing to warn users of.
            warnings.filterwarnings("ignore", message="A worker stopped while some jobs")
            yield from spread(delayed(function)(item) for item in items)
    except TerminatedWorkerError as error:
        raise WorkerDied(str(error).splitlines()[0]) from None
