"""Which effects come near each other: `python docs/effects/confusion.py [NAME ...]`.

Diagnoses the recording of each effect's picture, prints what was named and what the other effects,
each alone, leave of the gap, and keeps it in confusion.json for the pages.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from examples import EXAMPLES, faulty_and_nominal, record

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.recording.atomic import write_text

KEPT = Path(__file__).parent / "confusion.json"
OTHERS = 3  # effects that come nearest


def measure(name: str) -> dict[str, Any]:
    """What a diagnosis of one effect's recording finds; misfits in noise floors."""
    drive, nominal = faulty_and_nominal(name)
    found = diagnose(record(drive, EXAMPLES[name]), nominal)
    alone = {one.effects[0]: one.judged for one in found.candidates if len(one.effects) == 1}
    others = sorted((misfit, key) for key, misfit in alone.items() if key != name)[:OTHERS]
    return {
        "named": {one.effect: round(one.confidence, 2) for one in found.causes},
        "misfit": {
            "before": round(found.misfit_before, 2),
            "best": round(found.misfit_best, 2),
            "perfect": round(found.misfit_perfect, 2),
        },
        "nearest": {key: round(misfit, 2) for misfit, key in others},
    }


if __name__ == "__main__":
    names = sys.argv[1:] or list(EXAMPLES)
    for unknown in sorted(set(names) - set(EXAMPLES)):
        sys.exit(f"no effect called {unknown}; expected some of {', '.join(EXAMPLES)}")
    for one in names:
        kept = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
        kept[one] = measure(one)
        write_text(KEPT, json.dumps(dict(sorted(kept.items())), indent=1) + "\n")
        print(one, json.dumps(kept[one]), flush=True)
