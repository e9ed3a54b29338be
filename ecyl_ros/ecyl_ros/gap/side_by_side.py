"""Work done side by side on all cores, from within such work, too.

Whoever asks does its share: it takes jobs from its own list as the other threads do, so that a fit
among several fits may have its replays done side by side, and no thread waits for one that waits.
Results do not depend on who does what.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Generic, TypeVar

from ..analysis.parallel import cores

Job = TypeVar("Job")
Found = TypeVar("Found")

_pool: ThreadPoolExecutor | None = None
_making = threading.Lock()


def side_by_side(work: Callable[[Job], Found], jobs: Iterable[Job]) -> list[Found]:
    """What `work` makes of each job, in their order; raises what the first that fails raises."""
    batch = _Batch(work, list(jobs))
    others = min(_others(), len(batch.jobs) - 1)
    helpers = [_threads().submit(batch.do) for _ in range(others)]
    try:
        batch.do()
    finally:
        batch.end()
        for one in helpers:
            if not one.cancel():
                one.result()
    return batch.results()


class _Batch(Generic[Job, Found]):
    """Jobs of one call, and what came of them."""

    def __init__(self, work: Callable[[Job], Found], jobs: list[Job]) -> None:
        self.jobs = jobs
        self._work = work
        self._found: dict[int, Found] = {}
        self._failed: dict[int, Exception] = {}
        self._lock = threading.Lock()
        self._next = 0

    def do(self) -> None:
        """Do jobs until none is left."""
        while True:
            with self._lock:
                index = self._next
                self._next += 1
            if index >= len(self.jobs):
                return
            try:
                self._found[index] = self._work(self.jobs[index])
            except Exception as error:  # raised again where the results are asked for
                self._failed[index] = error
                self.end()

    def end(self) -> None:
        """Begin no further job."""
        with self._lock:
            self._next = len(self.jobs)

    def results(self) -> list[Found]:
        """In the order of the jobs."""
        if self._failed:
            raise self._failed[min(self._failed)]
        return [self._found[index] for index in range(len(self.jobs))]


def _others() -> int:
    return cores() - 1


def _threads() -> ThreadPoolExecutor:
    """Those beside the one that asks; made when they are first needed."""
    global _pool
    with _making:
        if _pool is None:
            _pool = ThreadPoolExecutor(_others(), thread_name_prefix="side_by_side")
        return _pool


def _forget() -> None:
    """In a forked process, where the threads are not."""
    global _pool, _making
    _pool, _making = None, threading.Lock()


os.register_at_fork(after_in_child=_forget)
