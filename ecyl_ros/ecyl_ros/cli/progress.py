"""A progress bar on a terminal; in a pipe or a log a line now and then."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_EVERY_S = 60.0  # a line in a log: what is over sooner writes none


@contextmanager
def progress_bar(title: str) -> Iterator[Callable[[float], None]]:
    """Yield a function that takes the share done, 0 to 1."""
    if not sys.stderr.isatty():
        yield _in_lines(title)
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda share: bar.update(task, completed=min(share, 1.0))


def _in_lines(title: str) -> Callable[[float], None]:
    """Takes the share done, and says it on the standard error once a minute."""
    begin = last = time.monotonic()

    def tell(share: float) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= _EVERY_S:
            last = now
            done = f"{100.0 * min(share, 1.0):.0f} % after {(now - begin) / 60.0:.0f} min"
            print(f"{title}: {done}", file=sys.stderr, flush=True)

    return tell
