"""What imports what: no circles, and a core that knows neither nodes, commands nor ROS."""

from __future__ import annotations

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ECYL = ROOT / "ecyl_ros" / "ecyl_ros"
CYCLONE = ROOT / "rclpy_cyclone" / "src" / "rclpy_cyclone"
SERVED = CYCLONE / "served" / "rclpy"
PACKAGES = {"ecyl_ros": ECYL, "rclpy_cyclone": CYCLONE, "rclpy": SERVED}
CORE = ("drive", "effects", "analysis", "gap", "recording", "export", "api")
AROUND = ("ecyl_ros.nodes", "ecyl_ros.cli", "rclpy")


def _modules() -> dict[str, Path]:
    found = {}
    for package, folder in PACKAGES.items():
        for path in folder.rglob("*.py"):
            if package == "rclpy_cyclone" and path.is_relative_to(SERVED):
                continue
            parts = [package, *path.relative_to(folder).with_suffix("").parts]
            found[".".join(parts).removesuffix(".__init__")] = path
    return found


def _for_types_only(tree: ast.Module) -> set[ast.AST]:
    """What stands under `if TYPE_CHECKING`."""
    blocks = (
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING")
    )
    return {inner for block in blocks for line in block.body for inner in ast.walk(line)}


def _imported(name: str, path: Path) -> set[str]:
    """Dotted names that a module imports, wherever in it."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    aside = _for_types_only(tree)
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    names: set[str] = set()
    for node in ast.walk(tree):
        if node in aside:
            continue
        if isinstance(node, ast.Import):
            names |= {one.name for one in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1]
            base = ".".join([*(above if node.level else []), *filter(None, [node.module])])
            names |= {f"{base}.{one.name}" for one in node.names} | {base}
    return names


@pytest.fixture(scope="module")
def imports() -> dict[str, set[str]]:
    """Module -> modules of ours that it imports; its own package, there anyway, is left out."""
    modules = _modules()
    return {
        name: {
            one
            for one in _imported(name, path) & set(modules)
            if one != name and not name.startswith(f"{one}.")
        }
        for name, path in modules.items()
    }


def test_no_modules_import_each_other(imports: dict[str, set[str]]) -> None:
    """The modules of all packages can be put in order, each after those that it imports."""
    # What stands in a package's `__init__` is reached by every import of a module of it.
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as circle:
        pytest.fail(" -> ".join(circle.args[1]))


def test_the_core_knows_nothing_around_it() -> None:
    """Drive, effects, analysis, gap, recordings and export know neither nodes, verbs nor rclpy."""
    core = tuple(f"ecyl_ros.{one}." for one in CORE)
    for name, path in _modules().items():
        if name.startswith(core):
            around = [one for one in _imported(name, path) if one.startswith(AROUND)]
            assert not around, (name, around)
