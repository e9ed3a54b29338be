"""Parameters: values with a name and a type."""

from __future__ import annotations

import array
from collections.abc import Callable
from enum import Enum
from typing import Any

PARAMETER_SEPARATOR_STRING = "."


class Parameter:
    """A parameter.

    :param name: its name.
    :param type_: its type, by default that of the value.
    :param value: its value.
    :raises TypeError: if the value is of no type a parameter can have.
    :raises ValueError: if the value is not of the type.
    """

    class Type(Enum):
        """Types of parameters, numbered as in ``rcl_interfaces.msg.ParameterType``."""

        NOT_SET = 0
        BOOL = 1
        INTEGER = 2
        DOUBLE = 3
        STRING = 4
        BYTE_ARRAY = 5
        BOOL_ARRAY = 6
        INTEGER_ARRAY = 7
        DOUBLE_ARRAY = 8
        STRING_ARRAY = 9

        @classmethod
        def from_parameter_value(cls, parameter_value: Any) -> Parameter.Type:
            """Return the type of a value.

            :raises TypeError: if it is of no type a parameter can have.
            """
            if parameter_value is None:
                return Parameter.Type.NOT_SET
            for kind, type_ in _SINGLE:
                if isinstance(parameter_value, kind):
                    return type_
            if not isinstance(parameter_value, (list, tuple, array.array)):
                raise TypeError(
                    f"The given value is not one of the allowed types '{parameter_value}'."
                )
            for item, type_ in _MANY:
                if all(isinstance(v, item) for v in parameter_value):
                    return type_
            raise TypeError(
                f"The given value is not a list of one of the allowed types '{parameter_value}'."
            )

        def check(self, parameter_value: Any) -> bool:
            """Say whether a value is of this type."""
            return _CHECKS[self](parameter_value)

    def __init__(self, name: str, type_: Parameter.Type | None = None, value: Any = None) -> None:
        if type_ is None:
            type_ = Parameter.Type.from_parameter_value(value)
        if not isinstance(type_, Parameter.Type):
            raise TypeError(f"type must be an instance of '{Parameter.Type!r}'")
        if not type_.check(value):
            raise ValueError(f"Type '{type_}' and value '{value}' do not agree")
        self._type_ = type_
        self._name = name
        self._value = value

    @classmethod
    def from_parameter_msg(cls, param_msg: Any) -> Parameter:
        """Return the parameter of a ``rcl_interfaces.msg.Parameter``."""
        type_ = Parameter.Type(param_msg.value.type)
        field = _FIELDS.get(type_)
        return cls(param_msg.name, type_, getattr(param_msg.value, field) if field else None)

    @property
    def name(self) -> str:
        """The name."""
        return self._name

    @property
    def type_(self) -> Parameter.Type:
        """The type."""
        return self._type_

    @property
    def value(self) -> Any:
        """The value."""
        return self._value

    def get_parameter_value(self) -> Any:
        """Return the value as ``rcl_interfaces.msg.ParameterValue``."""
        from rcl_interfaces.msg import ParameterValue

        message = ParameterValue(type=self._type_.value)
        if field := _FIELDS.get(self._type_):
            setattr(message, field, self._value)
        return message

    def to_parameter_msg(self) -> Any:
        """Return the parameter as ``rcl_interfaces.msg.Parameter``."""
        from rcl_interfaces.msg import Parameter as Message

        return Message(name=self._name, value=self.get_parameter_value())


_T = Parameter.Type
_Kinds = tuple[tuple[Any, Parameter.Type], ...]
_SINGLE: _Kinds = (
    (bool, _T.BOOL),
    (int, _T.INTEGER),
    (float, _T.DOUBLE),
    (str, _T.STRING),
)
_MANY: _Kinds = (
    (bytes, _T.BYTE_ARRAY),
    (bool, _T.BOOL_ARRAY),
    (int, _T.INTEGER_ARRAY),
    (float, _T.DOUBLE_ARRAY),
    (str, _T.STRING_ARRAY),
)
_FIELDS: dict[Parameter.Type, str] = {
    _T.BOOL: "bool_value",
    _T.INTEGER: "integer_value",
    _T.DOUBLE: "double_value",
    _T.STRING: "string_value",
    _T.BYTE_ARRAY: "byte_array_value",
    _T.BOOL_ARRAY: "bool_array_value",
    _T.INTEGER_ARRAY: "integer_array_value",
    _T.DOUBLE_ARRAY: "double_array_value",
    _T.STRING_ARRAY: "string_array_value",
}


def _list_of(kind: Any, *also: Any) -> Callable[[Any], bool]:
    def check(values: Any) -> bool:
        if not isinstance(values, (list, tuple, *also)):
            return False
        items: Any = values
        return all(isinstance(v, kind) for v in items)

    return check


def _byte_list(values: Any) -> bool:
    return _list_of(bytes)(values) and all(len(v) == 1 for v in values)


_CHECKS: dict[Parameter.Type, Callable[[Any], bool]] = {
    _T.NOT_SET: lambda v: v is None,
    _T.BOOL: lambda v: isinstance(v, bool),
    _T.INTEGER: lambda v: isinstance(v, int),
    _T.DOUBLE: lambda v: isinstance(v, float),
    _T.STRING: lambda v: isinstance(v, str),
    _T.BYTE_ARRAY: _byte_list,
    _T.BOOL_ARRAY: _list_of(bool),
    _T.INTEGER_ARRAY: _list_of(int, array.array),
    _T.DOUBLE_ARRAY: _list_of(float, array.array),
    _T.STRING_ARRAY: _list_of(str),
}


def get_parameter_value(string_value: str) -> Any:
    """Return a text as ``rcl_interfaces.msg.ParameterValue``, its type guessed as YAML would."""
    import yaml
    from rcl_interfaces.msg import ParameterValue

    try:
        value = yaml.safe_load(string_value)
    except yaml.parser.ParserError:
        value = string_value
    try:
        type_ = Parameter.Type.from_parameter_value(value)
    except TypeError:
        type_ = _T.NOT_SET
    if value == [] and isinstance(value, list):
        type_ = _T.BOOL_ARRAY
    if type_ in (_T.NOT_SET, _T.STRING, _T.BYTE_ARRAY):
        type_ = _T.STRING
        value = value if isinstance(value, str) else string_value
    message = ParameterValue(type=type_.value)
    setattr(message, _FIELDS[type_], value)
    return message


def parameter_value_to_python(parameter_value: Any) -> Any:
    """Return the value of a ``rcl_interfaces.msg.ParameterValue``.

    :raises RuntimeError: if its type is unknown.
    """
    try:
        type_ = Parameter.Type(parameter_value.type)
    except ValueError:
        raise RuntimeError(f"unexpected parameter type {parameter_value.type}") from None
    if type_ is _T.NOT_SET:
        return None
    value = getattr(parameter_value, _FIELDS[type_])
    return list(value) if type_.name.endswith("ARRAY") else value


def parameter_dict_from_yaml_file(
    parameter_file: str,
    use_wildcard: bool = False,
    target_nodes: list[str] | None = None,
    namespace: str = "",
) -> dict[str, Any]:
    """Return the parameters of a file as ``rcl_interfaces.msg.Parameter`` by name.

    :param use_wildcard: whether to take those of ``/**`` first.
    :param target_nodes: whose parameters to take; those of all nodes by default.
    :param namespace: put before every name.
    :raises RuntimeError: if a node is not in the file, or the file is no parameter file.
    """
    import yaml

    with open(parameter_file, encoding="utf-8") as file:
        content = yaml.safe_load(file)
    keys = ["/**"] if use_wildcard and "/**" in content else []
    for node in target_nodes or ():
        if node not in content:
            raise RuntimeError(
                f"Param file does not contain parameters for {node},"
                f"only for nodes: {list(content)} "
            )
        keys.append(node)
    if not target_nodes:
        keys.extend(k for k in content if k != "/**")
    if not keys:
        raise RuntimeError("Param file does not contain selected parameters")
    merged: dict[str, Any] = {}
    for key in keys:
        value = content[key]
        if not isinstance(value, dict) or "ros__parameters" not in value:
            raise RuntimeError(f"YAML file is not a valid ROS parameter file for node {key}")
        merged.update(value["ros__parameters"])
    return _flatten(namespace, merged)


def _flatten(prefix: str, tree: dict[str, Any]) -> dict[str, Any]:
    from rcl_interfaces.msg import Parameter as Message

    found: dict[str, Any] = {}
    for key, value in tree.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            found.update(_flatten(name + PARAMETER_SEPARATOR_STRING, value))
        else:
            found[name] = Message(name=name, value=get_parameter_value(str(value)))
    return found
