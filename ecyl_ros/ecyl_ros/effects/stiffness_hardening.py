"""Stiffness that rises with torque: flanks that come to bear one after the other."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """A softer first segment before those of the nominal model."""
    segments = int(record["segments"][0])
    if segments >= record["stiffness"].shape[1]:
        segments -= 1  # the last of a full table gives way
    soft = values["share"] * float(record["stiffness"][0, 0])
    torque = values["torque_nm"]
    deflection = torque / soft
    nominal = torque / float(record["stiffness"][0, 0])
    for name in ("stiffness", "deflection_start", "torque_start"):
        record[name][0, 1 : segments + 1] = record[name][0, :segments].copy()
    record["deflection_start"][0, 2 : segments + 1] += deflection - nominal
    record["stiffness"][0, 0] = soft
    record["deflection_start"][0, :2] = (0.0, deflection)
    record["torque_start"][0, :2] = (0.0, torque)
    record["segments"] = segments + 1


def starts(evidence: Evidence) -> list[Start]:
    """Softer up to some of the torque at hand."""
    drive = evidence.drive
    torque = drive.motor.torque_constant * float(np.nanmax(np.abs(evidence.current_a), initial=0.1))
    return [{"share": share, "torque_nm": 0.3 * torque} for share in (0.1, 0.4)]


EFFECT = Effect(
    name="stiffness_hardening",
    block="transmission",
    title="stiffness that hardens",
    summary="The transmission is soft at first contact and stiffens with torque.",
    excitation="impacts and fast reversals of torque, small and large",
    parameters=(
        Quantity(
            name="share",
            unit="1",
            low=1e-3,
            high=1.0,
            meaning="stiffness at first contact over the nominal",
        ),
        Quantity(
            name="torque_nm", unit="N m", low=1e-6, high=1e6, meaning="where it becomes nominal"
        ),
    ),
    starts=starts,
    modify=modify,
    refines=("stiffness_error",),
    sized=(),
)
