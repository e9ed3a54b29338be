"""Work spread over processes; `analysis.ended_together` ends them with the study."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from joblib import Parallel, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError

from ...analysis.parallel import backend, lost_on_cluster

Item = TypeVar("Item")
Result = TypeVar("Result")


class WorkerDied(Exception):
    """A worker process was killed, or ran out of memory."""


def in_processes(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    workers: int,
    dask: str | None = None,
) -> Iterator[Result]:
    """Results in any order as they come; with one worker in this process, one after another.

    dask: address of a Dask scheduler that is to do it instead.

    Raises WorkerDied if a worker is killed, InputError if no scheduler answers.
    """
    if not items:
        return
    with backend(dask, min(workers, len(items))) as chosen:
        spread = Parallel(return_as="generator_unordered", **chosen)
        try:
            with warnings.catch_warnings():
                # A worker whose memory has grown is replaced in between: nothing to warn users of.
                warnings.filterwarnings("ignore", message="A worker stopped while some jobs")
                yield from spread(delayed(function)(item) for item in items)
        except TerminatedWorkerError as error:
            raise WorkerDied(str(error).splitlines()[0]) from None
        except lost_on_cluster(dask) as error:
            raise WorkerDied(f"{dask}: the cluster failed: {type(error).__name__}") from None
