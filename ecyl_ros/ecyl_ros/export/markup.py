"""XML as the exporters write it: attributes with every digit, comments that cannot end early."""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import quoteattr


def attributes(**values: float | str) -> str:
    """`name="value"` in order, numbers with as many digits as it takes to read them back."""
    return " ".join(
        f"{name}={quoteattr(value if isinstance(value, str) else repr(float(value)))}"
        for name, value in values.items()
    )


def comment(left_out: Sequence[str], indent: str = "  ") -> str:
    """The list of what the format cannot express."""
    lines = ["written by ecyl export; SI units. This format cannot express:", *left_out]
    if not left_out:
        lines = ["written by ecyl export; SI units"]
    text = f"\n{indent}  - ".join(line.replace("--", "- -") for line in lines)
    return f"{indent}<!-- {text} -->"
