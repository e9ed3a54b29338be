"""A study's answers beside its opened labels as plain data: figures, tables, curves."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ..case import Case
from ..examine import Outcome
from .answers import Judged, allowed, both_named, exactly_named, first_right, none_wrong
from .figure import counted
from .figures import figures
from .parameters import parameter_errors

BINS = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0)  # of the calibration curve
NOTHING = "(none)"
FAILED = "(failed)"


def calibration(judged: Sequence[Judged]) -> list[dict[str, Any]]:
    """Causes by confidence: bounds of the bin, how many, their mean confidence, the share right."""
    said = [
        (float(cause["confidence"]), cause["effect"] in allowed(case))
        for case, outcome in judged
        for cause in outcome.causes
    ]
    curve = []
    for low, high in pairwise(BINS):
        last = high == BINS[-1]
        inside = [(c, right) for c, right in said if low <= c < high or (last and c == high)]
        part = counted("", [right for _, right in inside], None)
        curve.append(
            {
                "from": low,
                "to": high,
                "count": part.count,
                "confidence": float(np.mean([c for c, _ in inside])) if inside else None,
                "right": part.value if inside else None,
                "ci95": list(part.interval) if part.interval else None,
            }
        )
    return curve


def confusion(judged: Sequence[Judged]) -> dict[str, dict[str, int]]:
    """For cases of one effect, by the true effect: how often each effect was named first."""
    table: dict[str, Counter[str]] = {}
    for case, outcome in judged:
        if case.kind in ("pair", "none"):
            continue
        said = FAILED if outcome.error else (outcome.named or [NOTHING])[0]
        for name in case.effects:
            note = " (withheld)" if name in case.withheld else ""
            row = name + (" (given)" if case.kind == "beyond" else note)
            table.setdefault(row, Counter())[said] += 1
    rows = sorted(table, key=lambda row: (row.endswith(")"), row.startswith("x_"), row))
    return {row: dict(table[row].most_common()) for row in rows}


def by_effect(judged: Sequence[Judged]) -> dict[str, dict[str, Any]]:
    """For each catalogue effect of single and pair cases: how often it was there, was named, and
    the median relative error of its parameters."""
    table: dict[str, dict[str, Any]] = {}
    for name in sorted({name for case, _ in judged for name in case.effects}):
        holding = [
            (case, out)
            for case, out in judged
            if name in case.effects and case.kind in ("single", "pair")
        ]
        if not holding:
            continue
        errors = [
            entry["relative"]
            for case, out in holding
            for entry in parameter_errors(case, out)
            if entry["effect"] == name and "relative" in entry
        ]
        wrong = sum(name in out.named and name not in allowed(case) for case, out in judged)
        table[name] = {
            "single": sum(case.kind == "single" for case, _ in holding),
            "single_right": sum(
                first_right(case, out.named) for case, out in holding if case.kind == "single"
            ),
            "pair": sum(case.kind == "pair" for case, _ in holding),
            "pair_named": sum(name in out.named for case, out in holding if case.kind == "pair"),
            "named_wrongly": wrong,
            "error": float(np.median(errors)) if errors else None,
        }
    return table


def baseline_figures(judged: Sequence[Judged]) -> dict[str, dict[str, Any]]:
    """The same questions put to the baselines: shares, counts, and what they name most."""
    names = sorted({name for _, outcome in judged for name in outcome.baselines})
    report = {}
    for name in names:
        rows = [(c, o.baselines[name]["named"]) for c, o in judged if name in o.baselines]

        def share(right: Callable[[Case, Sequence[str]], bool], *kinds: str, rows=rows) -> Any:
            asked = [row for row in rows if row[0].kind in kinds]
            if "single" in kinds:  # as of the diagnosis
                asked = [row for row in asked if row[0].judgeable]
            verdicts = [right(case, named) for case, named in asked]
            return {"right": sum(verdicts), "count": len(verdicts)}

        report[name] = {
            "single: named first": share(first_right, "single"),
            "single: it alone named": share(exactly_named, "single"),
            "pair: both named": share(both_named, "pair"),
            "pair: both and no other": share(exactly_named, "pair"),
            "no gap: no false alarm": share(lambda c, named: not named, "none"),
            "not in catalogue: no wrong cause": share(none_wrong, "outside", "withheld"),
            "names_per_case": float(np.mean([len(named) for _, named in rows])),
            "named_first": dict(
                Counter((named or [NOTHING])[0] for _, named in rows).most_common()
            ),
            "seconds": float(
                np.median([o.baselines[name]["seconds"] for _, o in judged if o.baselines])
            ),
            "times": float(np.median([_times(o, name) for _, o in judged if o.baselines])),
        }
    return report


def _times(outcome: Outcome, name: str) -> float:
    """Times as long as a baseline that the diagnosis took."""
    return outcome.seconds / max(outcome.baselines[name]["seconds"], 1e-9)


def report(cases: Sequence[Case], outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Everything above as plain data."""
    judged = list(zip(cases, outcomes, strict=True))
    return {
        "figures": [figure.as_json() for figure in figures(judged)],
        "verdicts": {
            kind: dict(
                Counter(
                    (o.diagnosis or {"verdict": FAILED})["verdict"]
                    for c, o in judged
                    if c.kind == kind
                )
            )
            for kind in dict.fromkeys(case.kind for case in cases)
        },
        "by_effect": by_effect(judged),
        "calibration": calibration(judged),
        "confusion": confusion(judged),
        "baselines": baseline_figures(judged),
    }
