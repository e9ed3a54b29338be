"""Machines off their data sheet: what each constant truly is, and what the sheet states of it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from ....drive.parameters import DriveParameters
from ....drive.tolerances import ALL, CONSTANTS, EXACT, constants_of, half_widths
from ....effects.catalogue import CATALOGUE
from .imposed import Values
from .physics import Physics

LEAD = "transmission.lead"
FEED = "controller.feed_scale"
LEAD_SD = 1e-4  # relative: screws come in accuracy classes, whatever else is uncertain
LARGEST_SD = 0.1  # beyond it a normal distribution would turn signs

# Uncertain constants: not the settings, nor a ratio of numbers of teeth.
UNCERTAIN = tuple(
    key for key in CONSTANTS if not key.startswith("controller.") and "gear_ratio" not in key
)

# A fault in a constant lies so many tolerances off the sheet, at least and, where it has to be
# moved there, at most.
LEAVES, FARTHEST = 2.5, 6.0
_LEAST_SHARE = 0.1  # of nominal, of what a constant is moved to


def standard_deviations(sd: float) -> Values:
    """Relative standard deviation of every uncertain constant, with `sd` for the sheet."""
    return {key: min(sd, LEAD_SD) if key == LEAD else sd for key in UNCERTAIN}


def stated_tolerances(sd: float) -> dict[str, float | str]:
    """What a drive file states of such a sheet: two standard deviations, or that it is exact."""
    if sd == 0.0:
        return {ALL: EXACT}
    return {key: 2.0 * one for key, one in standard_deviations(sd).items()}


def draw_errors(rng: np.random.Generator, sd: float) -> Values:
    """Relative error of each uncertain constant of one machine, normally distributed."""
    return {key: one * float(rng.normal()) for key, one in standard_deviations(sd).items()}


def draw_feed(rng: np.random.Generator, errors: Mapping[str, float]) -> Values:
    """Error of the controller's feed constant: the sheet's lead, or, as often, a measured one."""
    return {FEED: errors[LEAD] if rng.random() < 0.5 else 0.0}


def off_sheet(machine: Physics, errors: Mapping[str, float]) -> Physics:
    """The machine with its constants off by relative `errors`; its controller keeps the sheet's,
    but for its feed constant.
    """

    def factor(key: str) -> float:
        return 1.0 + errors.get(key, 0.0)

    stiffness = factor("transmission.stiffness")
    return replace(
        machine,
        resistance=machine.resistance * factor("motor.resistance"),
        inductance=machine.inductance * factor("motor.inductance"),
        torque_constant=machine.torque_constant * factor("motor.torque_constant"),
        back_emf_constant=machine.back_emf_constant * factor("motor.back_emf_constant"),
        rotor_inertia=machine.rotor_inertia * factor("motor.rotor_inertia"),
        rotor_viscous=machine.rotor_viscous * factor("motor.viscous_friction"),
        rod_per_rotor=machine.rod_per_rotor * factor(LEAD),
        nominal_rod_per_rotor=machine.nominal_rod_per_rotor * factor(FEED),
        half_backlash=machine.half_backlash * factor("transmission.backlash"),
        stiffness=tuple(stiffness * value for value in machine.stiffness),
        contact_damping=machine.contact_damping * factor("transmission.contact_damping"),
        load_inertia=machine.load_inertia * factor("load.inertia"),
        load_viscous=machine.load_viscous * factor("load.viscous_friction"),
    )


def true_constants(machine: Physics, drive: DriveParameters) -> Values:
    """What the constants of the sheet, `drive`, are in a machine, by key of the drive file, SI."""
    return {
        "motor.resistance": machine.resistance,
        "motor.inductance": machine.inductance,
        "motor.torque_constant": machine.torque_constant,
        "motor.back_emf_constant": machine.back_emf_constant,
        "motor.rotor_inertia": machine.rotor_inertia,
        "motor.viscous_friction": machine.rotor_viscous,
        LEAD: 2.0 * np.pi * machine.gear_ratio * machine.rod_per_rotor,
        FEED: machine.nominal_rod_per_rotor / drive.transmission.rod_per_rotor,
        "transmission.backlash": 2.0 * machine.half_backlash,
        "transmission.stiffness": machine.stiffness[0],
        "transmission.contact_damping": machine.contact_damping,
        "load.inertia": machine.load_inertia,
        "load.viscous_friction": machine.load_viscous,
    }


def taken_by(effects: Collection[str]) -> set[str]:
    """Constants that these effects give a value of their own."""
    known = (CATALOGUE[name].constant for name in effects if name in CATALOGUE)
    return {key for key in known if key is not None}


def leaving_the_sheet(
    name: str, values: Values, drive: DriveParameters, rng: np.random.Generator
) -> Values:
    """`values` of an effect, moved out where they say no more than what the sheet allows for.

    A constant within `LEAVES` tolerances of its nominal value is moved to between that and
    `FARTHEST` on its side, or on the upper side where there is no room below. drive: the sheet,
    with its tolerances.
    """
    effect = CATALOGUE.get(name)
    if effect is None or effect.constant is None:
        return values
    parameter, neutral = effect.parameters[0].name, effect.neutral(drive)
    nominal = constants_of(drive)
    width = half_widths(nominal, drive.tolerances)[effect.constant]
    off = values[parameter] - neutral
    if width == 0.0 or abs(off) >= LEAVES * width:
        return values
    room = (1.0 - _LEAST_SHARE) * nominal[effect.constant] / width
    down = off < 0.0 and room > LEAVES
    most = min(FARTHEST, room) if down else FARTHEST
    moved = float(rng.uniform(LEAVES, most)) * width
    return values | {parameter: neutral + (-moved if down else moved)}
