"""Hashes of types."""

from __future__ import annotations

from typing import Any


class TypeHash:
    """Hash of a type's description.

    :param version: version of the hash; -1: none.
    :param value: the 32 bytes.
    """

    __slots__ = ["_value", "_version"]

    def __init__(self, version: int = -1, value: bytes = bytes(32)) -> None:
        self.version = version
        self.value = value

    @property
    def version(self) -> int:
        """Version of the hash; -1: none."""
        return self._version

    @version.setter
    def version(self, value: int) -> None:
        assert isinstance(value, int)
        self._version = value

    @property
    def value(self) -> bytes:
        """The 32 bytes."""
        return self._value

    @value.setter
    def value(self, value: bytes) -> None:
        assert isinstance(value, bytes)
        self._value = value

    @classmethod
    def from_text(cls, text: str) -> TypeHash:
        """Return the hash of a text such as ``RIHS01_...``, an empty one for any other."""
        if text.startswith("RIHS01_") and len(text) == 71:
            return cls(1, bytes.fromhex(text[7:]))
        return cls()

    def __eq__(self, other: Any) -> bool:
        if not isinstance(other, TypeHash):
            return False
        return self._version == other._version and self._value == other._value

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        if self._version <= 0 or len(self._value) != 32:
            return "INVALID"
        return f"RIHS{self._version:02}_{self._value.hex()}"
