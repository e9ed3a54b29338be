"""Linear algebra on one thread.

Matrices here are small. More threads save nothing where the machine is idle; where it is busy, each
product waits for one that does not run, and a diagnosis takes ten times as long. On one thread sums
have one order, too: results are the same to the last bit on any number of cores.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

Given = ParamSpec("Given")
Result = TypeVar("Result")


def on_one_thread(function: Callable[Given, Result]) -> Callable[Given, Result]:
    """The function, during which this process's linear algebra has one thread."""

    @functools.wraps(function)
    def limited(*args: Given.args, **named: Given.kwargs) -> Result:
        with threadpool_limits(1):
            return function(*args, **named)

    return limited
