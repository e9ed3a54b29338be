"""Message and service classes, generated from the definitions to behave as rosidl's do.

Differences from rosidl's generated classes: fields are checked on assignment unless
``ROS_PYTHON_CHECK_FIELDS=0`` (Jazzy checks only with ``=1``, and otherwise sends garbage for a
field of the wrong type), and ``==`` compares fixed numeric arrays element for element.
"""

from __future__ import annotations

import array
import os
import re
import sys
import types
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy

from rclpy_cyclone.types import fieldchecks, services
from rclpy_cyclone.types.store import TYPECODES, Field, constants, fields, names

CHECKED = os.environ.get("ROS_PYTHON_CHECK_FIELDS", "1") != "0" and __debug__
UNSET: Any = type("Unset", (), {"__repr__": lambda self: "<default>"})()


class MessageMeta(type):
    """Type of all message classes; tells them from other classes (as rosidl's metaclass does)."""

    _TYPE_SUPPORT = "rclpy_cyclone"
    _ros_name: str

    def __import_type_support__(cls) -> None:
        """Do nothing: there is no C type support to load."""


class ServiceMeta(type):
    """Type of all service classes."""

    _TYPE_SUPPORT = "rclpy_cyclone"
    _ros_name: str

    def __import_type_support__(cls) -> None:
        """Do nothing: there is no C type support to load."""


def snake(name: str) -> str:
    """Return the module name of a type: ``JointState`` -> ``joint_state``."""
    name = re.sub("(.)([A-Z][a-z]+)", r"\1_\2", name)
    return re.sub("([a-z0-9])([A-Z])", r"\1_\2", name).lower()


@cache
def message_class(typename: str) -> Any:
    """Return the class of a message, or of a service's request or response.

    :param typename: e.g. ``sensor_msgs/msg/JointState``.
    :raises KeyError: if there is no such type.
    """
    if typename not in names():
        raise KeyError(typename)
    package, kind, base = typename.split("/")
    module = f"{package}.{kind}._{snake(base.removesuffix('_Request').removesuffix('_Response'))}"
    members = fields(typename)
    space: dict[str, Any] = {
        "__slots__": [f"_{name}" for name, _ in members],
        "__module__": module,
        "__doc__": f"Message class '{base}'.",
        "__hash__": None,
        "__repr__": _repr,
        "get_fields_and_field_types": classmethod(lambda cls: dict(cls._fields_and_field_types)),
        "_fields_and_field_types": {n: type_text(f) for n, f in members},
        "_ros_name": typename,
        "_check_fields": CHECKED,
    }
    for name, kind_, value in constants(typename):
        space[name] = _constant(kind_, value)
    for name, value in services.DEFAULTS.get(typename, {}).items():
        space[f"{name.upper()}__DEFAULT"] = value
    space["__init__"] = _init(typename, base)
    space["__eq__"] = _eq(members)
    cls = MessageMeta(base, (), space)
    for name, field in members:
        slot = cls.__dict__[f"_{name}"]
        setter = fieldchecks.setter(name, field, slot.__set__, CHECKED, message_class)
        setattr(cls, name, property(slot.__get__, setter, None, f"Message field '{name}'."))
    _home(module, cls)
    return cls


@cache
def service_class(typename: str) -> Any:
    """Return the class of a service, with its ``Request`` and ``Response``.

    :param typename: e.g. ``std_srvs/srv/SetBool``.
    :raises KeyError: if there is no such service.
    """
    if typename not in services.DEFINITIONS:
        raise KeyError(typename)
    package, kind, base = typename.split("/")
    module = f"{package}.{kind}._{snake(base)}"
    space = {
        "Request": message_class(f"{typename}_Request"),
        "Response": message_class(f"{typename}_Response"),
        "Event": message_class(f"{typename}_Event"),
        "__module__": module,
        "_ros_name": typename,
        "__init__": _no_service_instance,
    }
    cls = ServiceMeta(base, (), space)
    _home(module, cls)
    return cls


def _no_service_instance(self: Any) -> None:
    raise NotImplementedError("Service classes can not be instantiated")


def _home(module: str, cls: type) -> None:
    """Make the class importable under its module, which pickle relies on."""
    home = sys.modules.get(module)
    if home is None:
        home = sys.modules[module] = types.ModuleType(module)
    setattr(home, cls.__name__, cls)


def _constant(kind: str, value: Any) -> Any:
    if kind == "byte" and isinstance(value, int):
        return bytes([value])
    return value


def type_text(field: Field) -> str:
    """Return the type of a field as rosidl names it, e.g. ``sequence<double>``."""
    names_ = {"float64": "double", "float32": "float", "bool": "boolean", "byte": "octet"}
    base = {**names_, "char": "uint8"}.get(field.base, field.base)
    if field.nested:
        package, _, name = field.base.split("/")
        base = f"{package}/{name}"
    if field.text_bound:
        base += f"<{field.text_bound}>"
    if field.kind == "array":
        return f"{base}[{field.length}]"
    if field.kind == "sequence":
        return f"sequence<{base}, {field.length}>" if field.length else f"sequence<{base}>"
    return base


def _repr(self: Any) -> str:
    path = [*self.__class__.__module__.split(".")[:-1], self.__class__.__name__]
    parts = []
    for name in self._fields_and_field_types:
        value = getattr(self, name)
        text = str(value.tolist()) if isinstance(value, array.array) else repr(value)
        parts.append(f"{name}={text}")
    return f"{'.'.join(path)}({', '.join(parts)})"


def _eq(members: tuple[tuple[str, Field], ...]) -> Callable[[Any, Any], bool]:
    tests = ["isinstance(other, self.__class__)"]
    for name, field in members:
        if field.kind == "array" and field.base in TYPECODES and not field.nested:
            tests.append(f"array_equal(self._{name}, other._{name})")
        else:
            tests.append(f"self._{name} == other._{name}")
    space: dict[str, Any] = {"array_equal": numpy.array_equal}
    exec(f"def f(self, other):\n    return {' and '.join(tests)}", space)
    return space["f"]


def _init(typename: str, base: str) -> Callable[..., None]:
    """Write the constructor: keyword arguments only, defaults without any check."""
    defaults = services.DEFAULTS.get(typename, {})
    space: dict[str, Any] = {"U": UNSET, "array": array.array, "numpy": numpy, "_bad": _unknown}
    params, lines = [], []
    for name, field in fields(typename):
        default, made, test = _default(name, field, defaults.get(name), space)
        space[f"D{name}"] = default
        params.append(f"{name}=D{name}")
        if test:  # an accepted value is stored at once, any other goes through the setter
            lines.append(f"if {test}: self._{name} = {made}")
            lines.append(f"else: self.{name} = {name}")
        else:
            lines += made.split("\n")
    head = (
        f"def __init__(self, *, {', '.join(params)}, **_more):"
        if params
        else ("def __init__(self, **_more):")
    )
    body = [head, "    if _more: _bad(self, _more)", *("    " + line for line in lines)]
    exec("\n".join(body), space)
    return space["__init__"]


def _default(name: str, field: Field, preset: Any, space: dict[str, Any]) -> tuple[Any, str, str]:
    """Return a parameter's default, what to store, and the test under which to store it."""
    code = TYPECODES.get(field.base)
    if field.kind == "sequence":
        if code:
            return (), f"array('{code}', {name})", f"{name}.__class__ in (tuple, list)"
        return UNSET, "[]", f"{name} is U"
    if field.kind == "array":
        if code:
            space[f"Y{name}"] = numpy.dtype(code)
            zeros = f"numpy.zeros({field.length}, Y{name})"
            return UNSET, zeros, f"{name} is U"
        one = Field("one", field.base, field.nested, 0, field.text_bound)
        space[f"M{name}"] = lambda: [zero(one) for _ in range(field.length)]
        return UNSET, f"M{name}()", f"{name} is U"
    if field.nested:
        space[f"K{name}"] = cls = message_class(field.base)
        space[f"N{name}"] = cls
        lines = (
            f"if {name} is U: self._{name} = N{name}()\n"
            f"elif {name}.__class__ is K{name}: self._{name} = {name}\n"
            f"else: self.{name} = {name}"
        )
        return UNSET, lines, ""
    default = zero(field) if preset is None else preset
    if field.base in ("float64", "bool") or (field.base == "string" and not field.text_bound):
        kind = {"float64": "float", "bool": "bool", "string": "str"}[field.base]
        return default, name, f"{name}.__class__ is {kind}"
    space[f"d{name}"] = default
    return default, name, f"{name} is d{name}"


def zero(field: Field) -> Any:
    """Return the value a single field has when none is given."""
    if field.nested:
        return message_class(field.base)()
    if field.base == "string":
        return ""
    if field.base == "byte":
        return b"\0"
    if field.base == "bool":
        return False
    return 0.0 if field.base.startswith("float") else 0


def _unknown(message: Any, more: dict[str, Any]) -> None:
    checked = more.pop("check_fields", CHECKED)
    if more and checked:
        raise AssertionError(f"Invalid arguments passed to constructor: {', '.join(sorted(more))}")
