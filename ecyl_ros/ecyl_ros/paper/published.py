"""What the paper says: the numbers everything here is put beside. SI units."""

from __future__ import annotations

from ..analysis.bench import table1
from ..analysis.bench.units import ARCMIN

REFERENCE = "sine:amplitude=2e-5,frequency=1"  # section 4.1
AMPLITUDE_M = 2e-5
REFERENCE_HZ = 1.0

STIFFNESS_SHARES = (0.7, 0.9, 1.0, 1.1, 1.3)  # Table 3
ERROR_STD_M = dict(zip(STIFFNESS_SHARES, (6.5e-6, 5.8e-6, 5.4e-6, 5.2e-6, 4.9e-6), strict=True))
LAG_S = dict(zip(STIFFNESS_SHARES, (0.125, 0.083, 0.055, 0.026, 0.010), strict=True))

IMF1_HZ = 3.45  # Fig. 12
RELATIVE_ANGLE_HZ = 3.45  # Fig. 13
IMF2_HZ = 1.0  # Fig. 14
IMFS = 5  # section 4.1
TEXT_FALL = -0.15  # of the error at 130 % stiffness, section 4.2.1; Table 3 has less

CLEARANCE_RAD = table1.CLEARANCE
TABLE_1 = {  # name: (value in SI, factor of the printed unit, the unit, digits)
    "k1": (table1.K1, ARCMIN, "arcmin/(N m)", 3),
    "k2": (table1.K2, ARCMIN, "arcmin/(N m)", 4),
    "k3": (table1.K3, ARCMIN, "arcmin/(N m)", 4),
    "T1": (table1.T1, 1.0, "N m", 3),
    "T2": (table1.T2, 1.0, "N m", 2),
}
