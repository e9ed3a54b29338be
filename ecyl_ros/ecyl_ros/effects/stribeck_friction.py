"""Friction on the rotor that falls from a static to a Coulomb level with speed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.compiled import kernel, over_arrays
from ..drive.parameters import DriveParameters
from .along import Along
from .effect import Effect, Evidence, Quantity, Start, bristle, put_bristle
from .rigid_form import RigidForm, Stem, level
from .starts import direction, regress
from .term import Fitted, Left, Term, at_bound


def starts(evidence: Evidence) -> list[Start]:
    """Coulomb level by regression, static level above it, over a range of Stribeck speeds."""
    size = -float(
        regress(evidence.torque_nm, direction(evidence), np.ones_like(evidence.time_s))[0]
    )
    size = max(size, 1e-4)
    top = float(np.nanmax(np.abs(evidence.rotor_speed_rad_s), initial=1e-3))
    return [
        {"coulomb_nm": size, "static_nm": 1.6 * size, "stribeck_rad_s": top * share}
        for share in (0.01, 0.05, 0.2)
    ]


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Let the contact give as the bristle says."""
    put_bristle(record, "rotor", values)


@kernel
def surplus_kept(speed, stribeck):
    """Share of the surplus at rest that is left at a speed: a Gaussian."""
    ratio = speed / stribeck
    return np.exp(-ratio * ratio)


EFFECT = Effect(
    name="stribeck_friction",
    block="motor_mechanical",
    title="Stribeck friction on the rotor",
    summary="Friction that is higher at rest than in motion: stick-slip in slow motion, and a "
    "breakaway torque above that of motion.",
    excitation="slow motion and reversals beside fast motion",
    parameters=(
        Quantity(name="coulomb_nm", unit="N m", low=0.0, high=1e3, meaning="level at speed"),
        Quantity(name="static_nm", unit="N m", low=0.0, high=1e3, meaning="level at rest"),
        Quantity(
            name="stribeck_rad_s",
            unit="rad/s",
            low=1e-3,
            high=1e3,
            meaning="rotor speed at which the surplus has fallen to 1/e",
        ),
        *bristle("rotor"),
    ),
    starts=starts,
    modify=modify,
    refines=("rotor_coulomb_friction",),
    sized=("coulomb_nm", "static_nm"),
    rarity=1,
)


_SPEEDS = 7  # Stribeck speeds tried
_STEP = 0.25  # of a Stribeck speed, between two tried


def term(along: Along, stribeck: float) -> Term:
    """More friction near rest than in motion, fallen to 1/e at a speed."""
    units = along.units
    name = "stribeck_m_s" if along.machine.linear else "stribeck_rad_s"
    surplus = along.sign * over_arrays(surplus_kept)(along.motion.velocity, stribeck)
    return Term(
        effect="stribeck_friction",
        key=f"stribeck {stribeck:.6g}",
        columns=np.stack([along.sign, surplus]),
        parameters=lambda c: (
            (units.level("coulomb"), units.effort, float(c[0])),
            (units.level("static"), units.effort, float(c[0] + c[1])),
            (name, f"{units.end}/s", stribeck),
        ),
        values=lambda c: {
            "coulomb": float(c[0]),
            "static": float(c[0] + c[1]),
            "stribeck": stribeck,
        },
        low=(max(along.least_coulomb()), 0.0),
        refines=(f"{along.side}_coulomb_friction",),
        fixed={name: stribeck},
        reach={name: _STEP * stribeck},
        moved=lambda fixed: term(along, fixed[name]),
    )


def _tried(along: Along, left: Left) -> list[tuple[float]]:
    low, high = 5.0 * along.soft, 0.5 * along.top_speed
    if not along.both_ways or not high > 2.0 * low:
        return []
    return [(speed,) for speed in np.geomspace(low, high, _SPEEDS).tolist()]


def _void(fitted: Fitted) -> str:
    level_at_speed, at_rest = fitted.spans[:2]
    half = max(at_rest.high - at_rest.value, 0.0)
    within = at_rest.value - half <= level_at_speed.value
    return at_bound(fitted) or ("the surplus at rest is within its interval" if within else "")


RIGID = RigidForm(
    stems=(
        level("coulomb", "level at speed"),
        level("static", "level at rest"),
        Stem("stribeck", "speed", 1e-9, 1e6, "at which the surplus has fallen to 1/e"),
    ),
    term=term,
    tried=_tried,
    shape=lambda along, values, effort: (values["stribeck"],),
    coefficients=lambda values: (values["coulomb"], values["static"] - values["coulomb"]),
    void=_void,
)


@kernel
def rotor_friction(p, speed, torque, time):
    """Level: Coulomb plus the surplus, falling as a Gaussian of speed."""
    surplus = p.stribeck_friction_static_nm - p.stribeck_friction_coulomb_nm
    if surplus <= 0.0:  # resisting less at rest than in motion is another effect
        return p.stribeck_friction_coulomb_nm
    kept = surplus_kept(speed, p.stribeck_friction_stribeck_rad_s)
    return p.stribeck_friction_coulomb_nm + surplus * kept


@kernel
def rigid_level(v, time, position, speed, acceleration):
    """The same; v: coulomb, static, Stribeck speed."""
    return v[0] + (v[1] - v[0]) * surplus_kept(speed, v[2])
