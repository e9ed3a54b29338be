"""For all tests: messages check their fields' types; domains of their own for graphs."""

import gc
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from .domains import entered

# Genuine messages do so as the stand-in's always do; read by rosidl's modules at import.
os.environ.setdefault("ROS_PYTHON_CHECK_FIELDS", "1")

# What is tested below the entry points that see to it themselves (`analysis.one_thread`); read when
# NumPy is imported.
os.environ.setdefault("OMP_NUM_THREADS", "1")

# What diagnoses allocate is seldom garbage: looking for it took a twentieth of the time.
gc.set_threshold(100_000, 20, 100)

# A shell's background jobs ignore SIGINT, and so would what the tests start to send it to.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


# Files that take a quarter of a minute or more. Where files go side by side, these begin first, so
# that no long one is left over for one process at the end.
_LONGEST = (
    "nodes/test_partners.py",
    "nodes/test_player.py",
    "nodes/test_gap_monitor.py",
    "gap/test_diagnose.py",
    "docs/test_site.py",
    "field/test_field_recordings.py",
    "gap/test_several_cylinders.py",
    "gap/test_study_machine.py",
    "gap/test_rigid_twin.py",
    "gap/test_rigid.py",
    "gap/test_study.py",
    "gap/test_coincidence.py",
    "gap/test_finer_forms.py",
    "gap/test_sheet.py",
    "drive/test_bounds.py",
    "packaging/test_packages.py",
    "gap/test_describe.py",
    "gap/test_study_workers.py",
    "gap/test_follower.py",
    "gap/test_rigid_searched.py",
    "gap/test_stages.py",
    "gap/test_noise_in_loop.py",
    "gap/test_hidden.py",
    "gap/test_left_out.py",
    "gap/test_place.py",
    "gap/test_fleet.py",
    "gap/test_several.py",
    "test_paper_command.py",
    "analysis/test_bench.py",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest files first, the others as they come."""
    here = Path(__file__).parent
    rank = {here / name: number for number, name in enumerate(_LONGEST)}
    gone = [str(path) for path in rank if not path.is_file()]
    if gone:
        raise pytest.UsageError(f"_LONGEST names no file of the tests: {', '.join(gone)}")
    items.sort(key=lambda item: rank.get(item.path, len(rank)))


@pytest.fixture
def own_domain() -> Iterator[int]:
    """A ROS_DOMAIN_ID that no other test run on this machine uses at the time."""
    with entered() as number:
        yield number
