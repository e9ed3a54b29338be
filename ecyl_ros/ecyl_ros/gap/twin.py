"""The closer twin: the user's drive file with the constants that were found, and the causes.

The file's text is kept, comments and order included: found constants take the place of the nominal
ones, causes are put in under `effects`. What comes out is read back before it takes its place: it
must be the nominal drive with these, nothing else.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import yaml

from ..drive.drive_file import drive_to_flat, load_drive, resolve_drive
from ..drive.parameters import DriveParameters
from ..drive.tolerances import with_constants
from ..effects.catalogue import CATALOGUE
from ..errors import InputError
from ..recording.atomic import replacing
from .diagnosis import Diagnosis
from .drive_text import SECTION, number, with_values

Effects = Mapping[str, Mapping[str, float]]
_DIGITS = 9


def write_twin(diagnosis: Diagnosis, drive: str | os.PathLike[str], out: str | Path) -> None:
    """Write the drive file (or profile) `drive` with what the diagnosis found to `out`.

    Written whole or not at all. An effect that the file has already gets the values found.

    Raises:
        InputError: nothing was found, the file cannot be changed without disturbing it, or `out`
            cannot be written.
    """
    if not diagnosis.closes:
        raise InputError(f"{out}: not written, for no cause was named")
    source = resolve_drive(drive)
    nominal = load_drive(source)
    effects = {one.effect: _rounded(one.effect, diagnosis) for one in diagnosis.causes}
    constants, lead = _constants(diagnosis, nominal)
    notes = remarks(diagnosis)
    if lead is not None:
        effects["lead_error"] = {"lead_m": lead}
        notes["lead_error"] = "within its tolerance; the controller goes on believing the sheet"
    text = source.read_bytes().decode("utf-8")
    wanted = _added(with_constants(nominal, constants), effects)
    try:
        changed = with_values(text, _as_written(nominal, constants))
        changed = add_effects(changed, effects, notes) if effects else changed
    except ValueError:
        changed = ""
    write_checked(out, changed, lambda path: _reads_as(path, wanted), source, effects)


def _constants(
    diagnosis: Diagnosis, drive: DriveParameters
) -> tuple[dict[str, float], float | None]:
    """Found constants by key, and the lead if it was found off the sheet.

    The controller turns its reference into a rotor angle by the sheet's lead and gear ratio, which
    must therefore stay in the file.
    """
    found = {
        one.parameter: float(f"{one.value:.{_DIGITS}g}")
        for one in diagnosis.sheet
        if one.value != one.nominal
    }
    lead = found.pop("transmission.lead", drive.transmission.lead)
    ratio = found.pop("transmission.gear_ratio", drive.transmission.gear_ratio)
    lead *= drive.transmission.gear_ratio / ratio
    return found, None if lead == drive.transmission.lead else float(f"{lead:.{_DIGITS}g}")


def _as_written(
    drive: DriveParameters, constants: Mapping[str, float]
) -> dict[str, float | list[float]]:
    """Constants as the file holds them: every segment of a piecewise stiffness."""
    changed = with_constants(drive, constants)
    found: dict[str, float | list[float]] = dict(constants)
    if "transmission.stiffness" in found:
        found["transmission.stiffness"] = list(changed.transmission.stiffness)
    return found


def write_checked(
    out: str | Path,
    text: str,
    reads_back: Callable[[Path], bool],
    source: Path,
    effects: Iterable[str],
) -> None:
    """Write a twin's `text` to `out`, whole or not at all, if it `reads_back` as what is wanted.

    Raises:
        InputError: it does not, or there is no text: `source` cannot take the `effects`.
    """
    with replacing(out) as temporary:
        temporary.write_bytes(text.encode("utf-8"))
        if not (text and reads_back(temporary)):
            keys = ", ".join(f"effects.{name}" for name in effects)
            raise InputError(
                f"{source}: laid out in a way that {keys} cannot be added to; expected one block "
                "of parameters below '/**: ros__parameters:'"
            )


def _rounded(effect: str, diagnosis: Diagnosis) -> dict[str, float]:
    quantities = {one.name: one for one in CATALOGUE[effect].parameters}
    found = {}
    for name, value in diagnosis.values[effect].items():
        rounded = float(f"{value:.{_DIGITS}g}")
        found[name] = min(max(rounded, quantities[name].low), quantities[name].high)
    return found


def _added(drive: DriveParameters, effects: Effects) -> dict[str, object]:
    flat = {
        key: value
        for key, value in drive_to_flat(drive).items()
        if not any(key.startswith(f"effects.{name}.") for name in effects)
    }
    for name, values in effects.items():
        full = CATALOGUE[name].complete(values)
        flat |= {f"effects.{name}.{parameter}": value for parameter, value in full.items()}
    return flat


def _reads_as(path: Path, wanted: Mapping[str, object]) -> bool:
    try:
        return drive_to_flat(load_drive(path)) == wanted
    except InputError:
        return False


def remarks(diagnosis: Diagnosis) -> dict[str, str]:
    """Comments by effect and by "effect.parameter"; "" stands for all."""
    name = _printable(Path(diagnosis.source).name)
    found = {"": f"Added by ecyl diagnose: what {name} shows beyond the model above."}
    for cause in diagnosis.causes:
        found[cause.effect] = f"{cause.title}, confidence {min(cause.confidence, 0.99):.2f}"
        for one in cause.parameters:
            unit = "" if one.unit == "1" else f"{one.unit}, "
            found[f"{cause.effect}.{one.name}"] = f"{unit}95 %: {one.low:.6g} to {one.high:.6g}"
    return found


def _printable(text: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in text)


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


def _lines(name: str, values: Mapping[str, float], remarks: Mapping[str, str]) -> list[str]:
    pairs = [
        (f"{key}: {number(value)}", remarks.get(f"{name}.{key}")) for key, value in values.items()
    ]
    width = max((len(text) for text, remark in pairs if remark), default=0)
    return [f"{text.ljust(width)}  # {remark}" if remark else text for text, remark in pairs]


def _flow(values: Mapping[str, float]) -> str:
    return "{" + ", ".join(f"{key}: {number(value)}" for key, value in values.items()) + "}"


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
    fresh: dict[str, Mapping[str, float]] = {}
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
