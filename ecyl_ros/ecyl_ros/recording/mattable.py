"""MAT files as columns of numbers, through scipy."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..errors import InputError
from .columns import Columns
from .matcheck import MatError, check_mat

_DEEPEST = 8
_MOST = 2048  # columns
_WIDEST = 64  # columns of one matrix
_SERIES = 50  # values, from which a vector is a signal rather than a parameter
_SHOWN = 6  # of other lengths


class MatTable:
    """A MAT file (versions 4 to 7) as columns.

    A vector is a column of its own name, a matrix one column per index of its shorter side,
    `x[0]`, `x[1]`; fields of a structure follow a point, `out.signals[1].values`. Of columns of
    different lengths those of the commonest length above 1 make the table; the others can be
    asked for by name.

    Args:
        path: the file. It is read whole: what it holds is compressed by variable.

    Attributes:
        names: of the columns of the table.
        notes: one line each on what could not be read.

    Raises:
        InputError: no such file, not a MAT file, or without a vector of numbers.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.topic = ""
        self.units: dict[str, str] = {}
        self.dated: set[str] = set()  # it holds no dates
        self.notes: tuple[str, ...] = ()
        self._columns: dict[str, FloatArray] = {}
        for name, value in self._load().items():
            if not name.startswith("__"):
                self._take(name, value, 0)
        sizes = [column.size for column in self._columns.values() if column.size > 1]
        if not sizes:
            objects = f" ({self.notes[0].removeprefix(f'{path}: ')})" if self.notes else ""
            raise InputError(f"{path}: holds no vector of numbers{objects}")
        self._size = max(set(sizes), key=lambda size: (sizes.count(size), size))
        self.names = [name for name, own in self._columns.items() if own.size == self._size]
        others = [
            f"{name} ({own.size})"
            for name, own in self._columns.items()
            if _SERIES <= own.size != self._size
        ]
        if others:
            told = ", ".join(others[:_SHOWN]) + (", ..." if len(others) > _SHOWN else "")
            self.notes += (
                f"{self.path}: of another length than the table's {self._size} rows, and no part "
                f"of it: {told}",
            )

    def _load(self) -> dict[str, Any]:
        from scipy.io import loadmat

        try:
            with self.path.open("rb") as file:
                head = file.read(128)
        except OSError as error:
            raise InputError(f"{self.path}: cannot be read: {error.strerror}") from None
        if not head:
            raise InputError(f"{self.path}: is empty, expected a MAT file")
        if head.startswith((b"MATLAB 7.3", b"\x89HDF")):
            raise InputError(
                f"{self.path}: is a MAT file of version 7.3, expected 7 or older (save(..., '-v7'))"
            )
        try:
            check_mat(self.path)
        except MatError as error:
            raise InputError(f"{self.path}: is no MAT file, or damaged: {error}") from None
        except OSError as error:
            raise InputError(f"{self.path}: cannot be read: {error.strerror}") from None
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                tree: dict[str, Any] = loadmat(str(self.path), struct_as_record=True)
        # scipy's reader raises whatever the bytes lead it to, in a dozen kinds.
        except Exception as error:
            reason = " ".join(str(error).split())[:120] or type(error).__name__
            raise InputError(f"{self.path}: is no MAT file, or damaged: {reason}") from None
        return tree

    def _take(self, path: str, value: Any, depth: int) -> None:
        if depth > _DEEPEST or len(self._columns) >= _MOST or not isinstance(value, np.ndarray):
            return
        if {"s0", "s2", "arr"} <= set(value.dtype.names or ()):  # scipy's view of an object
            own, kind = (str(np.ravel(value[one])[0], "ascii", "replace") for one in ("s0", "s2"))
            self.notes += (
                f"{self.path}: {own or path} is an object of MATLAB's class {kind} and cannot be "
                "read: save its values as arrays (of a timeseries, Time and Data)",
            )
            return
        if value.dtype.names:
            cells = value.reshape(-1)
            for i, cell in enumerate(cells[:_WIDEST]):
                own = path if cells.size == 1 else f"{path}[{i}]"
                for name in value.dtype.names:
                    self._take(f"{own}.{name}", cell[name], depth + 1)
            return
        if value.dtype.kind == "O":
            cells = value.reshape(-1)
            for i, cell in enumerate(cells[:_WIDEST]):
                self._take(path if cells.size == 1 else f"{path}[{i}]", cell, depth + 1)
            return
        if value.dtype.kind == "V":
            self.notes += (f"{self.path}: {path} is of a MATLAB class and cannot be read",)
            return
        if value.dtype.kind not in "fiub" or not value.size:
            return
        if value.ndim > 2:  # Simulink keeps time in the last dimension
            value = value.reshape(-1, value.shape[-1])
        if value.ndim < 2 or 1 in value.shape:
            self._columns[path] = value.reshape(-1).astype(np.float64)
            return
        table = value if value.shape[0] >= value.shape[1] else value.T
        for i in range(min(table.shape[1], _WIDEST)):
            self._columns[f"{path}[{i}]"] = table[:, i].astype(np.float64)

    def columns(self, wanted: Collection[str] | None = None) -> Iterator[Columns]:
        """All rows at once.

        Raises:
            InputError: no such variable, or variables of different lengths.
        """
        names = self.names if wanted is None else list(wanted)
        values: dict[str, FloatArray] = {}
        for name in names:
            found = self._columns.get(name)
            if found is None:
                known = ", ".join(list(self._columns)[:12])
                raise InputError(f"{self.path}: no variable {name[:60]}; found {known}")
            values[name] = found
        sizes = {name: column.size for name, column in values.items()}
        if len(set(sizes.values())) > 1:
            said = ", ".join(f"{name} {size}" for name, size in sizes.items())
            raise InputError(f"{self.path}: variables of different lengths: {said}")
        yield Columns("", "MAT", None, None, values)
