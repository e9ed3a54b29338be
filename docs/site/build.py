"""The documentation as HTML. Warnings are errors.

Pages in Markdown and the reference of all public modules, from their docstrings, with their source.
"""

from __future__ import annotations

import argparse
import gc
import importlib
import os
import shutil
import sys
import tempfile
import warnings
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = {
    "ecyl_ros": ROOT / "ecyl_ros" / "ecyl_ros",
    "rclpy_cyclone": ROOT / "rclpy_cyclone" / "src" / "rclpy_cyclone",
    "rclpy": ROOT / "rclpy_cyclone" / "src" / "rclpy_cyclone" / "served" / "rclpy",
}
# Pages, and what they link to.
PAGES = (
    "*.md",
    "LICENSE",
    "bags/*",
    "docs/**/*.*",
    "ecyl_ros/**/*.py",
    "rclpy_cyclone/README.md",
    "tests/**/*.py",
)


def _refusals(folder: Path) -> list[str]:
    """Modules that only say that they are not offered: they cannot be imported."""
    return [
        str(path)
        for path in folder.rglob("*.py")
        if path.read_text(encoding="utf-8").startswith('"""Not offered: importing')
    ]


def main(out: Path, *, sources: bool, jobs: str) -> int:
    """Build into `out`, with highlighted `sources` or without; 0 if nothing was complained of.

    jobs: Sphinx's processes. More of them end sooner and compute more: each hands on what it read.
    """
    # Kernels are documented as the functions they are compiled from.
    warnings.filterwarnings("ignore", message=".* is deprecated. Use", module="sphinx")
    os.environ["NUMBA_DISABLE_JIT"] = "1"
    gc.set_threshold(100_000, 20, 100)  # a tenth of the time went into looking for garbage
    sys.path[:0] = sorted({str(folder.parent) for folder in PACKAGES.values()})
    from sphinx.cmd.build import main as build
    from sphinx.ext.apidoc import main as list_modules

    shutil.rmtree(out, ignore_errors=True)
    with tempfile.TemporaryDirectory() as name:
        source = Path(name) / "source"
        source.mkdir()
        for path in (path for pattern in PAGES for path in ROOT.glob(pattern)):
            copy = source / path.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, copy)
        for file in ("index.md", "conf.py"):
            shutil.copy(ROOT / "docs" / "site" / file, source)
        for package, folder in PACKAGES.items():
            listing = ["-q", "--module-first", "--separate", "--no-toc", "-o", str(source / "api")]
            list_modules([*listing, str(folder), str(folder / "served"), *_refusals(folder)])
            if not (source / "api" / f"{package}.rst").exists():
                raise FileNotFoundError(f"{folder}: holds no modules")
        # Once, and not again by each of the processes that Sphinx forks off.
        for page in (source / "api").glob("*.rst"):
            importlib.import_module(page.stem)
        trees = str(Path(name) / "trees")
        return build(
            [
                "-q",
                "-W",
                "--keep-going",
                "-j",
                jobs,
                "-b",
                "html",
                "-d",
                trees,
                *(() if sources else ("-t", "no_sources")),
                str(source),
                str(out),
            ]
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("out", type=Path, metavar="OUT", help="folder of the pages")
    parser.add_argument(
        "--no-sources", action="store_true", help="without the modules' source: takes less time"
    )
    parser.add_argument("--jobs", default="auto", metavar="N", help="processes (%(default)s)")
    given = parser.parse_args()
    sys.exit(main(given.out.absolute(), sources=not given.no_sources, jobs=given.jobs))
