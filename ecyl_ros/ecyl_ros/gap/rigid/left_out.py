"""What the file of a rigid drive leaves out, and what that costs."""

from __future__ import annotations

import numpy as np

from ...effects.along import Along
from .motion import Motion


def costs(motion: Motion, along: Along, mode: float | None, *, inertia: bool) -> list[str]:
    """As notes: of the motion, of each key of the file, of the kind of drive.

    mode: that was judged, None for all. inertia: whether the recording shows it.
    """
    machine = along.machine
    side = "load" if machine.linear else "rotor"
    notes: list[str] = []
    general = [
        f"a rigid drive has one inertia: motor and load cannot be separated, friction is "
        f"named on the {side}; backlash, stiffness and electrical effects are not judged",
        f"compared up to {motion.bandwidth_hz:.3g} Hz (zero-phase), "
        f"{motion.rate_hz / motion.step:.3g} samples per second; faster effects are not seen",
    ]
    if not along.both_ways:
        notes.append("the output moves one way only: Coulomb friction and a constant load are one")
    elif max(along.strokes) < 2:
        notes.append(
            "one stroke each way: what depends on position, speed, direction or time can hardly be "
            "told apart; a recording with several strokes would tell"
        )
    if mode is not None:
        notes.append(f"judged where the mode is {mode:g}")
    else:
        values = np.unique(motion.mode[np.isfinite(motion.mode)])
        if values.size > 1:
            listed = ", ".join(f"{one:g}" for one in values[:8].tolist())
            notes.append(
                f"the mode changes within the run ({listed}): all were judged together; "
                "--mode picks one"
            )
    if motion.effort_unit not in ("N", "N m"):
        told = "" if not any(along.model.keys) else ", and found with the values of the file"
        notes.append(
            f"actuation.gain is left out{told}: effort is counted in {motion.effort_unit}, and a "
            "wrong gain cannot be seen"
        )
    if not (along.known_inertia or along.model.keys.inertia):
        key = "load.mass" if machine.linear else "load.inertia"
        if inertia:
            notes.append(
                f"{key} is left out and was fitted to the recording: a wrong one, or a wrong gain "
                "of the effort, cannot be seen"
            )
        else:
            notes.append(
                f"{key} is left out, and the recording does not show it: stated in the drive "
                "file, it would tell what goes with the acceleration (a weight, a spring) apart"
            )
    if not machine.loop_known:
        notes.append(
            "no controller in the drive file: delays and limits of the loop are not judged"
        )
    if machine.linear and machine.lead is None:
        notes.append("screw.lead is left out: what repeats over the stroke has a period in m")
    return [*notes, *general]
