"""A force on the rod that swings at a fixed frequency, whatever the drive does."""

from __future__ import annotations

import math

import numpy as np

from ..drive.compiled import kernel
from .along import Along
from .apart import apart
from .effect import Effect, Evidence, Quantity, Start, phase
from .rigid_form import HUGE, RigidForm, Stem
from .starts import rates_over_time, strongest
from .term import Term
from .waves import parts, phase_stem, sine, wave


def starts(evidence: Evidence) -> list[Start]:
    """The strongest lines of what the replay leaves of the current (else of the rotor's speed)."""
    time = evidence.time_s
    drive = evidence.drive
    error, per_error = evidence.current_error_a, drive.motor.torque_constant
    if not np.isfinite(error).any():
        error, per_error = evidence.rotor_speed_error_rad_s, drive.motor.rotor_inertia * 100.0
    ratio = drive.transmission.rod_per_rotor
    lines = strongest(error, time, rates_over_time(time), 3, np.ones_like(time))
    return [
        {
            "amplitude_n": height * per_error / ratio,
            "frequency_hz": rate / (2.0 * math.pi),
            "phase_rad": shift,
        }
        for rate, height, shift in lines
    ]


EFFECT = Effect(
    name="periodic_disturbance",
    block="load",
    title="periodic disturbance",
    summary="A force of fixed frequency, at rest as in motion: a pump, a spindle, a press nearby.",
    excitation="any motion, or rest, over several of its periods",
    parameters=(
        Quantity(name="amplitude_n", unit="N", low=0.0, high=1e6, meaning="peak force on the rod"),
        Quantity(name="frequency_hz", unit="Hz", low=1e-2, high=1e4, meaning="its frequency"),
        phase("of the sine at the first sample"),
    ),
    starts=starts,
    rarity=2,
)


def term(along: Along, frequency_hz: float) -> Term:
    """A sine of time on a rigid drive; of several recordings each begins in a phase of its own."""
    return apart(_in_phase(along, frequency_hz), along.motion.parts, by_size=True)


def _in_phase(along: Along, frequency_hz: float) -> Term:
    """The same in one phase in all."""
    units = along.units
    return sine(
        math.tau * frequency_hz * along.motion.own_s,
        "amplitude",
        (units.level("amplitude"), units.effort),
        found=(("frequency_hz", "Hz", frequency_hz),),
        stems={"frequency": frequency_hz},
        effect="periodic_disturbance",
        key=f"disturbance {frequency_hz:.9g}",
        moved=lambda fixed: _in_phase(along, fixed["frequency_hz"]),
        rate=frequency_hz,
        over_time=True,
    )


RIGID = RigidForm(
    stems=(
        Stem("amplitude", "level", 0.0, HUGE, "peak"),
        Stem("frequency", "frequency", 1e-4, 1e6, "its frequency"),
        phase_stem("the first sample"),
    ),
    term=term,
    tried=lambda along, left: [(frequency_hz,) for frequency_hz in left.lines()],
    shape=lambda along, values, effort: (values["frequency"],),
    coefficients=lambda values: parts(values["amplitude"], values["phase"]),
    several=True,
    like=lambda along, left, other: (left.nearest(other, True),),
    twins=("cogging_torque",),
)


@kernel
def load_torque(p, time, angle, speed):
    """A sine of time."""
    if p.periodic_disturbance_amplitude_n == 0.0:
        return 0.0
    rate = 2.0 * math.pi * p.periodic_disturbance_frequency_hz
    swing = wave(1.0, rate, p.periodic_disturbance_phase_rad, time)
    return p.periodic_disturbance_amplitude_n * p.rod_per_rotor * swing


@kernel
def rigid_load(v, time, position):
    """A sine of time; v: amplitude, Hz, phase."""
    return wave(v[0], 2.0 * math.pi * v[1], v[2], time)
