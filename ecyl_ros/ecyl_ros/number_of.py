"""Counts as a sentence says them."""

from __future__ import annotations


def number_of(count: int, noun: str) -> str:
    """ "1 gap", "2 gaps"."""
    return f"{count} {noun}{'' if count == 1 else 's'}"
