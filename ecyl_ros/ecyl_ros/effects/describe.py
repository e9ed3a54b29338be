"""The catalogue as Markdown; `python -m ecyl_ros.effects.describe` prints it."""

from __future__ import annotations

from .catalogue import CATALOGUE
from .effect import BLOCKS


def catalogue_text() -> str:
    """One section per block, one entry per effect: what it is, parameters, what excites it."""
    parts = []
    for block in BLOCKS:
        parts.append(f"## {block.replace('_', ' ').capitalize()}")
        for name, effect in sorted(CATALOGUE.items()):
            if effect.block != block:
                continue
            parts.append(f"### `{name}`")
            parts.append(effect.summary)
            rows = ["| parameter | unit | meaning |", "|---|---|---|"]
            for one in effect.parameters:
                default = "" if one.default is None else f"; {one.default:g} unless given"
                rows.append(f"| `{one.name}` | {one.unit} | {one.meaning}{default} |")
            parts.append("\n".join(rows))
            parts.append(f"To be seen it takes {effect.excitation}.")
    return "\n\n".join(parts)


if __name__ == "__main__":
    print(catalogue_text())
