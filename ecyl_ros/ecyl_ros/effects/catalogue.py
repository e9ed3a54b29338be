"""All effects, found by their files: a module of this package that defines `EFFECT` is one."""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType

from .effect import Effect
from .rigid_form import RigidForm

_SUMS = ("catalogue", "ports", "rigid_ports")  # which are made of what is found here


def _modules() -> dict[str, ModuleType]:
    found = {}
    package = __package__ or ""
    for info in pkgutil.iter_modules(importlib.import_module(package).__path__):
        if info.name in _SUMS:
            continue
        module = importlib.import_module(f"{package}.{info.name}")
        effect = getattr(module, "EFFECT", None)
        if effect is None:
            continue
        if effect.name != info.name:
            raise ValueError(f"effects/{info.name}.py defines an effect called {effect.name}")
        found[effect.name] = module
    return found


MODULES: dict[str, ModuleType] = _modules()
# Every effect of any machine; those that a full cylinder may have; those of a rigid drive.
EFFECTS: dict[str, Effect] = {name: module.EFFECT for name, module in MODULES.items()}
CATALOGUE: dict[str, Effect] = {name: one for name, one in EFFECTS.items() if one.cylinder}
RIGID: dict[str, RigidForm] = {
    name: module.RIGID for name, module in MODULES.items() if hasattr(module, "RIGID")
}


def rigid_forms(linear: bool) -> dict[str, RigidForm]:
    """The effects of a rigid drive with a straight output, or of one that turns."""
    output = "linear" if linear else "rotary"
    return {name: form for name, form in RIGID.items() if output in form.outputs}
