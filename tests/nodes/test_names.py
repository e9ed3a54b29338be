"""No node of ours overwrites an attribute that rclpy's Node keeps for itself."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import ecyl_ros

# Private attributes of rclpy 7.1's Node (rclpy/node.py). Ours on rclpy_cyclone has other names, so
# that a clash would show on genuine ROS 2 alone, as a clock or a logger that is something else.
_RCLPYS_OWN = {
    *("_allow_undeclared_parameters", "_clients", "_clock", "_context"),
    *("_default_callback_group", "_descriptors", "_guards", "_logger", "_logger_service"),
    *("_on_set_parameters_callbacks", "_parameter_event_publisher", "_parameter_overrides"),
    *("_parameter_service", "_parameters", "_post_set_parameters_callbacks"),
    *("_pre_set_parameters_callbacks", "_publishers", "_rate_group", "_services"),
    *("_subscriptions", "_time_source", "_timers", "_type_description_service"),
}
_PACKAGE = Path(ecyl_ros.__file__).parent
_FILES = sorted((*(_PACKAGE / "nodes").glob("*.py"), *(_PACKAGE / "gap" / "live").glob("*.py")))


def _of_nodes(tree: ast.Module) -> set[str]:
    """Attributes that classes derived from a node class set on themselves."""
    return {
        target.attr
        for made in ast.walk(tree)
        if isinstance(made, ast.ClassDef)
        and any("Node" in ast.unparse(base) for base in made.bases)
        for target in ast.walk(made)
        if isinstance(target, ast.Attribute)
        and isinstance(target.ctx, ast.Store)
        and ast.unparse(target.value) == "self"
    }


@pytest.mark.parametrize("path", _FILES, ids=lambda path: path.stem)
def test_no_node_overwrites_what_rclpy_keeps(path: Path) -> None:
    """A node's own attributes have other names than rclpy's."""
    assert not _of_nodes(ast.parse(path.read_text(encoding="utf-8"))) & _RCLPYS_OWN


def test_the_scan_sees_an_attribute_that_clashes() -> None:
    """The scan finds `self._clock` of a class derived from Node, and not that of another class."""
    seen = _of_nodes(ast.parse("class A(Node):\n def f(self):\n  self._clock = 1\nclass B: pass"))
    assert seen == {"_clock"}
