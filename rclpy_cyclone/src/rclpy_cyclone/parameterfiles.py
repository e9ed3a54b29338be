"""Parameter values from the command line (``-p``) and from parameter files.

The type of a value follows rcl's YAML rules, which are YAML 1.1's for plain scalars.
"""

from __future__ import annotations

import re
from typing import Any

import yaml

_INT = re.compile(r"[-+]?(0x[0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)\Z")
_FLOAT = re.compile(
    r"[-+]?(([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?"
    r"|\.(inf|Inf|INF)|(?i:inf|infinity|nan))\Z|\.(nan|NaN|NAN)\Z",
)
_STR = "tag:yaml.org,2002:str"
_TRUE = ("Y", "y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON")
_FALSE = ("N", "n", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF")


def parse_rule(text: str) -> tuple[str, str, Any]:
    """Read ``[node:]name:=value`` as ``(node pattern, name, value)``.

    :raises ValueError: if it is not such a rule, or the value is not one of a parameter.
    """
    left, assigned, value = text.partition(":=")
    if not assigned:
        raise ValueError(f"{text!r} is not a parameter assignment: there is no ':='")
    node, colon, name = left.rpartition(":")
    if not name or (colon and not node):
        raise ValueError(f"{text!r} has no parameter name")
    if not re.match(r"[A-Za-z_][\w./]*\Z", name):
        raise ValueError(f"{name!r} is not a parameter name")
    try:
        tree = yaml.compose(value, Loader=yaml.SafeLoader)
    except yaml.YAMLError as error:
        raise ValueError(f"{value!r} is not YAML: {error}") from error
    if not value.strip():
        raise ValueError(f"{name!r} has no value")
    if tree is None:  # a comment, say
        return (node or "/**"), name, None
    return (node or "/**"), name, _value(tree, name)


def read(path: str) -> list[tuple[str, str, Any]]:
    """Read a parameter file as ``(node pattern, name, value)``, in its order.

    :raises ValueError: if it cannot be read, or is not a parameter file.
    """
    try:
        with open(path, encoding="utf-8") as file:
            tree = yaml.compose(file, Loader=yaml.SafeLoader)
    except OSError as error:
        raise ValueError(f"cannot open parameter file: {error}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ValueError(f"parameter file {path!r} is not YAML: {error}") from error
    if tree is None:
        return []
    if not isinstance(tree, yaml.MappingNode):
        raise ValueError(f"parameter file {path!r} does not begin with node names")
    found: list[tuple[str, str, Any]] = []
    _nodes(tree, "", found, path)
    return found


def _nodes(tree: yaml.MappingNode, prefix: str, found: list[Any], path: str) -> None:
    for key, below in tree.value:
        name = str(key.value)
        full = f"{prefix}/{name.lstrip('/')}" if prefix or name.startswith("/") else name
        full = "/" + full.lstrip("/")
        if not isinstance(below, yaml.MappingNode):
            raise ValueError(f"{path!r}: there should be parameters or nodes below {full!r}")
        for inner, content in below.value:
            if inner.value == "ros__parameters":
                if not isinstance(content, yaml.MappingNode):
                    if isinstance(content, yaml.ScalarNode) and not content.value:
                        continue
                    raise ValueError(f"{path!r}: ros__parameters of {full!r} is no mapping")
                _parameters(content, "", full, found)
            else:
                rest = yaml.MappingNode(below.tag, [(inner, content)])
                _nodes(rest, full, found, path)


def _parameters(tree: yaml.MappingNode, prefix: str, node: str, found: list[Any]) -> None:
    for key, below in tree.value:
        name = f"{prefix}{key.value}"
        if isinstance(below, yaml.MappingNode):
            if not below.value:
                raise ValueError(f"parameter {name!r}: an empty mapping is no value")
            _parameters(below, f"{name}.", node, found)
        else:
            found.append((node, name, _value(below, name)))


def _value(tree: Any, name: str) -> Any:
    if isinstance(tree, yaml.ScalarNode):
        return _scalar(tree, name)
    if isinstance(tree, yaml.SequenceNode):
        if not all(isinstance(item, yaml.ScalarNode) for item in tree.value):
            raise ValueError(f"parameter {name!r}: a list must hold plain values")
        values = [_scalar(item, name) for item in tree.value]
        if len({type(v) for v in values}) > 1:
            raise ValueError(f"parameter {name!r}: a list must hold values of one type")
        if not values:
            return None  # its type cannot be told, so that it counts as not set
        return values
    raise ValueError(f"parameter {name!r}: nested values are not allowed here")


def _scalar(node: yaml.ScalarNode, name: str) -> Any:
    text = node.value
    if node.style is not None or (node.tag == _STR != _implicit(text)):
        return text  # quoted, or tagged !!str
    if not text:
        raise ValueError(f"parameter {name!r} has no value")
    if text in _TRUE:
        return True
    if text in _FALSE:
        return False
    if _INT.match(text):
        value = int(text, 8) if re.match(r"[-+]?0[0-7]+\Z", text) else int(text, 0)
        if -(2**63) <= value < 2**63:
            return value
    if _FLOAT.match(text):
        number = float(text.replace(".", "") if text[-1] in "fFnNyY" else text)
        if abs(number) != float("inf") or text[-1] in "fFyY":  # too large a number is a text
            return number
    return text


def _implicit(text: str) -> str:
    """Return the tag that YAML gives to a plain text without one."""
    return str(yaml.resolver.Resolver().resolve(yaml.ScalarNode, text, (True, False)))


def matches(pattern: str, full_node_name: str) -> bool:
    """Say whether a node pattern (``*`` one token, ``**`` any number) covers a node."""
    if not pattern.startswith("/"):
        pattern = "/" + pattern
    parts = pattern.replace("/**", "\0").replace("/*", "\1")
    regex = re.escape(parts).replace("\0", r"(/\w+)*").replace("\1", r"(/\w+)")
    regex = regex.replace("\\\x00", r"(/\w+)*").replace("\\\x01", r"(/\w+)")
    return re.match(regex + r"\Z", full_node_name) is not None
