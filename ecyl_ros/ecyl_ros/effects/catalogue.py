"""All effects, found by their files: a module of this package that defines `EFFECT` is one."""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType

from .effect import Effect


def _modules() -> dict[str, ModuleType]:
    found = {}
    package = __package__ or ""
    for info in pkgutil.iter_modules(importlib.import_module(package).__path__):
        if info.name in ("catalogue", "effect", "ports", "starts"):
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
CATALOGUE: dict[str, Effect] = {name: module.EFFECT for name, module in MODULES.items()}
