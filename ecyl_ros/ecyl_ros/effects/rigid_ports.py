"""Where effects act in a compiled rigid drive; each kernel is called once for each that is at work.

An effect's file defines a kernel under the name of its port. The kernel takes the effect's packed
values first (`RigidForm.packed`). Positions, speeds and efforts are of the output.

| port | arguments after the values | gives |
|---|---|---|
| `rigid_load` | time s, position | effort against positive motion |
| `rigid_level` | time s, position, speed, acceleration | friction level |
| `rigid_share` | position | share of the drive's effort that is lost |
"""

from __future__ import annotations

from collections.abc import Callable

from ..drive.compiled import kernel
from .catalogue import MODULES, RIGID

PORTS = ("rigid_load", "rigid_level", "rigid_share")
KINDS: dict[str, int] = {name: number for number, name in enumerate(RIGID)}


def port_of(name: str) -> str | None:
    """The port that an effect acts at; None where it is another value of a constant."""
    return next((port for port in PORTS if hasattr(MODULES[name], port)), None)


def _either_1(kind: int, f: Callable, g: Callable) -> Callable:
    return kernel(lambda k, v, a: f(v, a) if k == kind else g(k, v, a), cache=False)


def _either_2(kind: int, f: Callable, g: Callable) -> Callable:
    return kernel(lambda k, v, a, b: f(v, a, b) if k == kind else g(k, v, a, b), cache=False)


def _either_4(kind: int, f: Callable, g: Callable) -> Callable:
    return kernel(
        lambda k, v, a, b, c, d: f(v, a, b, c, d) if k == kind else g(k, v, a, b, c, d),
        cache=False,
    )


_NOTHING_1 = kernel(lambda k, v, a: 0.0, cache=False)
_NOTHING_2 = kernel(lambda k, v, a, b: 0.0, cache=False)
_NOTHING_4 = kernel(lambda k, v, a, b, c, d: 0.0, cache=False)


def _port(name: str, either: Callable, nothing: Callable) -> Callable:
    """One kernel that takes the kind of an effect first and calls that effect's own."""
    made = nothing
    for effect in RIGID:
        if port_of(effect) == name:
            made = either(KINDS[effect], getattr(MODULES[effect], name), made)
    return made


rigid_load = _port("rigid_load", _either_2, _NOTHING_2)
rigid_level = _port("rigid_level", _either_4, _NOTHING_4)
rigid_share = _port("rigid_share", _either_1, _NOTHING_1)
