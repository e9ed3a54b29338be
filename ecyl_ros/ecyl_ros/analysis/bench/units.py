"""The paper's angles in rad."""

from __future__ import annotations

import math

ARCMIN = math.pi / (180.0 * 60.0)
ARCSEC = ARCMIN / 60.0
