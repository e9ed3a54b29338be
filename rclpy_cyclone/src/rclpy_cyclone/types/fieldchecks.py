"""Setters of message fields, which refuse what rosidl's setters refuse (AssertionError)."""

from __future__ import annotations

import array
from collections import UserList, UserString
from collections.abc import Callable, Sequence, Set
from typing import Any

import numpy

from rclpy_cyclone.types.store import TYPECODES, Field

_BOUNDS = {
    "int8": (-(2**7), 2**7 - 1), "uint8": (0, 2**8 - 1), "char": (0, 2**8 - 1),
    "int16": (-(2**15), 2**15 - 1), "uint16": (0, 2**16 - 1),
    "int32": (-(2**31), 2**31 - 1), "uint32": (0, 2**32 - 1),
    "int64": (-(2**63), 2**63 - 1), "uint64": (0, 2**64 - 1),
}  # fmt: skip
_FLOAT32_MAX = 3.402823466e38
_INF = float("inf")


def setter(
    name: str, field: Field, store: Callable[..., None], checked: bool, classes: Any
) -> Callable[[Any, Any], None]:
    """Return the function behind ``message.name = value``.

    :param store: puts a value into the slot of a message.
    :param checked: whether to check values; numeric arrays are converted in any case.
    :param classes: gives the class of a nested message.
    """
    if field.kind == "one":
        return _single(name, field, store, classes) if checked else store
    if field.base in TYPECODES and not field.nested:
        if field.kind == "array":
            return _fixed_numbers(name, field, store, checked)
        return _numbers(name, field, store, checked)
    return _many(name, field, store, classes) if checked else store


def _single(name: str, field: Field, store: Any, classes: Any) -> Callable[[Any, Any], None]:
    if field.nested:
        cls = classes(field.base)

        def put_nested(self: Any, value: Any) -> None:
            if value.__class__ is not cls:
                assert isinstance(value, cls), (
                    f"The '{name}' field must be a sub message of type '{cls.__name__}'"
                )
            store(self, value)

        return put_nested
    if field.base in _BOUNDS:
        low, high = _BOUNDS[field.base]
        kind = "integer" if low else "unsigned integer"

        def put_int(self: Any, value: Any) -> None:
            assert isinstance(value, int), f"The '{name}' field must be of type 'int'"
            assert low <= value <= high, f"The '{name}' field must be an {kind} in [{low}, {high}]"
            store(self, value)

        return put_int
    if field.base == "float32":

        def put_float32(self: Any, value: Any) -> None:
            assert isinstance(value, float), f"The '{name}' field must be of type 'float'"
            assert not _FLOAT32_MAX < abs(value) < _INF, (
                f"The '{name}' field must be a float in [-{_FLOAT32_MAX}, {_FLOAT32_MAX}]"
            )
            store(self, value)

        return put_float32
    if field.base == "byte":

        def put_byte(self: Any, value: Any) -> None:
            assert isinstance(value, (bytes, bytearray)) and len(value) == 1, (
                f"The '{name}' field must be of type 'bytes' or 'ByteString' with length 1"
            )
            store(self, value)

        return put_byte
    if field.text_bound:
        bound = field.text_bound

        def put_bounded(self: Any, value: Any) -> None:
            assert isinstance(value, (str, UserString)) and len(value) <= bound, (
                f"The '{name}' field must be string value not longer than {bound}"
            )
            store(self, value)

        return put_bounded
    kind_ = {"string": str, "bool": bool, "float64": float}[field.base]

    def put(self: Any, value: Any) -> None:
        if value.__class__ is not kind_:
            assert isinstance(value, kind_), (
                f"The '{name}' field must be of type '{kind_.__name__}'"
            )
        store(self, value)

    return put


def _fixed_numbers(name: str, field: Field, store: Any, checked: bool) -> Any:
    length = field.length
    dtype = numpy.dtype(TYPECODES[field.base])

    def put(self: Any, value: Any) -> None:
        if isinstance(value, numpy.ndarray) and value.dtype == dtype and value.size == length:
            store(self, value)
            return
        if checked:
            assert not isinstance(value, numpy.ndarray), (
                f"The '{name}' numpy.ndarray() must have a size of {length} and the dtype of "
                f"'{dtype}'"
            )
            _check_items(name, field, value, f"with length {length} ")
        store(self, numpy.array(value, dtype=dtype))

    return put


def _numbers(name: str, field: Field, store: Any, checked: bool) -> Any:
    code = TYPECODES[field.base]
    bound = field.length
    dtype = numpy.dtype(code)

    def put(self: Any, value: Any) -> None:
        if value.__class__ is array.array:
            if checked:
                assert value.typecode == code, (
                    f"The '{name}' array.array() must have the type code of '{code}'"
                )
                assert not bound or len(value) <= bound, (
                    f"The '{name}' array.array() must have a size <= {bound}"
                )
            store(self, value if value.typecode == code else array.array(code, value))
            return
        if isinstance(value, numpy.ndarray):
            assert value.ndim == 1 and (not bound or value.size <= bound), (
                f"The '{name}' field must be of one dimension and within its bound"
            )
            assert value.dtype.kind == dtype.kind or not checked, (
                f"The '{name}' field must have numbers of kind '{dtype}', not '{value.dtype}'"
            )
            new = array.array(code)
            new.frombytes(value.astype(dtype, casting="same_kind").tobytes())
            store(self, new)
            return
        if checked:
            _check_items(name, field, value, f"with length <= {bound} " if bound else "")
        store(self, array.array(code, value))

    return put


def _many(name: str, field: Field, store: Any, classes: Any) -> Callable[[Any, Any], None]:
    kind: Any
    if field.nested:
        kind = classes(field.base)
    else:
        kind = {"string": str, "bool": bool, "byte": bytes}[field.base]
    length = f"with length {'<= ' * (field.kind == 'sequence')}{field.length} "
    suffix = length if field.length else ""

    def put(self: Any, value: Any) -> None:
        _check_sequence(name, field, value, suffix)
        for item in value:
            assert isinstance(item, kind), (
                f"The '{name}' field must be a set or sequence {suffix}"
                f"and each value of type '{kind.__name__}'"
            )
            if field.text_bound:
                assert len(item) <= field.text_bound, (
                    f"each string of the '{name}' field must not be longer than {field.text_bound}"
                )
        store(self, value)

    return put


def _check_sequence(name: str, field: Field, value: Any, suffix: str) -> None:
    if value.__class__ is not list:
        assert isinstance(value, (Sequence, Set, UserList)) and not isinstance(
            value, (str, UserString)
        ), f"The '{name}' field must be a set or sequence {suffix}"
    if field.length:
        right = len(value) == field.length if field.kind == "array" else len(value) <= field.length
        assert right, f"The '{name}' field must be a set or sequence {suffix}"


def _check_items(name: str, field: Field, value: Any, suffix: str) -> None:
    """Check the items of a numeric sequence or array."""
    _check_sequence(name, field, value, suffix)
    if field.base.startswith("float"):
        bound = _FLOAT32_MAX if field.base == "float32" else _INF
        good = all(isinstance(v, float) and not bound < abs(v) < _INF for v in value)
        what = "float"
    else:
        low, high = _BOUNDS[field.base]
        good = all(isinstance(v, int) and low <= v <= high for v in value)
        what = f"int' in '[{low}, {high}]"
    assert good, (
        f"The '{name}' field must be a set or sequence {suffix}and each value of type '{what}'"
    )
