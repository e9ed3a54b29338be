"""The diagnosis under study, behind one function: a recording and a nominal drive in, JSON out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from ...drive.parameters import DriveParameters
from ...drive.rigid.machine import Machine
from ...recording.signals import Recording


@dataclass(frozen=True)
class RigidSheet:
    """What is known of a rigid drive: its file, and how far its constants may lie off that.

    tolerances: as a drive file states them, by its keys.
    """

    machine: Machine
    tolerances: Mapping[str, float | str]


# What a diagnosis is told of a machine: its data sheet and controller.
Sheet = DriveParameters | RigidSheet

# (recording, sheet, effects left out of the catalogue) -> section 4 of the contract as a dict.
Subject = Callable[[Recording, Any, frozenset[str]], dict[str, Any]]


def product_diagnosis(
    recording: Recording, sheet: Sheet, without: frozenset[str]
) -> dict[str, Any]:
    """What `ecyl diagnose` says, as JSON-ready data."""
    from ..diagnose import diagnose, effects_of

    drive: DriveParameters | Machine
    if isinstance(sheet, RigidSheet):
        drive = with_tolerances(sheet.machine, sheet.tolerances)
    else:
        drive = sheet
    # A name that does not compete needs no leaving out.
    return diagnose(recording, drive, without=without & set(effects_of(drive))).as_json()


def with_tolerances(machine: Machine, tolerances: Mapping[str, float | str]) -> Machine:
    """The machine with its tolerances stated, as far as its drive file has a key for them."""
    if all(one.name != "tolerances" for one in fields(machine)):
        return machine
    stated: dict[str, Any] = {"tolerances": tolerances}
    return replace(machine, **stated)
