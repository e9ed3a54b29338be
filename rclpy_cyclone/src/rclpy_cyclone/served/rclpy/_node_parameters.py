"""The parameters of a node."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import (
    ListParametersResult,
    ParameterDescriptor,
    ParameterEvent,
    ParameterValue,
    SetParametersResult,
)
from rcl_interfaces.msg import Parameter as ParameterMsg

from rclpy import _parameter_limits
from rclpy.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from rclpy.parameter import PARAMETER_SEPARATOR_STRING, Parameter
from rclpy.validate_parameter_name import validate_parameter_name

_NOT_SET = Parameter.Type.NOT_SET


class NodeParameters:
    """Part of :class:`.Node`: declaring, getting and setting parameters."""

    _clock: Any
    _parameter_event_publisher: Any
    _parameter_overrides: dict[str, Parameter]
    get_fully_qualified_name: Callable[[], str]

    def _init_parameters(self, allow_undeclared: bool) -> None:
        self._parameters: dict[str, Parameter] = {}
        self._descriptors: dict[str, Any] = {}
        self._pre_set_parameters_callbacks: list[Any] = []
        self._on_set_parameters_callbacks: list[Any] = []
        self._post_set_parameters_callbacks: list[Any] = []
        self._allow_undeclared_parameters = allow_undeclared
        self._parameter_overrides = {}

    # Declaring ---------------------------------------------------------------------------

    def declare_parameter(
        self,
        name: str,
        value: Any = None,
        descriptor: Any = None,
        ignore_override: bool = False,
    ) -> Parameter:
        """Declare a parameter and return it with the value it has got.

        :param name: its full name.
        :param value: its default, or its :class:`.Parameter.Type` if there is none.
        :param descriptor: its ``rcl_interfaces.msg.ParameterDescriptor``.
        :param ignore_override: whether to disregard the command line and parameter files.
        :raises ParameterAlreadyDeclaredException: if it is declared.
        :raises InvalidParameterException: if the name is invalid.
        :raises InvalidParameterTypeException: if the value is of the wrong type.
        :raises InvalidParameterValueException: if a callback or the descriptor refuses it.
        """
        entry: tuple[Any, ...] = (name,)
        if value is not None or descriptor is not None:
            entry = (name, value, ParameterDescriptor() if descriptor is None else descriptor)
        return self.declare_parameters("", [entry], ignore_override)[0]

    def declare_parameters(
        self, namespace: str, parameters: list[Any], ignore_override: bool = False
    ) -> list[Parameter]:
        """Declare several parameters; see :meth:`declare_parameter`.

        :param namespace: put before every name with a dot, unless it is empty.
        :param parameters: tuples of a name, and optionally value or type, and descriptor.
        :param ignore_override: whether to disregard the command line and parameter files.
        :raises TypeError: if a tuple is not of that form.
        """
        new: list[Parameter] = []
        descriptors: dict[str, Any] = {}
        for index, entry in enumerate(parameters):
            name, value, descriptor = self._declaration(namespace, index, entry)
            if not ignore_override and name in self._parameter_overrides:
                value = self._parameter_overrides[name].value
            if isinstance(value, ParameterValue):
                given = Parameter.from_parameter_msg(ParameterMsg(name=name, value=value))
                new.append(given)
            else:
                new.append(Parameter(name, value=value))
            descriptors[name] = descriptor
        already = [p.name for p in new if p.name in self._parameters]
        if already:
            raise ParameterAlreadyDeclaredException(already)
        for parameter in new:
            result = self._set_atomically([parameter], descriptors, keep_not_set=True)
            if result.successful:
                continue
            if result.reason.startswith("Wrong parameter type"):
                expected = Parameter.Type(descriptors[parameter.name].type).name
                raise InvalidParameterTypeException(parameter, expected)
            raise InvalidParameterValueException(parameter.name, parameter.value, result.reason)
        return [self._parameters[p.name] for p in new]

    def _declaration(self, namespace: str, index: int, entry: Any) -> tuple[str, Any, Any]:
        """Take a declaration apart, with the type noted in the descriptor."""
        if not 1 <= len(entry) <= 3:
            raise TypeError(
                f"Invalid parameter tuple length at index {index} in parameters list: "
                f"{entry}; expecting length between 1 and 3"
            )
        name = entry[0]
        if not isinstance(name, str):
            raise TypeError(
                f"First element {name} at index {index} in parameters list is not a str."
            )
        if namespace:
            name = f"{namespace}.{name}"
        validate_parameter_name(name)
        value = entry[1] if len(entry) > 1 else None
        descriptor = entry[2] if len(entry) > 2 else ParameterDescriptor()
        if not isinstance(descriptor, ParameterDescriptor):
            raise TypeError(
                f"Third element {descriptor} at index {index} in parameters list "
                "is not a ParameterDescriptor."
            )
        if len(entry) == 1:
            warnings.warn(
                f"when declaring parameter named '{name}', declaring a parameter only providing "
                "its name is deprecated. Pass a default value, a parameter type, or a "
                "descriptor with `dynamic_typing=True`",
                stacklevel=4,
            )
            descriptor.dynamic_typing = True
        if isinstance(value, Parameter.Type):
            if value == _NOT_SET:
                raise ValueError(
                    f"Cannot declare parameter {{{name}}} as statically typed of type NOT_SET"
                )
            if descriptor.dynamic_typing:
                raise ValueError(
                    f"When declaring parameter {{{name}}} passing a descriptor with"
                    "`dynamic_typing=True` is not allowed when the parameter type is provided"
                )
            descriptor.type = value.value
            return name, None, descriptor
        if not descriptor.dynamic_typing:
            if isinstance(value, ParameterValue):
                descriptor.type = value.type
            else:
                descriptor.type = Parameter.Type.from_parameter_value(value).value
            if descriptor.type == _NOT_SET.value:
                raise ValueError(
                    "Cannot declare a statically typed parameter with default value "
                    "of type PARAMETER_NOT_SET"
                )
        return name, value, descriptor

    def undeclare_parameter(self, name: str) -> None:
        """Forget a parameter.

        :raises ParameterNotDeclaredException: if it is not declared.
        :raises ParameterImmutableException: if it is read-only.
        """
        if not self.has_parameter(name):
            raise ParameterNotDeclaredException(name)
        if self._descriptors[name].read_only:
            raise ParameterImmutableException(name)
        del self._parameters[name]
        del self._descriptors[name]

    # Getting -----------------------------------------------------------------------------

    def has_parameter(self, name: str) -> bool:
        """Say whether a parameter is declared."""
        return name in self._parameters

    def get_parameter_types(self, names: list[str]) -> list[Any]:
        """Return the types of parameters; see :meth:`get_parameter_type`."""
        if not all(isinstance(name, str) for name in names):
            raise TypeError("All names must be instances of type str")
        return [self.get_parameter_type(name) for name in names]

    def get_parameter_type(self, name: str) -> Any:
        """Return the type of a parameter as its number.

        :raises ParameterNotDeclaredException: if it is not declared and has to be.
        """
        if name in self._parameters:
            return self._parameters[name].type_.value
        if self._allow_undeclared_parameters:
            return _NOT_SET
        raise ParameterNotDeclaredException(name)

    def get_parameters(self, names: list[str]) -> list[Parameter]:
        """Return several parameters; see :meth:`get_parameter`."""
        if not all(isinstance(name, str) for name in names):
            raise TypeError("All names must be instances of type str")
        return [self.get_parameter(name) for name in names]

    def get_parameter(self, name: str) -> Parameter:
        """Return a parameter.

        :raises ParameterNotDeclaredException: if it is not declared and has to be.
        :raises ParameterUninitializedException: if it has a type but no value yet.
        """
        parameter = self._parameters.get(name)
        if parameter is not None:
            if parameter.type_ != _NOT_SET or self._descriptors[name].dynamic_typing:
                return parameter
            raise ParameterUninitializedException(name)
        if self._allow_undeclared_parameters:
            return Parameter(name, _NOT_SET, None)
        raise ParameterNotDeclaredException(name)

    def get_parameter_or(self, name: str, alternative_value: Parameter | None = None) -> Parameter:
        """Return a parameter, or an alternative if it is not declared or has no value."""
        parameter = self._parameters.get(name)
        if parameter is not None and parameter.type_ != _NOT_SET:
            return parameter
        return Parameter(name, _NOT_SET) if alternative_value is None else alternative_value

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Parameter]:
        """Return the parameters below a prefix, by the rest of their names."""
        if prefix:
            prefix += PARAMETER_SEPARATOR_STRING
        return {
            name[len(prefix) :]: value
            for name, value in self._parameters.items()
            if name.startswith(prefix)
        }

    def list_parameters(self, prefixes: list[str], depth: int) -> Any:
        """Return the names of parameters as ``rcl_interfaces.msg.ListParametersResult``.

        :param prefixes: those wanted are below one of these; all if there is none.
        :param depth: how many levels below; 0 for any number.
        :raises TypeError: if an argument is of the wrong type.
        :raises ValueError: if the depth is negative.
        """
        if not isinstance(prefixes, list):
            raise TypeError("The prefixes argument must be a list")
        if not all(isinstance(prefix, str) for prefix in prefixes):
            raise TypeError("All prefixes must be instances of type str")
        if not isinstance(depth, int):
            raise TypeError("The depth must be instance of type int")
        if depth < 0:
            raise ValueError("The depth must be greater than or equal to zero")
        dot = PARAMETER_SEPARATOR_STRING

        def wanted(name: str) -> bool:
            if not prefixes:
                return depth == 0 or name.count(dot) < depth
            for prefix in prefixes:
                if name == prefix:
                    return True
                below = name.startswith(prefix + dot)
                if below and (depth == 0 or name[len(prefix) + 1 :].count(dot) < depth):
                    return True
            return False

        result = ListParametersResult()
        for name in filter(wanted, self._parameters):
            result.names.append(name)
            prefix, found, _ = name.rpartition(dot)
            if found and prefix not in result.prefixes:
                result.prefixes.append(prefix)
        return result

    # Setting -----------------------------------------------------------------------------

    def set_parameters(self, parameter_list: list[Parameter]) -> list[Any]:
        """Set parameters one after the other, and return a result for each.

        :raises ParameterNotDeclaredException: if one is not declared and has to be.
        """
        return [self.set_parameters_atomically([p]) for p in parameter_list]

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> Any:
        """Set all parameters or none, and return the result.

        :raises ParameterNotDeclaredException: if one is not declared and has to be.
        """
        for callback in self._pre_set_parameters_callbacks:
            parameter_list = callback(parameter_list)
        if self._pre_set_parameters_callbacks and not parameter_list:
            return SetParametersResult(
                successful=False,
                reason="parameter list cannot be empty, this might be due to "
                "pre_set_parameters_callback modifying the original parameters list.",
            )
        if not self._allow_undeclared_parameters:
            unknown = [p.name for p in parameter_list if p.name not in self._parameters]
            if unknown:
                raise ParameterNotDeclaredException(unknown)
        return self._set_atomically(parameter_list)

    def _set_atomically(
        self,
        parameters: list[Parameter],
        descriptors: dict[str, Any] | None = None,
        keep_not_set: bool = False,
    ) -> Any:
        """Set parameters, declared or not.

        :param descriptors: new descriptors; then read-only ones may be set.
        :param keep_not_set: whether to keep parameters without a value, rather than forget them.
        """
        used = self._descriptors if descriptors is None else descriptors
        for parameter in parameters:
            if parameter.name in used:
                refused = self._apply(parameter, used[parameter.name], descriptors is None)
                if refused:
                    return SetParametersResult(successful=False, reason=refused)
        for callback in self._on_set_parameters_callbacks:
            result = callback(parameters)
            if not result.successful:
                return result
        event = ParameterEvent(node=self.get_fully_qualified_name())
        for parameter in parameters:
            self._store(parameter, descriptors, keep_not_set, event)
        event.stamp = self._clock.now().to_msg()
        self._parameter_event_publisher.publish(event)
        for callback in self._post_set_parameters_callbacks:
            callback(parameters)
        return SetParametersResult(successful=True)

    def _store(
        self, parameter: Parameter, descriptors: Any, keep_not_set: bool, event: Any
    ) -> None:
        name = parameter.name
        if parameter.type_ == _NOT_SET and not keep_not_set:
            event.deleted_parameters.append(parameter.to_parameter_msg())
            self._parameters.pop(name, None)
            self._descriptors.pop(name, None)
            return
        if descriptors is not None:
            self._descriptors[name] = descriptors[name]
        elif name not in self._descriptors:
            self._descriptors[name] = ParameterDescriptor(dynamic_typing=True)
        new = self.get_parameter_or(name).type_ == _NOT_SET
        changes = event.new_parameters if new else event.changed_parameters
        changes.append(parameter.to_parameter_msg())
        self._parameters[name] = parameter

    def _apply(self, parameter: Parameter, descriptor: Any, check_read_only: bool) -> str:
        """Return why a descriptor refuses a parameter, nothing if it does not."""
        descriptor.name = parameter.name
        if check_read_only and descriptor.read_only:
            return f"Trying to set a read-only parameter: {parameter.name}."
        not_set = parameter.type_ == _NOT_SET
        if descriptor.dynamic_typing:
            descriptor.type = parameter.type_.value
        elif not_set and self.has_parameter(parameter.name):
            return "Static parameter cannot be undeclared"
        elif not not_set and parameter.type_.value != descriptor.type:
            return (
                f"Wrong parameter type, expected '{Parameter.Type(descriptor.type)}' got "
                f"'{parameter.type_}'"
            )
        return _parameter_limits.refusal(parameter, descriptor)

    # Callbacks and descriptors -----------------------------------------------------------

    def add_pre_set_parameters_callback(self, callback: Callable[[Any], Any]) -> None:
        """Have a function called before parameters are checked; it returns those to be set."""
        self._pre_set_parameters_callbacks.insert(0, callback)

    def add_on_set_parameters_callback(self, callback: Callable[[Any], Any]) -> None:
        """Have a function called that may refuse new values, with a
        ``rcl_interfaces.msg.SetParametersResult``."""
        self._on_set_parameters_callbacks.insert(0, callback)

    def add_post_set_parameters_callback(self, callback: Callable[[Any], None]) -> None:
        """Have a function called once parameters are set."""
        self._post_set_parameters_callbacks.insert(0, callback)

    def remove_pre_set_parameters_callback(self, callback: Callable[[Any], Any]) -> None:
        """Undo the addition of a callback; ValueError if there was none."""
        self._pre_set_parameters_callbacks.remove(callback)

    def remove_on_set_parameters_callback(self, callback: Callable[[Any], Any]) -> None:
        """Undo the addition of a callback; ValueError if there was none."""
        self._on_set_parameters_callbacks.remove(callback)

    def remove_post_set_parameters_callback(self, callback: Callable[[Any], None]) -> None:
        """Undo the addition of a callback; ValueError if there was none."""
        self._post_set_parameters_callbacks.remove(callback)

    def describe_parameter(self, name: str) -> Any:
        """Return a parameter's descriptor.

        :raises ParameterNotDeclaredException: if it is not declared and has to be.
        """
        if name in self._descriptors:
            return self._descriptors[name]
        if self._allow_undeclared_parameters:
            return ParameterDescriptor()
        raise ParameterNotDeclaredException(name)

    def describe_parameters(self, names: list[str]) -> list[Any]:
        """Return several descriptors; see :meth:`describe_parameter`."""
        return [self.describe_parameter(name) for name in names]

    def set_descriptor(self, name: str, descriptor: Any, alternative_value: Any = None) -> Any:
        """Give a parameter another descriptor, and return its value after that.

        :param alternative_value: value to take if the descriptor refuses the present one.
        :raises ParameterNotDeclaredException: if it is not declared and has to be.
        :raises ParameterImmutableException: if it is read-only.
        :raises InvalidParameterValueException: if the descriptor refuses both values.
        """
        if not self.has_parameter(name):
            if not self._allow_undeclared_parameters:
                raise ParameterNotDeclaredException(name)
            return self.get_parameter(name).get_parameter_value()
        if self.describe_parameter(name).read_only:
            raise ParameterImmutableException(name)
        chosen = self.get_parameter(name)
        if self._apply(chosen, descriptor, False):
            if alternative_value is not None:
                chosen = Parameter.from_parameter_msg(
                    ParameterMsg(name=name, value=alternative_value)
                )
            refused = self._apply(chosen, descriptor, False)
            if refused:
                raise InvalidParameterValueException(name, chosen.value, refused)
        self._parameters[name] = chosen
        self._descriptors[name] = descriptor
        return chosen.get_parameter_value()
