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

# Half widths that hold what a diagnosis may find in their place: any coupling. rad at the rotor
# (gears of 60 arcmin), and shares of the rigid values.
_WIDEST_BACKLASH_RAD, _ANY = 0.02, 10.0


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
    """Half widths of constants that were left out, by key, in their units; values: nominal ones."""
    return {
        key: _WIDEST_BACKLASH_RAD if key == BACKLASH else _ANY * value
        for key, value in left_out.items()
    }
