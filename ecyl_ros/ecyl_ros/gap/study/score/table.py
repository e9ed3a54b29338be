"""A scored study as text for a terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from ..case import Case
from ..examine import Outcome
from .answers import Judged, misjudged
from .figure import Figure
from .figures import figures
from .laws import law_lines


def case_line(case: Case) -> str:
    """A case's label on one line."""
    held = [
        f"{name}({', '.join(f'{key}={value:.4g}' for key, value in values.items())})"
        for name, values in case.effects.items()
    ]
    withheld = f", withheld {', '.join(case.withheld)}" if case.withheld else ""
    unseen = f", not to be seen {', '.join(case.unseen)}" if case.unseen else ""
    plain = {key: one for key, one in case.facts.items() if not isinstance(one, dict)}
    facts = ", ".join(f"{key} {_fact(one)}" for key, one in plain.items() if one not in ([], None))
    return (
        f"case {case.index} {case.kind}: {' + '.join(held) or 'nothing'}{withheld}{unseen}"
        f"{f' ({facts})' if facts else ''}"
    )


def _fact(value: Any) -> str:
    if isinstance(value, list):
        return " ".join(map(str, value))
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def outcome_line(outcome: Outcome) -> str:
    """What was said of a case on one line."""
    if outcome.diagnosis is None:
        return f"failed: {outcome.error}"
    named = []
    for cause in outcome.causes:
        values = ", ".join(
            f"{key}={found['value']:.4g}" for key, found in cause["parameters"].items()
        )
        named.append(f"{cause['effect']} {cause['confidence']:.2f} ({values})")
    block = (outcome.diagnosis.get("location") or {}).get("block")
    return f"{outcome.diagnosis['verdict']}, {block}: {' + '.join(named) or 'no cause named'}"


def _number(figure: Figure) -> str:
    if not math.isfinite(figure.value):
        return "-"
    if figure.unit == "%":
        return f"{100.0 * figure.value:.1f} %"
    return f"{figure.value:.3f}" if not figure.unit else f"{figure.value:.1f} {figure.unit}"


def _wanted(figure: Figure) -> str:
    if figure.wanted is None:
        return ""
    bound = f"{100.0 * figure.wanted:g} %" if figure.unit == "%" else f"{figure.wanted:g}"
    return f"{'>=' if figure.at_least else '<='} {bound}"


def figure_rows(rows: Sequence[Figure]) -> list[str]:
    """Figures beside what is wanted of them, a line each below a head."""
    lines = [f"{'':36}{'':>9}{'of':>12}   {'95 %':<12} {'wanted':<9}"]
    for figure in rows:
        of = f"{figure.right}/{figure.count}" if figure.right is not None else f"{figure.count}"
        interval = figure.interval
        between = f"{100 * interval[0]:.0f}-{100 * interval[1]:.0f} %" if interval else ""
        met = {None: "", True: "met", False: "NOT MET"}[figure.met]
        lines.append(
            f"{figure.name:36}{_number(figure):>9}{of:>12}   {between:<12} "
            f"{_wanted(figure):<9} {met}".rstrip()
        )
    return lines


def _effect_rows(table: dict[str, dict[str, Any]]) -> list[str]:
    lines = [f"{'effect':26}{'alone':>9}{'in pair':>9}{'wrongly':>9}{'error':>9}"]
    for name, row in table.items():
        error = f"{100.0 * row['error']:.1f} %" if row["error"] is not None else "-"
        alone = f"{row['single_right']}/{row['single']}"
        paired = f"{row['pair_named']}/{row['pair']}"
        lines.append(f"{name:26}{alone:>9}{paired:>9}{row['named_wrongly']:>9}{error:>9}")
    return lines


def _baseline_rows(product: Sequence[Figure], baselines: dict[str, dict[str, Any]]) -> list[str]:
    names = list(baselines)
    lines = [f"{'':36}{'diagnosis':>12}" + "".join(f"{name:>26}" for name in names)]
    for figure in product:
        if not all(figure.name in baselines[name] for name in names):
            continue
        line = f"{figure.name:36}{f'{figure.right}/{figure.count}':>12}"
        for name in names:
            found = baselines[name][figure.name]
            line += f"{'{right}/{count}'.format(**found):>26}"
        lines.append(line)
    for name in names:
        most = list(baselines[name]["named_first"].items())[:4]
        lines.append(
            f"{name}: {baselines[name]['names_per_case']:.1f} names per case, "
            f"{baselines[name]['seconds']:.0f} s, the diagnosis {baselines[name]['times']:.1f} "
            "times as long; first most often "
            + ", ".join(f"{effect} {count}" for effect, count in most)
        )
    return lines


def _calibration_rows(curve: Sequence[dict[str, Any]]) -> list[str]:
    lines = [f"{'confidence':>14}{'causes':>9}{'mean':>8}{'right':>9}"]
    for part in curve:
        if part["count"]:
            lines.append(
                f"{part['from']:>7.2f}-{part['to']:<6.2f}{part['count']:>9}"
                f"{part['confidence']:>8.2f}{100.0 * part['right']:>7.0f} %"
            )
    return lines


def study_text(cases: Sequence[Case], outcomes: Sequence[Outcome], scored: dict[str, Any]) -> str:
    """Figures, effects, calibration, baselines, and every case that was not judged rightly."""
    judged: list[Judged] = list(zip(cases, outcomes, strict=True))
    rows = figures(judged)
    blocks = [figure_rows(rows)]
    if scored["by_effect"]:
        blocks.append(_effect_rows(scored["by_effect"]))
    blocks.append(_calibration_rows(scored["calibration"]))
    if scored["baselines"]:
        blocks.append(_baseline_rows(rows, scored["baselines"]))
    laws = law_lines(judged)
    if laws:
        blocks.append(laws)
    wrong = misjudged(judged)
    if wrong:
        lines = [f"not exactly right: {len(wrong)} of {len(cases)}"]
        for case, outcome in wrong:
            lines += [case_line(case), f"    said {outcome_line(outcome)}"]
        blocks.append(lines)
    return "\n\n".join("\n".join(block) for block in blocks)
