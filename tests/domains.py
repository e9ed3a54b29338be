"""ROS domains that no other test run on this machine uses at the time."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

# Not 0, where a user's own nodes live; from 102 on the ports are those the kernel gives away.
DOMAINS = range(1, 102)


@contextmanager
def domain() -> Iterator[int]:
    """A number for ROS_DOMAIN_ID, kept from other processes by a lock on a file of its name.

    Of those that are free the one given back longest ago: DDS misses killed nodes for 10 s.
    """
    folder = Path(tempfile.gettempdir(), "ecyl_test_domains")
    folder.mkdir(mode=0o777, exist_ok=True)
    for path in sorted((folder / str(number) for number in DOMAINS), key=_given_back):
        try:
            file = path.open("a")
        except OSError:  # another user's
            continue
        with file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                continue
            try:
                yield int(path.name)
            finally:
                os.utime(path)
            return
    raise RuntimeError(f"all domains are in use; see the locks in {folder}")


@contextmanager
def entered() -> Iterator[int]:
    """A `domain` that ROS_DOMAIN_ID names meanwhile."""
    with domain() as number, pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(number))
        yield number


def _given_back(path: Path) -> float:
    """When, s since 1970; 0 if never."""
    return path.stat().st_mtime if path.exists() else 0.0
