"""Worker processes that end with the work they were started for."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from joblib.externals.loky import get_reusable_executor


@contextmanager
def ended_together(*, when_done: bool = True) -> Iterator[None]:
    """However the block ends, by SIGTERM and Ctrl-C too, its worker processes are ended.

    when_done: also where it ends as it should; otherwise they are kept for what comes next.
    """
    done = False
    main = threading.current_thread() is threading.main_thread()
    before: Any = signal.signal(signal.SIGTERM, signal.default_int_handler) if main else None
    try:
        yield
        done = True
    finally:
        if when_done or not done:
            get_reusable_executor(reuse=True).shutdown(wait=True, kill_workers=True)
        if main:
            signal.signal(signal.SIGTERM, before)
