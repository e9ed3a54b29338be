"""The ranges of a parameter's descriptor."""

from __future__ import annotations

import math
from typing import Any

from rclpy.parameter import Parameter

REL_TOL = 1e-6


def refusal(parameter: Parameter, descriptor: Any) -> str:
    """Return why a descriptor's range refuses a value, nothing if it does not."""
    if parameter.type_ == Parameter.Type.INTEGER and descriptor.integer_range:
        return _integer(parameter, descriptor.integer_range[0])
    if parameter.type_ == Parameter.Type.DOUBLE and descriptor.floating_point_range:
        return _floating(parameter, descriptor.floating_point_range[0])
    return ""


def _integer(parameter: Parameter, limits: Any) -> str:
    low, high = sorted((limits.from_value, limits.to_value))
    value = parameter.value
    if value in (low, high):
        return ""
    if not low < value < high:
        return f"Parameter {parameter.name} out of range. Min: {low}, Max: {high}, value: {value}"
    if limits.step and (value - low) % limits.step:
        return (
            f"The parameter value for {parameter.name} is not a valid step. "
            f"Min: {low}, max: {high}, value: {value}, step: {limits.step}"
        )
    return ""


def _floating(parameter: Parameter, limits: Any) -> str:
    low, high = sorted((limits.from_value, limits.to_value))
    value = parameter.value
    if any(math.isclose(value, edge, rel_tol=REL_TOL) for edge in (low, high)):
        return ""
    if not low < value < high:
        return f"Parameter {parameter.name} out of range Min: {low}, Max: {high}, value: {value}"
    if limits.step:
        steps = round((value - low) / limits.step)
        if not math.isclose(low + steps * limits.step, value, rel_tol=REL_TOL):
            return (
                f"The parameter value for {parameter.name} is not close enough to a valid step. "
                f"Min: {low}, max: {high}, value: {value}, step: {limits.step}"
            )
    return ""
