"""Compiled code stays within its arrays: numba checks that only when asked to."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

TESTS = Path(__file__).parents[1]
CHECKED = ("drive/test_cascade.py", "drive/test_engine.py", "drive/test_integrator.py")
CHECKED += ("drive/test_stability.py", "effects/test_effects.py")


def test_kernels_stay_within_their_arrays(tmp_path: Path) -> None:
    """With every index checked, drives of all kinds run to the end, effects and delays included."""
    environment = os.environ | {"NUMBA_BOUNDSCHECK": "1", "NUMBA_CACHE_DIR": str(tmp_path)}
    environment["NUMBA_OPT"] = "1"  # it is about indices, whatever is made of the rest
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider"]
        + ["-p", "tests.drive.called_kernels"]
        + [str(TESTS / file) for file in CHECKED],
        env=environment,
        cwd=TESTS.parent,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stdout[-3000:]
