"""The scale that no motion shows: what all torques of a drive are counted in.

Torque constant, inertias, frictions, stiffness and loads, all larger by one factor, make the same
motion with the same current, to the last digit. A derivative along that direction is therefore
zero, whatever differences of two replays make of it where flanks meet or a limit lets go; what is
known of the scale comes from the sheet alone.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ...arrays import FloatArray
from ...drive.parameters import DriveParameters, leaf_fields
from ...drive.tolerances import constants_of
from ...effects.catalogue import CATALOGUE
from ..sheet import Sheet
from .coordinate import Coordinate


def of_torque(unit: str) -> bool:
    """Whether what is counted in a unit grows with what torques are counted in."""
    return unit.startswith(("N", "kg"))


class TorqueScale:
    """The direction of that scale in the point of a fit: its coordinates, then its pulls."""

    def __init__(
        self, coordinates: Sequence[Coordinate], pulled: Sequence[int], sheet: Sheet
    ) -> None:
        relative = sheet.relative[list(pulled)]
        turns = [of_torque(one.quantity.unit) for one in coordinates]
        turns += [of_torque(sheet.units[row]) for row in pulled]
        self._of_torque = np.array(turns, dtype=bool)
        steps = [1.0 if one.logarithmic else 0.0 for one in coordinates]
        steps += np.divide(1.0, relative, out=np.zeros(len(pulled)), where=relative > 0.0).tolist()
        self._in_logarithms = np.array(steps)

    @classmethod
    def of(
        cls,
        effects: Collection[str],
        coordinates: Sequence[Coordinate],
        pulled: Sequence[int],
        sheet: Sheet,
        drive: DriveParameters,
    ) -> TorqueScale | None:
        """Of a fit of `effects` on a drive; None where some torque of the drive is held.

        drive: the nominal one.
        """
        if drive.effects or drive.learned is not None:
            return None
        free = {sheet.keys[row] for row in pulled}
        free |= {str(CATALOGUE[name].constant) for name in effects if not CATALOGUE[name].on_top}
        leaves = leaf_fields()
        held = any(
            value != 0.0 and of_torque(leaves[key].metadata["unit"]) and key not in free
            for key, value in constants_of(drive).items()
        )
        fitted = {(one.effect, one.quantity.name) for one in coordinates}
        held |= any(
            of_torque(one.unit) and (name, one.name) not in fitted
            for name in effects
            for one in CATALOGUE[name].parameters
        )
        return None if held else cls(coordinates, pulled, sheet)

    def along(self, point: FloatArray) -> FloatArray:
        """How a point float64[k] of the fit moves with the logarithm of the scale: float64[k]."""
        moved = np.where(self._in_logarithms > 0.0, self._in_logarithms, point)
        found: FloatArray = np.where(self._of_torque, moved, 0.0)
        return found

    def at(self, point: FloatArray) -> FloatArray:
        """Unit vector float64[k] at a point float64[k] of the fit."""
        moved = self.along(point)
        found: FloatArray = moved / np.linalg.norm(moved)
        return found

    def taken_out(self, slopes: FloatArray, point: FloatArray) -> None:
        """Take out of derivatives, float64[k, m], what they hold along the scale."""
        take_out(slopes, self.at(point))


def take_out(slopes: FloatArray, along: FloatArray) -> None:
    """Take out of derivatives, float64[k, ...], what they hold along a unit vector, float64[k]."""
    held = (along @ slopes.reshape(along.size, -1)).reshape(slopes.shape[1:])
    slopes -= np.multiply.outer(along, held)
