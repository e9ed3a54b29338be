"""The pages of the effects: `python docs/effects/pages.py` writes them, prints effects.md's tables.

One page for each effect: its own file's words, parameters and equation, the recording that its
picture shows, and what a diagnosis of that recording found (confusion.json).
"""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from examples import DRIVE, EXAMPLES, Example
from panels import LEFT, OVER, SPECTRUM, TRACES

from ecyl_ros.drive.drive_file import load_drive, resolve_drive
from ecyl_ros.drive.packed import pack
from ecyl_ros.effects import ports
from ecyl_ros.effects.catalogue import CATALOGUE, MODULES, RIGID
from ecyl_ros.effects.effect import BLOCKS, Effect, Quantity
from ecyl_ros.recording.atomic import write_text

HERE = Path(__file__).parent
SOURCES = "../../ecyl_ros/ecyl_ros/effects"
RIGID_TOO = (
    "A [rigid drive](../drive-file.md#rigid-drives-and-followers) can have it too, at its "
    "output and with the parameters and the form of the table there."
)
OPENING = (
    "After this page you can recognise this effect in a recording, add it to a drive, and know "
    "what it is confused with."
)
SURE = 1.1  # times a perfect model's misfit: an effect that leaves no more is not told apart


def _plain(block: str) -> str:
    return block.replace("_", " ")


def _yaml(values: Mapping[str, float]) -> str:
    return "{" + ", ".join(f"{key}: {value!r}" for key, value in values.items()) + "}"


def _link(name: str, *, begins: bool = False) -> str:
    title = CATALOGUE[name].title
    return f"[{_capital(title) if begins else title}]({name}.md)"


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _capital(words: str) -> str:
    return words[0].upper() + words[1:]


def port_rows() -> str:
    """The table of the ports, as their file has it."""
    lines = (inspect.getdoc(ports) or "").splitlines()
    return "\n".join(line for line in lines if line.startswith("|"))


def given_at_ports() -> dict[str, str]:
    """What each port gives: {port: words}."""
    rows = re.findall(r"^\| `(\w+)` \|.*\| (.+) \|$", port_rows(), re.MULTILINE)
    return dict(rows)


def _acts(name: str) -> str:
    """Where it acts: its ports, or the values of the model it changes."""
    at = [port for port in ports.ARGUMENTS if hasattr(MODULES[name], port)]
    if at:
        table = given_at_ports()
        where = _listed([f"`{port}` ({table[port]})" for port in at])
        return f"It acts at the port{'s' if len(at) > 1 else ''} {where}."
    drive = load_drive(resolve_drive(DRIVE))
    nominal, changed = pack(drive, substeps=1), pack(drive, substeps=1)
    effect = CATALOGUE[name]
    assert effect.modify is not None
    effect.modify(changed, effect.complete(EXAMPLES[name].values), drive)
    fields = [key for key in nominal.dtype.names if (nominal[key] != changed[key]).any()]
    return f"It acts as another value of the model's {_listed([f'`{key}`' for key in fields])}."


def _equation(name: str) -> str:
    """The lines of its file that do it: the kernels of its ports, or what it changes."""
    module = MODULES[name]
    found: list[Callable] = [
        getattr(module, port) for port in ports.ARGUMENTS if hasattr(module, port)
    ]
    code = "".join(inspect.getsource(one.py_func) for one in found)
    laws = [one for key, one in vars(module).items() if f"{key}(" in code and one not in found]
    functions = [*found, *(one for one in laws if hasattr(one, "py_func"))]
    functions = functions or [CATALOGUE[name].modify]
    sources = [inspect.getsource(getattr(one, "py_func", one)) for one in functions]
    code = "\n\n\n".join(source.removeprefix("@kernel\n").rstrip() for source in sources)
    return f"```python\n{code}\n```"


def _row(one: Quantity) -> str:
    given = "required" if one.default is None else f"{one.default:g}"
    return f"| `{one.name}` | {one.unit} | {one.low:g} to {one.high:g} | {given} | {one.meaning} |"


def _caption(example: Example) -> str:
    def words(label: str) -> str:
        return label.split(" / ")[0]

    left, middle = (words(TRACES[one][0]) for one in example.traces)
    what, over = example.against
    if over == SPECTRUM:
        right = f"spectrum of the {words(LEFT[what][0])}"
    else:
        right = f"{words(LEFT[what][0])} over {words(OVER[over][0])}"
    known = ""
    if example.known:
        names = [f"{CATALOGUE[key].title} {_yaml(values)}" for key, values in example.known.items()]
        known = f" Both drives carry a load that the model includes: {_listed(names)}."
    return f"Left: {left}; middle: {middle}; right: {right}.{known}"


def _recipe(name: str, example: Example) -> str:
    effects = {**example.known, name: example.values}
    lines = [f"      {key}: {_yaml(values)}" for key, values in effects.items()]
    return "\n".join(
        [
            f"Add to a copy `faulty.yaml` of the drive file `{DRIVE}`, below `ros__parameters`,",
            "",
            "```yaml",
            "    effects:",
            *lines,
            "```",
            "",
            "and run",
            "",
            "```",
            "ecyl simulate --drive faulty.yaml --out out/faulty.mcap \\",
            f'    --reference "{example.reference}" --duration {example.duration_s:g}',
            "```",
        ]
    )


def _kin(effect: Effect) -> list[str]:
    """Effects that it contains, and effects that contain it."""
    parts = []
    if effect.refines:
        parts.append(
            f"It contains {_listed([_link(one) for one in effect.refines])} as a special case, and "
            "is named only where it removes clearly more."
        )
    finer = sorted(one.name for one in CATALOGUE.values() if effect.name in one.refines)
    if finer:
        links = [_link(one, begins=index == 0) for index, one in enumerate(finer)]
        verb = "contains" if len(finer) == 1 else "contain"
        parts.append(f"{_listed(links)} {verb} it as a special case.")
    return parts


def _found(name: str, found: Mapping[str, Any]) -> list[str]:
    """What a diagnosis of the pictured recording says."""
    misfit, named = found["misfit"], found["named"]
    if not named:
        at_noise = misfit["best"] < SURE * misfit["perfect"]
        said = "names nothing" + (", though the residual is noise" if at_noise else "")
    else:
        said = "names " + _listed(
            [f"{CATALOGUE[key].title} (confidence {value:.2f})" for key, value in named.items()]
        )
    rows = ["| effect | misfit |", "|---|---|"]
    rows += [f"| {_link(key)} | {value:g} |" for key, value in found["nearest"].items()]
    close = [
        key
        for key, value in found["nearest"].items()
        if value < SURE * misfit["perfect"] and name not in CATALOGUE[key].refines
    ]
    parts = [
        f"A diagnosis of this recording {said}. Misfit in noise floors: nominal model "
        f"{misfit['before']:g}, with the causes {misfit['best']:g}, perfect model "
        f"{misfit['perfect']:g}. The closest other effects, each alone:",
        "\n".join(rows),
    ]
    if close:
        parts.append(
            f"This recording hardly separates it from {_listed([_link(key) for key in close])}."
        )
    return parts


def page(name: str) -> str:
    """The page of one effect."""
    effect, example = CATALOGUE[name], EXAMPLES[name]
    found = json.loads((HERE / "confusion.json").read_text(encoding="utf-8"))[name]
    parts = [
        f"# {_capital(effect.title)}",
        OPENING,
        f"`{name}` acts in the block {_plain(effect.block)} and is one of [the "
        "effects](../effects.md).",
        effect.summary,
        f"**Needed to see it:** {effect.needed}.",
        f"![{_capital(effect.title)} beside the healthy drive]({name}.png)",
        _caption(example),
        "## Parameters",
        "\n".join(
            [
                "| parameter | unit | possible | unless given | meaning |",
                "|---|---|---|---|---|",
                *(_row(one) for one in effect.parameters),
            ]
        ),
        f"{_acts(name)} [Its file]({SOURCES}/{name}.py) defines it:",
        _equation(name),
        *([RIGID_TOO] if name in RIGID else []),
        "## The recording of the picture",
        _recipe(name, example),
        "## What it is confused with",
        *_kin(effect),
        *_found(name, found),
    ]
    return "\n\n".join(parts) + "\n"


def index_table() -> str:
    """One row for each effect, block by block."""
    rows = ["| effect | block | |", "|---|---|---|"]
    for block in BLOCKS:
        for name, effect in sorted(CATALOGUE.items()):
            if effect.block == block:
                words = re.split(r"(?<=[a-z])[.:;] ", effect.summary)[0].rstrip(".")
                rows.append(f"| [`{name}`](effects/{name}.md) | {_plain(block)} | {words} |")
    return "\n".join(rows)


if __name__ == "__main__":
    for effect_name in CATALOGUE:
        write_text(HERE / f"{effect_name}.md", page(effect_name))
    print(index_table(), port_rows(), sep="\n\n")
