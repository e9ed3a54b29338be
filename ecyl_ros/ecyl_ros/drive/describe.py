"""The drive file's keys and tolerances as tables; `python -m ecyl_ros.drive.describe` prints it."""

from __future__ import annotations

import dataclasses
import math

from .coupling import MAY_MISS
from .parameters import leaf_fields
from .tolerances import CONSTANTS


def _number(value: float) -> str:
    return f"{value:g}" if math.isfinite(value) else "none"


def key_table() -> str:
    """Markdown table of every key: unit, range, default, meaning."""
    rows = ["| key | unit | possible | default | meaning |", "|---|---|---|---|---|"]
    for key, item in leaf_fields().items():
        meta = item.metadata
        unit, meaning = meta.get("unit", ""), meta["meaning"]
        if "choices" in meta:
            possible = " or ".join(meta["choices"])
        else:
            low, high = _number(meta["low"]), _number(meta["high"])
            possible = f"{'above ' if meta['open_low'] else ''}{low} to {high}"
            possible = possible.replace(" to none", "") if high == "none" else possible
        default = item.default
        if default is dataclasses.MISSING:
            shown = "rigid" if key in MAY_MISS else "required"
        elif isinstance(default, tuple):
            shown = "[]"
        else:
            shown = default if isinstance(default, str) else _number(default)
        rows.append(f"| `{key}` | {unit} | {possible} | {shown} | {meaning} |")
    return "\n".join(rows)


def tolerance_table() -> str:
    """Markdown table of every constant that may be uncertain: default tolerance and its source."""
    rows = ["| constant | default tolerance | because |", "|---|---|---|"]
    for key, one in CONSTANTS.items():
        rows.append(f"| `{key}` | {_share(one.relative)} | {one.source} |")
    return "\n".join(rows)


def _share(relative: float) -> str:
    return "exact" if relative == 0.0 else f"{100.0 * relative:g} %"


if __name__ == "__main__":
    print(key_table(), tolerance_table(), sep="\n\n")
