"""Motion that was recorded in the other kind of unit than the drive's output moves in."""

from __future__ import annotations

from ...drive.rigid.machine import Machine
from ...recording.map import in_map
from ...recording.signals import Recording

# Of a linear and of a rotary output; what a rotary one may be measured by comes first.
_LINEAR = {
    "position": ("rod_position_m",),
    "velocity": ("rod_velocity_m_per_s",),
    "reference position": ("reference_position_m",),
    "reference velocity": ("reference_velocity_m_per_s",),
}
_ROTARY = {
    "position": ("rotor_position_rad", "load_position_rad"),
    "velocity": ("rotor_velocity_rad_per_s", "load_velocity_rad_per_s"),
    "reference position": ("reference_position_rad",),
    "reference velocity": ("reference_velocity_rad_per_s",),
}


def unused_motion(recording: Recording, machine: Machine) -> list[str]:
    """A line on each signal that is not used, for the output is of the other kind."""
    own, other = (_LINEAR, _ROTARY) if machine.linear else (_ROTARY, _LINEAR)
    notes = []
    for what, names in own.items():
        if any(recording.has(name) for name in names):
            continue
        notes += [
            f"{in_map(name)} is not used: drive.output is {machine.output}, whose {what} is "
            f"{in_map(names[0])}"
            for name in other[what]
            if recording.has(name)
        ]
    return notes
