"""Gain error of the q-current sensor; the current loop regulates the wrong value."""

from __future__ import annotations

from ..drive.compiled import kernel
from .effect import Effect, Evidence, Quantity, Start


def starts(evidence: Evidence) -> list[Start]:
    """A little either way."""
    return [{"gain": gain} for gain in (-0.1, 0.1)]


EFFECT = Effect(
    name="current_sensor_gain",
    block="sensor",
    title="current sensor gain",
    summary="The current reading is too large or too small by a constant share: torque, voltage "
    "and current disagree in the same proportion.",
    excitation="high current, and a recorded voltage, which distinguishes it from the torque "
    "constant",
    parameters=(
        Quantity(name="gain", unit="1", low=-0.9, high=3.0, meaning="reading over truth, less 1"),
    ),
    starts=starts,
)


@kernel
def current_error(p, current):
    """In proportion."""
    return p.current_sensor_gain_gain * current
