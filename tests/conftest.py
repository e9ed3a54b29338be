"""For all tests: messages check their fields' types; domains of their own for graphs."""

import os
import signal
from collections.abc import Iterator

import pytest

from .domains import entered

# Genuine messages do so as the stand-in's always do; read by rosidl's modules at import.
os.environ.setdefault("ROS_PYTHON_CHECK_FIELDS", "1")

# A shell's background jobs ignore SIGINT, and so would what the tests start to send it to.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def own_domain() -> Iterator[int]:
    """A ROS_DOMAIN_ID that no other test run on this machine uses at the time."""
    with entered() as number:
        yield number
