"""Gain error of the inverter: a supply that is low or not measured; all voltages in proportion."""

from __future__ import annotations

from ..drive.compiled import kernel
from .effect import Effect, Evidence, Quantity, Start


def starts(evidence: Evidence) -> list[Start]:
    """A little either way."""
    return [{"gain": gain} for gain in (-0.1, 0.1)]


EFFECT = Effect(
    name="inverter_gain",
    block="motor_electrical",
    title="inverter gain",
    summary="The inverter gives more or less voltage than commanded, in proportion: the bus "
    "voltage is not the one assumed. Resistance, inductance and back EMF seem wrong alike.",
    excitation="currents that change fast, and a recorded voltage",
    parameters=(
        Quantity(name="gain", unit="1", low=-0.9, high=3.0, meaning="true over wanted, less 1"),
    ),
    starts=starts,
)


@kernel
def inverter_voltage(p, current, voltage):
    """In proportion to what was commanded."""
    return p.inverter_gain_gain * voltage
