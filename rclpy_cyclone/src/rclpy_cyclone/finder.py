"""Which names are served, and from where. Imported only when one of them is asked for."""

import importlib.machinery
import importlib.util
import os
import sys

import rclpy_cyclone

SERVED = os.path.join(os.path.dirname(os.path.abspath(__file__)), "served")


def _is_served(origin: str | None) -> bool:
    return bool(origin) and os.path.abspath(str(origin)).startswith(SERVED + os.sep)


def genuine_rclpy() -> bool:
    """Say whether a genuine rclpy is importable (or imported)."""
    loaded = sys.modules.get("rclpy")
    if loaded is not None:
        return not _is_served(getattr(loaded, "__file__", None))
    for other in sys.meta_path:
        if isinstance(other, rclpy_cyclone._Finder):
            continue
        find = getattr(other, "find_spec", None)
        spec = find("rclpy", None) if find else None
        # A bare directory called rclpy (a source checkout) is a namespace, not the package.
        if spec is not None and spec.origin is not None and not _is_served(spec.origin):
            return True
    return False


def active() -> str:
    """Say which rclpy is in use: ``'rclpy_cyclone'``, ``'genuine'`` or ``'none'``."""
    if genuine_rclpy():
        return "genuine"
    served = any(isinstance(f, rclpy_cyclone._Finder) for f in sys.meta_path)
    return "rclpy_cyclone" if served or "rclpy" in sys.modules else "none"


def find_spec(fullname: str) -> importlib.machinery.ModuleSpec | None:
    """Return the spec of a served module, or ``None`` if it is not ours to serve."""
    if genuine_rclpy():
        return None
    if fullname == "rclpy":
        folder = os.path.join(SERVED, "rclpy")
        return importlib.util.spec_from_file_location(
            fullname, os.path.join(folder, "__init__.py"), submodule_search_locations=[folder]
        )
    if fullname.startswith("rclpy."):
        return None  # the usual path finder has looked in the folder already
    from rclpy_cyclone.types import packages

    return packages.find_spec(fullname)
