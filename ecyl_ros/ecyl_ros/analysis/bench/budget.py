"""The error budget of the bench's angle: what each part of it is worth at the input shaft.

Section 3.2 weighs the twist of the input shaft against the resolution of the angle sensor and
stops there. Everything else on the bench is put on the same scale here.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...drive.parameters import DriveParameters
from . import table1
from .lines import ThreeLines
from .sensors import BenchSensors


@dataclass(frozen=True)
class BudgetItem:
    """One source of error: its size as an angle of the input shaft, rad, and how it acts."""

    source: str
    angle_rad: float
    acts: str


def error_budget(
    lines: ThreeLines,
    drive: DriveParameters,
    sensors: BenchSensors | None = None,
    torque_nm: float = table1.RATED_TORQUE,
) -> tuple[BudgetItem, ...]:
    """All items at `torque_nm`; lines give what a torque error is worth as an angle."""
    sensors = sensors or BenchSensors()
    share = torque_nm / table1.RATED_TORQUE
    per_rod = 1.0 / drive.transmission.rod_per_rotor
    force_nm = sensors.force_n * drive.transmission.rod_per_rotor
    items = [
        BudgetItem(
            "input shaft, gear to angle sensor", table1.SHAFT_TWIST * share, "grows with torque"
        ),
        BudgetItem(
            "input shaft, gear to far end", table1.SHAFT_TWIST_LARGEST * share, "grows with torque"
        ),
        BudgetItem("angle sensor", sensors.angle_rad, "each reading"),
        BudgetItem("torque sensor, third line", sensors.torque_nm * lines.k3, "each reading"),
        BudgetItem("torque sensor, second line", sensors.torque_nm * lines.k2, "each reading"),
    ]
    if lines.t1 > 0.0:
        items.append(
            BudgetItem("torque sensor, first line", sensors.torque_nm * lines.k1, "each reading")
        )
    items += [
        BudgetItem("force sensor, second line", force_nm * lines.k2, "each reading"),
        BudgetItem(
            "give of the output mount that the linear scale does not show",
            sensors.displacement_m * per_rod,
            "grows with torque",
        ),
    ]
    return tuple(items)
