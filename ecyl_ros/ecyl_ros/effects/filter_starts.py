"""Where fits of time constants begin: at several scales, for a fit from afar gets stuck."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..drive.parameters import DriveParameters
from .effect import Evidence, Start
from .loop_gains import crossover

_OF_LOOP = (0.3, 1.0, 0.1, 3.0, 0.03, 0.01)  # of the loop's time constant, where there is no filter
_OF_NOMINAL = (0.4, 2.0, 0.1, 5.0, 0.8, 1.25)


def loop_time_s(drive: DriveParameters, loop: str) -> float:
    """Time constant of the position or speed loop, s; without speed loop the position's is both."""
    only = drive.controller.structure == "position_to_current"
    rate = crossover(drive, "position" if only else loop)
    return 1.0 / rate if rate > 0.0 else 1.0


def filter_starts(
    parameter: str, loop: str, nominal: Callable[[DriveParameters], float]
) -> Callable[[Evidence], Sequence[Start]]:
    """Multiples of the nominal time constant, or of the loop's that a new filter would disturb."""

    def starts(evidence: Evidence) -> Sequence[Start]:
        known = nominal(evidence.drive)
        factors, scale = _OF_LOOP, loop_time_s(evidence.drive, loop)
        if known > 0.0:
            factors, scale = _OF_NOMINAL, known
        return [{parameter: scale * factor} for factor in factors]

    return starts
