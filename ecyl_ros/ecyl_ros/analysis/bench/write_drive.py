"""The identified transmission in a drive file: the file's text kept, three values put in.

The drive file gets the model that the paper makes of its own measurement, equations (5) and (8): a
dead zone of 2 (k1 - k2) T1, which leaves the second line where it was measured, and beyond it one
stiffness per segment.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from ...drive.drive_file import drive_to_flat, load_drive, read_parameter_file, resolve_drive
from ...errors import InputError
from ...recording.atomic import replacing
from .identify import Identified

GROUP = "transmission"
_DIGITS = 9


def transmission_values(identified: Identified) -> dict[str, Any]:
    """backlash, stiffness and stiffness_breaks as a drive file has them."""
    stiffness = [_rounded(one.nm_per_rad.value) for one in identified.stiffness]
    breaks = [_rounded(one.from_nm) for one in identified.stiffness[1:]]
    return {
        "backlash": _rounded(max(identified.fit.clearance_rad.value, 0.0)),
        "stiffness": stiffness,
        "stiffness_breaks": breaks,
    }


def write_drive(identified: Identified, drive: str | os.PathLike[str], out: str | Path) -> None:
    """Write the drive file (or profile) `drive` with the transmission found to `out`.

    What comes out is read back before it takes its place: it must be the drive with these three
    values, nothing else.

    Raises:
        InputError: the file has no block `transmission` that can be changed without disturbing
            others, the values are not possible in a drive file, or `out` cannot be written.
    """
    source = resolve_drive(drive)
    values = transmission_values(identified)
    wanted = drive_to_flat(load_drive(source))
    wanted |= {f"{GROUP}.{name}": value for name, value in values.items()}
    text = source.read_bytes().decode("utf-8")
    changed = _changed(text, values, _remarks(identified))
    with replacing(out) as temporary:
        temporary.write_bytes(changed.encode("utf-8"))
        try:
            same = bool(changed) and drive_to_flat(load_drive(temporary)) == wanted
        except InputError as error:
            reason = str(error).replace(str(temporary), str(out))
            raise InputError(f"{reason}: found on the bench, not written") from None
        if not same:
            read_parameter_file(source)
            raise InputError(
                f"{source}: laid out in a way that {GROUP} cannot be changed in; expected one "
                "block of it below '/**: ros__parameters:'"
            )


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def _remarks(identified: Identified) -> dict[str, str]:
    """A comment for each value; the old one told of the old value."""
    name = "".join(c if c.isprintable() else "?" for c in Path(identified.loop.source).name)
    zone = identified.fit.clearance_rad
    slopes = " and ".join(
        f"{one.nm_per_rad.low:.6g} to {one.nm_per_rad.high:.6g}" for one in identified.stiffness
    )
    remarks = {
        "backlash": f"rad, ecyl bench on {name}, 95 %: {zone.low:.6g} to {zone.high:.6g}",
        "stiffness": f"N m / rad, ecyl bench on {name}, 95 %: {slopes}",
    }
    corner = identified.fit.t2_nm
    if corner is not None:
        found = f"95 %: {corner.low:.5g} to {corner.high:.5g}"
        remarks["stiffness_breaks"] = f"N m, ecyl bench on {name}, {found}"
    return remarks


def _changed(text: str, values: Mapping[str, Any], remarks: Mapping[str, str]) -> str:
    """The text with the values in its one transmission block; empty where there is not one."""
    blocks = _blocks(yaml.compose(text, Loader=yaml.SafeLoader))
    if len(blocks) != 1:
        return ""
    block = blocks[0]
    edits: list[tuple[int, int, str]] = []
    present = {key.value: value for key, value in block.value}
    for name, value in values.items():
        if name in present:
            node = present[name]
            if isinstance(node, yaml.CollectionNode) and not node.flow_style:
                return ""  # a list over several lines
            stop = _comment_end(text, node.end_mark.index) if name in remarks else None
            new = _yaml(value) if stop is None else f"{_yaml(value)}  # {remarks[name]}"
            edits.append((node.start_mark.index, stop or node.end_mark.index, new))
        elif value or not isinstance(value, list):
            first = block.value[0][0].start_mark
            gap = ", " if block.flow_style else "\n" + " " * first.column
            edits.append((first.index, first.index, f"{name}: {_yaml(value)}{gap}"))
    for start, stop, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[stop:]
    return text


def _comment_end(text: str, index: int) -> int | None:
    """End of the line that a value ends on, if nothing but a comment follows it; else None."""
    stop = text.find("\n", index)
    stop = len(text) if stop < 0 else stop
    rest = text[index:stop].rstrip("\r")
    return index + len(rest) if not rest.strip() or rest.lstrip().startswith("#") else None


def _blocks(node: yaml.Node | None) -> list[yaml.MappingNode]:
    found: list[yaml.MappingNode] = []
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            if key.value == GROUP and isinstance(value, yaml.MappingNode) and value.value:
                found.append(value)
            elif key.value != "tolerances":  # which has groups of the same names
                found += _blocks(value)
    return found


def _yaml(value: Any) -> str:
    """With a dot, so that YAML 1.1 and ROS alike read a float."""
    if isinstance(value, list):
        return "[" + ", ".join(_yaml(one) for one in value) + "]"
    text = repr(float(value))
    mantissa, mark, exponent = text.partition("e")
    return f"{mantissa}.0e{exponent}" if mark and "." not in mantissa else text
