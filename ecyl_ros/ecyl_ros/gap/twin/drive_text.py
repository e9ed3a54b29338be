"""Values changed in the text of a drive file, and effects added; comments and order kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import yaml

SECTION = "ros__parameters"
Effects = Mapping[str, Mapping[str, Any]]  # numbers, text, and lists and mappings of such


def number(value: float) -> str:
    """A number that YAML 1.1 and ROS alike read as a float: with a dot."""
    text = repr(float(value))
    mantissa, mark, exponent = text.partition("e")
    return f"{mantissa}.0e{exponent}" if mark and "." not in mantissa else text


def entry(value: Any) -> str:
    """A value on one line: a number, a name, a list or a mapping of such."""
    if isinstance(value, str):
        return value
    if isinstance(value, Mapping):
        return _flow(value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(entry(one) for one in value) + "]"
    return number(value)


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


def holds(text: str, key: str) -> bool:
    """Whether the text of a drive file has something under a dotted key."""
    return any(True for section in sections(text) for _ in _nodes(section, key))


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


def add_effects(text: str, effects: Effects, remarks: Mapping[str, str]) -> str:
    """The text of a drive file with `effects` in it.

    remarks: comments by effect, by "effect.parameter", and "" for the head of what is added.

    Raises:
        ValueError: no `ros__parameters` to add to.
    """
    newline = "\r\n" if "\r\n" in text else "\n"
    edits: list[tuple[int, int, str]] = []
    for indent, section in _sections(text):
        existing = _value(section, "effects")
        if existing is None:
            edits.append(_entry(text, section, _Tree(effects, remarks), indent, newline))
        elif isinstance(existing, yaml.MappingNode):
            edits += _merged(text, existing, effects, remarks, indent, newline)
        else:
            raise ValueError("effects is no mapping")
    if not edits:
        raise ValueError(f"no {SECTION}")
    for start, stop, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[stop:]
    return text


def _sections(text: str) -> list[tuple[int, yaml.MappingNode]]:
    """Blocks of parameters that effects belong in, each with its step of indentation."""
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    found: dict[str, tuple[int, yaml.MappingNode]] = {}
    for key, content in root.value if isinstance(root, yaml.MappingNode) else ():
        if not isinstance(content, yaml.MappingNode):
            continue
        for inner, values in content.value:
            if inner.value == SECTION and isinstance(values, yaml.MappingNode):
                step = values.start_mark.column - inner.start_mark.column
                found[str(key.value)] = (step if 0 < step <= 8 else 2, values)
    # What holds for all nodes is the place; without it every node is told.
    everywhere = [name for name in found if name.strip("/") == "**"]
    return [found[everywhere[-1]]] if everywhere else list(found.values())


def _value(mapping: yaml.MappingNode, key: str) -> yaml.Node | None:
    return next((value for name, value in mapping.value if name.value == key), None)


class _Tree:
    """Effects as YAML, in either of its styles."""

    def __init__(
        self, effects: Effects, remarks: Mapping[str, str], *, within: bool = False
    ) -> None:
        self.effects, self.remarks, self.within = effects, remarks, within

    def flow(self) -> str:
        """On one line, without remarks."""
        inner = ", ".join(f"{name}: {_flow(values)}" for name, values in self.effects.items())
        return inner if self.within else f"effects: {{{inner}}}"

    def block(self, indent: int) -> list[str]:
        """On lines of their own."""
        lines = [f"# {self.remarks['']}"] if "" in self.remarks else []
        margin = ""
        if not self.within:
            lines.append("effects:")
            margin = " " * indent
        for name, values in self.effects.items():
            remark = f"  # {self.remarks[name]}" if name in self.remarks else ""
            lines.append(f"{margin}{name}:{remark}")
            lines += [margin + " " * indent + one for one in _lines(name, values, self.remarks)]
        return lines


def _lines(name: str, values: Mapping[str, Any], remarks: Mapping[str, str]) -> list[str]:
    pairs = [
        (f"{key}: {entry(value)}", remarks.get(f"{name}.{key}")) for key, value in values.items()
    ]
    width = max((len(text) for text, remark in pairs if remark), default=0)
    return [f"{text.ljust(width)}  # {remark}" if remark else text for text, remark in pairs]


def _flow(values: Mapping[str, Any]) -> str:
    return "{" + ", ".join(f"{key}: {entry(value)}" for key, value in values.items()) + "}"


def _end(node: yaml.Node) -> int:
    """Where the text of a node ends, without what follows it."""
    if not isinstance(node, yaml.CollectionNode) or node.flow_style or not node.value:
        return int(node.end_mark.index)
    if isinstance(node, yaml.MappingNode):
        return max(max(_end(key), _end(value)) for key, value in node.value)
    return max(_end(value) for value in node.value)


def _line_end(text: str, index: int) -> int:
    """The end of the line that holds the character before `index`, before its line break."""
    stop = text.find("\n", max(index - 1, 0))
    stop = len(text) if stop < 0 else stop
    return stop - 1 if stop > 0 and text[stop - 1] == "\r" else stop


def _entry(
    text: str, mapping: yaml.MappingNode, tree: _Tree, indent: int, newline: str
) -> tuple[int, int, str]:
    """The edit that puts `tree` at the end of a mapping."""
    if mapping.flow_style:
        if not mapping.value:
            at = mapping.start_mark.index + 1
            return at, at, tree.flow()
        at = max(_end(value) for _, value in mapping.value)
        return at, at, f", {tree.flow()}"
    margin = newline + " " * mapping.start_mark.column
    at = _line_end(text, _end(mapping))
    return at, at, "".join(margin + line for line in tree.block(indent))


def _merged(
    text: str,
    existing: yaml.MappingNode,
    effects: Effects,
    remarks: Mapping[str, str],
    indent: int,
    newline: str,
) -> list[tuple[int, int, str]]:
    """The edits that put `effects` into a mapping of effects."""
    edits = []
    fresh: dict[str, Mapping[str, Any]] = {}
    for name, values in effects.items():
        old = _value(existing, name)
        if old is None:
            fresh[name] = values
        elif not isinstance(old, yaml.MappingNode) or old.flow_style:
            edits.append((old.start_mark.index, _end(old), _flow(values)))
        else:
            margin = newline + " " * old.start_mark.column
            new = margin.join(_lines(name, values, remarks))
            edits.append((old.start_mark.index, _line_end(text, _end(old)), new))
    if fresh:
        tree = _Tree(fresh, remarks, within=True)
        edits.append(_entry(text, existing, tree, indent, newline))
    return edits


def add_values(text: str, values: Mapping[str, float | list[float]]) -> str:
    """The text of a drive file with numbers under dotted keys that it has not.

    Among the others of their group where the file has one; else behind all that stands there, with
    their dotted name where the file has others of their group so, or in a group of their own.

    Raises:
        ValueError: a group that holds no keys, such as one tolerance of all constants.
    """
    newline = "\r\n" if "\r\n" in text else "\n"
    edits: list[tuple[int, str]] = []
    for _, section in _sections(text):
        dotted = {node.value.partition(".")[0] for node, _ in section.value if "." in node.value}
        fresh: dict[str, list[str]] = {}
        for key, value in values.items():
            name, _, inner = key.partition(".")
            group = _value(section, name)
            shown = entry(value)
            if group is None and name in dotted:
                edits.append(_behind(text, section, f"{key}: {shown}", newline))
                continue
            if group is None:
                fresh.setdefault(name, []).append(f"{inner}: {shown}")
                continue
            if not isinstance(group, yaml.MappingNode):
                raise ValueError(f"{name} holds no keys")
            if not group.value:
                edits.append((group.start_mark.index + 1, f"{inner}: {shown}"))
                continue
            first = group.value[0][0].start_mark
            between = ", " if group.flow_style else newline + " " * first.column
            edits.append((first.index, f"{inner}: {shown}{between}"))
        for name, entries in fresh.items():
            made = f"{name}: {{{', '.join(entries)}}}"
            edits.append(_behind(text, section, made, newline))
    for at, new in sorted(edits, reverse=True):
        text = text[:at] + new + text[at:]
    return text


def _behind(text: str, section: yaml.MappingNode, made: str, newline: str) -> tuple[int, str]:
    """Where an entry goes behind all others of a section, and what is put there."""
    if section.flow_style:
        return max(_end(one) for _, one in section.value), f", {made}"
    margin = newline + " " * section.start_mark.column
    return _line_end(text, _end(section)), f"{margin}{made}"
