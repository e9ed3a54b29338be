"""Diagnoses in which few effects compete: for claims about these, not about the whole catalogue."""

from __future__ import annotations

from ecyl_ros.effects.catalogue import CATALOGUE


def without_all_but(*names: str) -> list[str]:
    """The `without` of a diagnosis in which these effects alone compete."""
    unknown = set(names) - set(CATALOGUE)
    if unknown:
        raise KeyError(f"no effects: {', '.join(sorted(unknown))}")
    return sorted(set(CATALOGUE) - set(names))
