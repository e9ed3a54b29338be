"""Notes on values that are not the same in all of several recordings."""

from __future__ import annotations

from collections.abc import Sequence

from ...effects.catalogue import EFFECTS
from .of_recording import OwnValue


def differences(values: Sequence[Sequence[OwnValue]], sources: Sequence[str]) -> list[str]:
    """One line for each value that is another in some recording."""
    by_name: dict[tuple[str, str], list[tuple[str, OwnValue]]] = {}
    for source, own in zip(sources, values, strict=True):
        for one in own:
            by_name.setdefault((one.of, one.name), []).append((source, one))
    lines = []
    for (of, name), found in by_name.items():
        if any(one.differs for _, one in found):
            what = f"{EFFECTS[of].title}, {name}" if of in EFFECTS else of
            each = "; ".join(
                f"{one.value:.4g} {one.unit} ({one.low:.4g} to {one.high:.4g}) in {source}"
                for source, one in found
            )
            lines.append(
                f"{what} differs from one recording to the next by more than its interval (wear, "
                f"temperature): {each}; the twin and the replays take that of the last"
            )
    return lines
