"""The message packages (``std_msgs``, ``std_msgs.msg``, ...) as modules filled on demand."""

from __future__ import annotations

import importlib.machinery
import types
from typing import Any

import rclpy_cyclone
from rclpy_cyclone.types import services


class _Loader:
    """Loads a package, its ``msg`` or ``srv`` module, or the module of one type."""

    def create_module(self, spec: Any) -> None:
        return None

    def exec_module(self, module: types.ModuleType) -> None:
        parts = module.__name__.split(".")
        if len(parts) == 2:
            _fill(module, parts[0], parts[1])
        elif len(parts) == 3:
            from rclpy_cyclone.types.classes import message_class, service_class

            for name in _types_in(parts[2], parts[0], parts[1]):
                full = f"{parts[0]}/{parts[1]}/{name}"
                cls = service_class(full) if full in services.DEFINITIONS else message_class(full)
                setattr(module, name, cls)


def find_spec(fullname: str) -> importlib.machinery.ModuleSpec | None:
    """Return the spec of a message package or of a module in it, ``None`` if there is none."""
    parts = fullname.split(".")
    if parts[0] not in rclpy_cyclone.MESSAGE_PACKAGES or len(parts) > 3:
        return None
    if len(parts) > 1 and parts[1] not in ("msg", "srv"):
        return None
    if len(parts) == 2 and not type_names(parts[0], parts[1]):
        return None
    if len(parts) == 3 and not _types_in(parts[2], parts[0], parts[1]):
        return None
    spec = importlib.machinery.ModuleSpec(
        fullname,
        _Loader(),  # type: ignore[arg-type]
        origin="rclpy_cyclone",
        is_package=len(parts) < 3,
    )
    return spec


def type_names(package: str, kind: str) -> list[str]:
    """Return the names of all messages (kind ``msg``) or services (``srv``) of a package."""
    if kind == "srv":
        prefix = f"{package}/srv/"
        return [n.removeprefix(prefix) for n in services.DEFINITIONS if n.startswith(prefix)]
    from rclpy_cyclone.types import store

    prefix = f"{package}/msg/"
    return sorted(n.removeprefix(prefix) for n in store.names() if n.startswith(prefix))


def _types_in(module: str, package: str, kind: str) -> list[str]:
    from rclpy_cyclone.types.classes import snake

    return [n for n in type_names(package, kind) if f"_{snake(n)}" == module]


def _fill(module: Any, package: str, kind: str) -> None:
    """Give the module a class per type, made when first asked for."""
    from rclpy_cyclone.types import classes

    available = type_names(package, kind)
    module.__all__ = available
    make = classes.message_class if kind == "msg" else classes.service_class

    def __getattr__(name: str) -> Any:
        if name not in available:
            raise AttributeError(f"module '{module.__name__}' has no attribute '{name}'")
        cls = make(f"{package}/{kind}/{name}")
        setattr(module, name, cls)
        return cls

    module.__getattr__ = __getattr__
    module.__dir__ = lambda: available
