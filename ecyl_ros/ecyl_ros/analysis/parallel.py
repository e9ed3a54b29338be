"""One function over many arguments: on this machine's cores, or on a Dask cluster."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from typing import Any, TypeVar

from joblib import Parallel, cpu_count, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from ..errors import InputError
from .ended_together import ended_together
from .one_thread import on_one_thread

Argument = TypeVar("Argument")
Result = TypeVar("Result")

CONNECT_S = 10.0
_CORES = "LOKY_MAX_CPU_COUNT"  # by which joblib counts a process's cores
# M_TRIM_THRESHOLD and M_MMAP_THRESHOLD of the GNU C library, at what they grow to by themselves.
_KEPT = ((-1, 64 * 2**20), (-3, 32 * 2**20))


class WorkerError(Exception):
    """A worker was lost; the message is one line."""


def cores() -> int:
    """Processor cores this process may use."""
    return int(cpu_count())


def over(
    function: Callable[[Argument], Result],
    arguments: Sequence[Argument],
    *,
    jobs: int | None = None,
    dask: str | None = None,
    progress: Callable[[float], None] | None = None,
    each: Callable[[Result], None] | None = None,
) -> list[Result]:
    """`[function(one) for one in arguments]`, side by side.

    Every call runs with one thread of linear algebra, wherever it runs: sums then have one order,
    and results are the same to the last bit on one core, on all, and on a cluster.

    Args:
        function: defined at the top of a module; arguments and results can be pickled.
        arguments: one per call.
        jobs: processes; all cores unless given. 1 stays in this process. Not used with `dask`.
        dask: address of a Dask scheduler, `tcp://host:port`, whose workers have this package.
        progress: called with the share done.
        each: called here with every result as it comes, in any order; none is kept then.

    Raises:
        InputError: no scheduler answers, or Dask is not installed.
        WorkerError: a worker process died.
    """
    results: list[Any] = [None] * len(arguments)
    done = 0
    with backend(dask, min(jobs or cores(), max(1, len(arguments)))) as chosen:
        tasks = (delayed(_call)(function, index, one) for index, one in enumerate(arguments))
        try:
            for index, result in Parallel(return_as="generator_unordered", **chosen)(tasks):
                done += 1
                if each is None:
                    results[index] = result
                else:
                    each(result)
                if progress is not None:
                    progress(done / len(arguments))
        except TerminatedWorkerError:
            raise WorkerError(
                f"a worker process died after {done} of {len(arguments)} runs; out of memory?"
            ) from None
        except lost_on_cluster(dask) as error:
            raise WorkerError(
                f"{dask}: the cluster failed after {done} of {len(arguments)} runs: "
                f"{type(error).__name__}"
            ) from None
    return results


@on_one_thread
def _call(function: Callable[[Any], Any], index: int, argument: Any) -> tuple[int, Any]:
    return index, function(argument)


@contextmanager
def backend(dask: str | None, jobs: int) -> Iterator[dict[str, Any]]:
    """What `joblib.Parallel` takes to run on so many cores, or on a cluster; see `over`."""
    if dask is None:
        with ended_together(when_done=False) if jobs > 1 else nullcontext(), _shared_out(jobs):
            yield {"n_jobs": jobs}
        return
    try:
        from distributed import Client
    except ImportError:
        raise InputError(
            "--dask needs dask.distributed, which is not installed; pip install 'dask[distributed]'"
        ) from None
    try:
        client = Client(dask, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TypeError):
        raise InputError(
            f"--dask {dask}: no scheduler answers, expected tcp://HOST:PORT of a running one"
        ) from None
    with client:
        if not client.ncores():
            raise InputError(f"--dask {dask}: the scheduler has no workers, expected one or more")
        client.run(_prepared)
        with parallel_config(backend="dask", client=client):
            yield {"n_jobs": -1}


@contextmanager
def _shared_out(jobs: int) -> Iterator[None]:
    """Processes started within see their share of this one's cores as theirs.

    Each would have threads for all of them else, which only get in each other's way.
    """
    before = os.environ.get(_CORES)
    if jobs > 1:
        os.environ[_CORES] = str(max(1, cores() // jobs))
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(_CORES, None)
        else:
            os.environ[_CORES] = before


def _prepared() -> None:
    """In a worker of a cluster, which runs as many calls at a time as it has threads."""
    os.environ[_CORES] = "1"
    _keep_freed_memory()


def _keep_freed_memory() -> None:
    """Have arrays made of memory that others have left, as a process of its own does.

    Dask starts its workers such that they hand back whatever is freed; where arrays of some 100 kB
    come and go by the thousand, getting it again takes several per cent of the time.
    """
    try:
        set_option = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return  # another C library, with ways of its own
    for option, size in _KEPT:
        set_option(option, size)


def lost_on_cluster(dask: str | None) -> tuple[type[BaseException], ...]:
    """What is raised where a cluster loses its workers."""
    if dask is None:
        return ()
    from distributed import KilledWorker
    from distributed.comm import CommClosedError

    return (KilledWorker, CommClosedError)
