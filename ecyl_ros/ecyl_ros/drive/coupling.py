"""A coupling that the drive file leaves out: rigid, as far as its controller can tell.

A sampled loop closes well below its rate. Where rotor and load swing against each other at as many
rad/s as there are control ticks in a second (a sixth of the rate in Hz), half critically damped,
the coupling follows whatever the loop does as if it were rigid, and takes no finer steps than a
common one.
"""

from __future__ import annotations

from collections.abc import Mapping

# Keys that a drive file may leave out for it, and with the stiffness its damping.
BACKLASH, STIFFNESS = "transmission.backlash", "transmission.stiffness"
DAMPING = "transmission.contact_damping"
MAY_MISS = (BACKLASH, STIFFNESS)

_WIDE_BACKLASH_RAD = 5e-3  # 17 arcmin at the rotor

Value = float | tuple[float, ...]


def rigid_coupling(
    given: Mapping[str, object], rotor: float, load: float, rate: float
) -> dict[str, Value]:
    """Values, by key, of what `given` leaves out of the coupling.

    Args:
        given: keys that the drive file holds. rotor, load: inertias, kg m^2. rate: of the
            controller, Hz.
    """
    made: dict[str, Value] = {}
    if BACKLASH not in given:
        made[BACKLASH] = 0.0
    if STIFFNESS not in given:
        reduced = rotor * load / (rotor + load)
        made[STIFFNESS] = (rate**2 * reduced,)
        if DAMPING not in given:
            made[DAMPING] = rate * reduced
    return made


def free_widths(left_out: Mapping[str, float]) -> dict[str, float]:
    """Half widths of constants that were left out, by key, in their units: a factor of e.

    left_out: values that took their place; a clearance of none may be as wide as that of gears.
    """
    return {key: value if value > 0.0 else _WIDE_BACKLASH_RAD for key, value in left_out.items()}
