"""A coupling that the drive file leaves out: found from the recording, and what that costs."""

from __future__ import annotations

from collections.abc import Sequence

from ..drive.parameters import DriveParameters, leaf_fields
from ..drive.tolerances import constants_of
from ..effects.catalogue import CATALOGUE
from .diagnosis import SheetValue


def not_to_be_judged(drive: DriveParameters) -> set[str]:
    """Effects that give another value to what the file has none of."""
    return {name for name, one in CATALOGUE.items() if one.constant in drive.left_out}


def costs(drive: DriveParameters, sheet: Sequence[SheetValue]) -> list[str]:
    """What to say of each constant that was left out; sheet: as it was found."""
    seen = {one.parameter for one in sheet if one.seen}
    rigid, leaves = constants_of(drive), leaf_fields()
    notes = []
    for key in drive.left_out:
        unit = leaves[key].metadata["unit"]
        how = "it was found from the recording"
        if key not in seen:
            how = (
                f"{rigid[key]:.3g} {unit} of a rigid coupling took its place, for this recording "
                "does not tell it"
            )
        titles = [one.title for one in CATALOGUE.values() if one.constant == key]
        unjudged = f", so that a {titles[0]} cannot be seen" if titles else ""
        notes.append(f"{key} is left out: {how}{unjudged}")
    return notes
