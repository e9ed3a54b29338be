"""A voltage limit below the one the nominal model has."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start
from .starts import limits, plateau


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """The lower of the two limits acts."""
    record["voltage_limit"] = min(float(record["voltage_limit"][0]), values["voltage_v"])


def shown(evidence: Evidence) -> Start:
    """A recorded command that stays at its largest value is cut off there."""
    limit = plateau(evidence.voltage_v)
    return {} if limit is None else {"voltage_v": limit}


def starts(evidence: Evidence) -> list[Start]:
    """Where the recorded command is cut off; about the largest value recorded, or taken by the
    motor."""
    if seen := shown(evidence):
        return [seen]
    motor, voltage = evidence.drive.motor, evidence.voltage_v
    if np.isnan(voltage).all():
        voltage = motor.resistance * evidence.current_a
        voltage = voltage + motor.back_emf_constant * evidence.rotor_speed_rad_s
    return limits("voltage_v", voltage)


EFFECT = Effect(
    name="voltage_limit",
    block="controller",
    title="voltage limit",
    summary="The controller's voltage stops at a value below the nominal limit: flat tops, and the "
    "drive falls behind while it lasts.",
    excitation="motion that needs more voltage than the limit",
    parameters=(Quantity(name="voltage_v", unit="V", low=1e-3, high=1e5, meaning="true limit"),),
    starts=starts,
    shown=shown,
    modify=modify,
    sized=(),
)
