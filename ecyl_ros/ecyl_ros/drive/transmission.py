"""Backlash and stiffness between rotor and load: equation (5), with stiffness in segments.

The transmission is always in one *mode*: 0 when it transmits nothing, +(j + 1) or -(j + 1) when
segment j of the positive or negative flank carries the torque. Within a mode the torque is linear,
which is what lets the plant step be of full order between contacts. Without clearance both flanks
touch, preloaded, and the contact never parts: its first segment is one mode on both sides.
"""

from __future__ import annotations

from .compiled import kernel


@kernel
def _segment(overlap, p):
    """Number, from 1, of the segment that an overlap, rad, is in."""
    segment = 0
    while segment + 1 < p.segments and overlap > p.deflection_start[segment + 1]:
        segment += 1
    return segment + 1


@kernel
def contact_mode(twist, twist_rate, p):
    """Mode for a twist rotor - load, rad, and its rate, rad/s.

    A flank is in contact where it is overlapped and its torque, contact damping included, pushes;
    damping alone never makes it pull.
    """
    overlap = abs(twist) - p.half_backlash
    side = 1 if twist > 0.0 else -1
    if p.half_backlash <= 0.0:
        segment = _segment(overlap, p)
        return side * segment if segment > 1 else 1
    if overlap <= 0.0:
        return 0
    mode = side * _segment(overlap, p)
    if side * mode_torque(twist, twist_rate, mode, p) <= 0.0:
        return 0
    return mode


@kernel
def mode_torque(twist, twist_rate, mode, p):
    """Torque that a given mode transmits from rotor to load, N m, linear in twist and rate."""
    if mode == 0:
        return 0.0
    side = 1.0 if mode > 0 else -1.0
    segment = abs(mode) - 1
    overlap = side * twist - p.half_backlash
    return (
        side
        * (p.torque_start[segment] + p.stiffness[segment] * (overlap - p.deflection_start[segment]))
        + p.contact_damping * twist_rate
    )


@kernel
def beyond(twist, twist_rate, mode, p):
    """How far a motion is out of `mode`, in rad of overlap: above 0 from where it no longer holds.

    Unlike the mode it changes steadily along a motion, so that its zero is found in a few looks.
    """
    if mode == 0:
        side = 1 if twist > 0.0 else -1
        overlap = abs(twist) - p.half_backlash
        if overlap <= 0.0 or side * twist_rate >= 0.0:
            return overlap
        touching = _segment(overlap, p)
        pushed = side * mode_torque(twist, twist_rate, side * touching, p)
        return pushed / p.stiffness[touching - 1]
    side = 1 if mode > 0 else -1
    segment = abs(mode) - 1
    overlap = side * twist - p.half_backlash
    if p.half_backlash > 0.0:
        pushed = side * mode_torque(twist, twist_rate, mode, p)
        out = max(p.deflection_start[segment] - overlap, -pushed / p.stiffness[segment])
    else:
        overlap = abs(twist) if segment == 0 else overlap
        out = p.deflection_start[segment] - overlap
    if segment + 1 < p.segments:
        out = max(out, overlap - p.deflection_start[segment + 1])
    return out
