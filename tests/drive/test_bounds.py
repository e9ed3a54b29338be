"""Compiled code stays within its arrays: what it reads and writes is what the interpreter does."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from . import interpreted

ROOT = Path(__file__).parents[2]


def test_kernels_stay_within_their_arrays(tmp_path: Path) -> None:
    """Interpreted, with every index checked, drives of all kinds run to the end, and give what the
    compiled ones give."""
    out = tmp_path / "interpreted.npz"
    done = subprocess.run(
        [sys.executable, "-m", "tests.drive.interpreted", str(out)],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    with np.load(out) as found:
        for name, drive in interpreted.drives():
            expected = interpreted.samples(drive)
            assert np.ptp(expected, axis=0).any(), name
            scale = np.abs(expected).max(axis=0)
            assert np.all(np.abs(found[name] - expected) <= 1e-9 * scale), name
