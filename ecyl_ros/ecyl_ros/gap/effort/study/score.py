"""Diagnose drawn drives, hold the answers against the labels, and print the figures."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

from ...blind.score import Figure
from ...blind.table import figure_rows
from ...diagnosis import Diagnosis
from ..judge import diagnose_effort
from .cases import Case, play

# What gives the same effort, or nearly: named instead, it is not wrong, but neither is it a hit.
_AKIN = {
    "load_dependent_friction": ("load_coulomb_friction", "rotor_coulomb_friction"),
    "stribeck_friction": ("load_coulomb_friction", "rotor_coulomb_friction"),
    "friction_drift": ("load_coulomb_friction", "rotor_coulomb_friction"),
    "direction_dependent_friction": (
        "load_coulomb_friction",
        "rotor_coulomb_friction",
        "load_viscous_friction",
        "rotor_viscous_friction",
        "constant_load",
    ),
}
_SURE = 0.9


@dataclass(frozen=True)
class Outcome:
    """What was said of a case, and how long it took."""

    diagnosis: Diagnosis
    seconds: float

    @property
    def named(self) -> list[str]:
        """The causes, first to last."""
        return [one.effect for one in self.diagnosis.causes]


def diagnosed(case: Case) -> Outcome:
    """Play and diagnose one case; the diagnosis sees the recording and the drive file alone."""
    recording, machine = play(case)
    begin = time.perf_counter()
    without = {case.effect} if case.kind == "withheld" and case.effect is not None else set()
    diagnosis = diagnose_effort(recording, machine, without=without)
    return Outcome(diagnosis, time.perf_counter() - begin)


def none_wrong(case: Case, outcome: Outcome) -> bool:
    """Whether nothing is named that the drive does not hold; naming nothing is never wrong."""
    fitting = {case.effect, *_AKIN.get(case.effect or "", ())}
    return set(outcome.named) <= fitting


def figures(cases: Sequence[Case], outcomes: Sequence[Outcome]) -> list[Figure]:
    """The study's figures beside what is wanted of them."""
    pairs = list(zip(cases, outcomes, strict=True))

    def share(name: str, rights: list[bool], wanted: float | None) -> Figure:
        count = len(rights)
        return Figure(
            name, sum(rights) / count if count else float("nan"), sum(rights), count, wanted
        )

    single = [(c, o) for c, o in pairs if c.kind == "single"]
    clean = [(c, o) for c, o in pairs if c.kind == "none"]
    barred = [(c, o) for c, o in pairs if c.kind == "withheld"]
    sure = [
        one.effect == c.effect or one.effect in _AKIN.get(c.effect or "", ())
        for c, o in pairs
        for one in o.diagnosis.causes
        if one.confidence >= _SURE
    ]
    shrunk = sorted(o.diagnosis.shrink for _, o in single)
    seconds = sorted(o.seconds for o in outcomes)
    return [
        share("single: named first", [o.named[:1] == [c.effect] for c, o in single], 0.9),
        share("single: it alone named", [o.named == [c.effect] for c, o in single], None),
        share("no gap: no false alarm", [o.diagnosis.verdict == "no_gap" for _, o in clean], 1.0),
        share("withheld: no wrong cause", [none_wrong(c, o) for c, o in barred], 0.9),
        share("   and a gap reported", [o.diagnosis.verdict != "no_gap" for _, o in barred], None),
        share("right of those at 0.9 or surer", sure, 0.9),
        Figure(
            "shrink held out, median",
            shrunk[len(shrunk) // 2] if shrunk else float("nan"),
            None,
            len(shrunk),
            0.9,
            unit="",
        ),
        Figure(
            "seconds per case, median",
            seconds[len(seconds) // 2],
            None,
            len(seconds),
            None,
            unit="s",
        ),
    ]


def study_text(cases: Sequence[Case], outcomes: Sequence[Outcome]) -> str:
    """Figures, and every case that was not judged rightly."""
    lines = figure_rows(figures(cases, outcomes))
    for case, outcome in zip(cases, outcomes, strict=True):
        right = outcome.named == ([case.effect] if case.kind == "single" else [])
        if case.kind == "none":
            right = outcome.diagnosis.verdict == "no_gap"
        if case.kind == "withheld":
            right = none_wrong(case, outcome)
        if not right:
            gap = outcome.diagnosis.signals[0]
            said = ", ".join(
                f"{one.effect} {one.confidence:.2f}" for one in outcome.diagnosis.causes
            )
            loop = "loop known" if case.loop else "loop unknown"
            lines += [
                f"case {case.index} {case.kind}: {case.effect or 'nothing'}, "
                f"{'linear' if case.linear else 'rotary'}, {case.actuation}, {loop}",
                f"    said {outcome.diagnosis.verdict}: {said or 'no cause named'}; gap "
                f"{gap.gap / gap.floor:.3g}, after {gap.after / gap.floor:.3g} floors",
            ]
    return "\n".join(lines)
