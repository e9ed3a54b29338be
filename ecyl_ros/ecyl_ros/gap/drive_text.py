"""Values changed in the text of a drive file, comments and order kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import yaml

SECTION = "ros__parameters"


def number(value: float) -> str:
    """A number that YAML 1.1 and ROS alike read as a float: with a dot."""
    text = repr(float(value))
    mantissa, mark, exponent = text.partition("e")
    return f"{mantissa}.0e{exponent}" if mark and "." not in mantissa else text


def with_values(text: str, values: Mapping[str, float | list[float]]) -> str:
    """The text of a drive file with other numbers under dotted keys that it has.

    Where several blocks of parameters hold a key, all are changed.

    Raises:
        ValueError: a key that the text does not hold as a number or a list of as many numbers.
    """
    edits: list[tuple[int, int, str]] = []
    for key, value in values.items():
        found = [node for section in sections(text) for node in _nodes(section, key)]
        if not found:
            raise ValueError(f"no {key}")
        for node in found:
            edits += _edits(node, value, key)
    for start, stop, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[stop:]
    return text


def sections(text: str) -> Iterator[yaml.MappingNode]:
    """Every block of parameters in a drive file."""
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    for _, content in root.value if isinstance(root, yaml.MappingNode) else ():
        for key, values in content.value if isinstance(content, yaml.MappingNode) else ():
            if key.value == SECTION and isinstance(values, yaml.MappingNode):
                yield values


def _nodes(mapping: yaml.MappingNode, key: str) -> Iterator[yaml.Node]:
    """What stands under a dotted key, however its parts are nested."""
    for name, value in mapping.value:
        if name.value == key:
            yield value
        elif key.startswith(f"{name.value}.") and isinstance(value, yaml.MappingNode):
            yield from _nodes(value, key.removeprefix(f"{name.value}."))


def _edits(node: yaml.Node, value: float | list[float], key: str) -> list[tuple[int, int, str]]:
    if isinstance(value, list):
        parts = node.value if isinstance(node, yaml.SequenceNode) else [node]
        if len(parts) != len(value):
            raise ValueError(f"{key} has {len(parts)} values")
        return [
            edit for one, part in zip(parts, value, strict=True) for edit in _edits(one, part, key)
        ]
    if not isinstance(node, yaml.ScalarNode):
        raise ValueError(f"{key} is no number")
    return [(node.start_mark.index, node.end_mark.index, number(value))]
