"""The diagnosis under study, behind one function: a recording and a nominal drive in, JSON out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...drive.parameters import DriveParameters
from ...recording.signals import Recording

# What a diagnosis is told of a machine: its data sheet and controller.
Sheet = DriveParameters

# (recording, drive, effects left out of the catalogue) -> section 4 of the contract as a dict.
Subject = Callable[[Recording, Sheet, frozenset[str]], dict[str, Any]]


def product_diagnosis(
    recording: Recording, drive: Sheet, without: frozenset[str]
) -> dict[str, Any]:
    """What `ecyl diagnose` says, as JSON-ready data."""
    from ...effects.catalogue import CATALOGUE
    from ..diagnose import diagnose

    # A name the catalogue does not hold needs no leaving out.
    return diagnose(recording, drive, without=without & set(CATALOGUE)).as_json()
