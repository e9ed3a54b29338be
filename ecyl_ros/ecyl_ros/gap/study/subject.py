"""The diagnosis under study, behind one function: a recording and a nominal drive in, JSON out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...drive.parameters import DriveParameters
from ...drive.rigid.machine import Machine
from ...recording.signals import Recording

# What a diagnosis is told of a machine: its data sheet with tolerances, and its controller.
Sheet = DriveParameters | Machine

# (recording, sheet, effects left out of the catalogue) -> section 4 of the contract as a dict.
Subject = Callable[[Recording, Any, frozenset[str]], dict[str, Any]]


def product_diagnosis(
    recording: Recording, sheet: Sheet, without: frozenset[str]
) -> dict[str, Any]:
    """What `ecyl diagnose` says, as JSON-ready data."""
    from ..diagnose import diagnose, effects_of

    # A name that does not compete needs no leaving out.
    return diagnose(recording, sheet, without=without & set(effects_of(sheet))).as_json()
