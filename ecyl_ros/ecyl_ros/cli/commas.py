"""Names that a flag takes between commas."""

from __future__ import annotations


def names_in(text: str) -> tuple[str, ...]:
    """In their order, without what is empty."""
    return tuple(name for word in text.split(",") if (name := word.strip()))
