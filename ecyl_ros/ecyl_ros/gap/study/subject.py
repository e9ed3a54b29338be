"""The diagnosis under study, behind one function: recordings and a nominal drive in, JSON out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...drive.parameters import DriveParameters
from ...drive.rigid.machine import Machine
from ...recording.signals import Recording

# What a diagnosis is told of a machine: its data sheet with tolerances, and its controller.
Sheet = DriveParameters | Machine

# What it sees of a case: one recording, or several of one machine.
Recorded = Recording | tuple[Recording, ...]

# (recorded, sheet, effects left out of the catalogue) -> section 4 of the contract as a dict.
Subject = Callable[[Recorded, Any, frozenset[str]], dict[str, Any]]


def product_diagnosis(recorded: Recorded, sheet: Sheet, without: frozenset[str]) -> dict[str, Any]:
    """What `ecyl diagnose` says, as JSON-ready data."""
    from ..diagnose import diagnose, effects_of
    from ..several.together import diagnose_together

    without &= set(effects_of(sheet))  # a name that does not compete needs no leaving out
    if isinstance(recorded, Recording):
        return diagnose(recorded, sheet, without=without).as_json()
    sources = [f"recording {number}" for number in range(1, len(recorded) + 1)]
    return diagnose_together(recorded, sheet, without=without, sources=sources).as_json()
