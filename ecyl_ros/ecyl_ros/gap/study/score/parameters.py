"""Values said against true ones: parameters of rightly named effects, constants of the sheet."""

from __future__ import annotations

import math
from typing import Any

from ..case import Case
from ..examine import Outcome

# Parameters that count something: right or wrong, no error in percent.
COUNTS = frozenset({"periods_per_rev", "periods_per_screw_rev"})


def parameter_errors(case: Case, outcome: Outcome) -> list[dict[str, Any]]:
    """One entry per parameter of each effect that was rightly named.

    relative: |said - true| / |true|; of_change: the same over |true - nominal| where the sheet
    holds the quantity (a lead 0.2 % off is no feat if it was 0.4 % off before); covered:
    whether the 95 % interval holds the truth, None without one. Counts (periods) have `exact`
    instead.
    """
    entries = []
    for cause in outcome.causes:
        true_values = case.effects.get(cause["effect"])
        if true_values is None:
            continue
        held = case.nominal.get(cause["effect"], {})
        for parameter, true in true_values.items():
            said = cause["parameters"].get(parameter)
            if said is None:  # told as another quantity, where the file leaves out what it is over
                continue
            value = float(said["value"])
            entry: dict[str, Any] = {"effect": cause["effect"], "parameter": parameter}
            if parameter in COUNTS:
                entry["exact"] = abs(value - true) < 0.5
            else:
                error = abs(value - true) if math.isfinite(value) else math.inf
                change = abs(true - held.get(parameter, 0.0))
                entry["relative"] = error / abs(true)
                entry["of_change"] = error / min(change, abs(true))
                interval = said.get("ci95")
                entry["covered"] = interval[0] <= true <= interval[1] if interval else None
            entries.append(entry)
    return entries


def sheet_coverage(case: Case, outcome: Outcome) -> list[bool]:
    """For each constant of the sheet that the recording was said to show: is the truth inside.

    The interval is the stated one of 95 %.
    """
    covered = []
    for one in (outcome.diagnosis or {}).get("sheet", []):
        true = case.constants.get(one["parameter"])
        if one["seen"] and true is not None:
            low, high = one["ci95"]
            covered.append(bool(low <= true <= high))
    return covered
