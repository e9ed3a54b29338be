"""From coarse to fine: how a fit looks at a gap while it is far from it, and when it is near.

Where the flanks meet, the response to a small change is a pair of spikes, and impacts that come
early or late do not overlap: a derivative sees no way there. Coarse steps see the valley that the
spikes stand in, and a moving mean over more than the time they are apart by shows which way they
have to move. Both are sharpened as the fit comes near. Over a coarse step the response bends:
differences one way would point beside the valley, and the fit would end on its slope.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass


@dataclass(frozen=True)
class Stage:
    """One way to look at a gap.

    Attributes:
        difference: step of the numerical derivatives, in a fit's coordinates (mostly logarithms).
        pulled: the same of the sheet's constants, in tolerances.
        wide: scale of the robust loss over the one that ranks fits; what is beyond it counts less.
        blur_s: width of the moving mean that the gap is seen through.
        central: derivatives by differences both ways.
        linear: only samples that answer linearly count, see `linear`.
    """

    difference: float
    pulled: float
    wide: float = 1.0
    blur_s: float = 0.0
    central: bool = False
    linear: bool = False


COARSE = Stage(0.15, 0.3, wide=1e3, blur_s=0.01, central=True)
MEDIUM = Stage(0.02, 0.1, wide=5.0, blur_s=0.003, central=True)
FINE = Stage(2e-3, 0.02)
# What can be exchanged for one another to the last digit (a torque constant, and all inertias and
# frictions) must come out as that, or a derivative's own error would tell between them: rows at an
# impact bend within hundredths of a tolerance.
EXACT = Stage(2e-5, 1e-4, central=True)
# What would need both ways bends, and does not count.
LINEAR = dataclasses.replace(EXACT, linear=True, central=False)
