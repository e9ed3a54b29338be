"""`python -m ecyl_ros.gap.effort.study --cases 60 --seed 1`: draw, seal, diagnose, open, score."""

from __future__ import annotations

import argparse
import sys

from .cases import draw, seal
from .score import diagnosed, study_text


def main() -> None:
    """Run the study and print its figures."""
    parser = argparse.ArgumentParser(
        prog="python -m ecyl_ros.gap.effort.study",
        description="Draw rigid drives with hidden faults, diagnose each, open the labels, score.",
    )
    parser.add_argument("--cases", type=int, default=60, help="how many to draw (60)")
    parser.add_argument("--seed", type=int, default=1, help="of the draw (1)")
    parser.add_argument("--case", type=int, help="diagnose only this one of them")
    options = parser.parse_args()
    if options.cases < 1:
        parser.error("--cases: expected at least 1")
    cases = draw(options.cases, options.seed)
    print(f"{len(cases)} cases, labels sealed: sha256 {seal(cases)}", flush=True)
    if options.case is not None:
        if not 0 <= options.case < len(cases):
            parser.error(f"--case: expected 0 to {len(cases) - 1}")
        cases = [cases[options.case]]
    outcomes = []
    for number, case in enumerate(cases, start=1):
        outcomes.append(diagnosed(case))
        print(f"\r{number}/{len(cases)}", end="", file=sys.stderr, flush=True)
    print("\r", end="", file=sys.stderr)
    print(study_text(cases, outcomes))


if __name__ == "__main__":
    main()
