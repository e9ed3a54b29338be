"""Where to find foreign recordings."""

from pathlib import Path

import pytest

# Recordings made by another simulator; they may lie beside the repository.
FOREIGN = Path(__file__).parents[3] / "shared" / "recordings"


@pytest.fixture
def foreign() -> Path:
    """Folder of foreign recordings beside the repository; skips the test where it is absent."""
    if not FOREIGN.is_dir():
        pytest.skip("no foreign recordings beside the repository (../shared/recordings)")
    return FOREIGN
