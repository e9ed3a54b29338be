"""The permanent-magnet synchronous motor in the dq frame: equations (1), (2) and (4)."""

from __future__ import annotations

from .compiled import kernel


@kernel
def current_derivatives(i_d, i_q, rotor_speed, u_d, u_q, p):
    """Return (di_d/dt, di_q/dt) in A/s, equation (1) solved for the derivatives.

    The flux term is K_e times the mechanical speed; the cross-coupling runs at the electrical
    speed, pole pairs times the mechanical one.
    """
    electrical_speed = p.pole_pairs * rotor_speed
    slope_d = (u_d - p.resistance * i_d) * p.per_inductance + electrical_speed * i_q
    slope_q = (
        u_q - p.resistance * i_q - p.back_emf_constant * rotor_speed
    ) * p.per_inductance - electrical_speed * i_d
    return slope_d, slope_q


@kernel
def rotor_torque(i_q, rotor_speed, p):
    """Torque on the rotor before the transmission takes its share, N m: equation (2)."""
    return p.torque_constant * i_q - p.rotor_viscous * rotor_speed
