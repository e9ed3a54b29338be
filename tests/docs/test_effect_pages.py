"""The pages of the effects against the catalogue and against what writes them."""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from types import ModuleType

import pytest

from ecyl_ros.drive.drive_file import drive_from_flat, drive_to_flat, load_drive, resolve_drive
from ecyl_ros.effects.catalogue import CATALOGUE

DOCS = Path(__file__).parents[2] / "docs"
LARGEST_PICTURE = 40_000  # bytes
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture
def pages(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """docs/effects/pages.py."""
    monkeypatch.syspath_prepend(str(DOCS / "effects"))
    return importlib.import_module("pages")


def test_each_effect_has_its_page_and_no_other_has(pages: ModuleType) -> None:
    """docs/effects holds one page per effect, word for word what `pages.py` writes."""
    written = {path.stem: path.read_text(encoding="utf-8") for path in DOCS.glob("effects/*.md")}
    assert set(written) == set(CATALOGUE)
    for name in CATALOGUE:
        assert written[name] == pages.page(name), f"{name}: python docs/effects/pages.py"


def test_a_page_says_what_the_effect_says(pages: ModuleType) -> None:
    """Each page has its effect's summary, excitation, every parameter, and how it acts."""
    for name, effect in CATALOGUE.items():
        page = pages.page(name)
        assert effect.summary in page and effect.needed in page
        for one in effect.parameters:
            assert f"| `{one.name}` | {one.unit} | {one.low:g} to {one.high:g} |" in page
        for coarser in effect.refines:
            assert f"]({coarser}.md)" in page and f"]({name}.md)" in pages.page(coarser)
        assert page.count("def ") >= 1


def test_each_effect_has_a_small_picture() -> None:
    """docs/effects holds one PNG per effect, none above 40 kB."""
    pictures = {path.stem: path for path in DOCS.glob("effects/*.png")}
    assert set(pictures) == set(CATALOGUE)
    for path in pictures.values():
        data = path.read_bytes()
        assert data.startswith(PNG) and len(data) < LARGEST_PICTURE, path


def test_the_size_in_the_picture_makes_a_drive_file(pages: ModuleType) -> None:
    """What a page says to put into a drive file is accepted there and comes back the same."""
    nominal = drive_to_flat(load_drive(resolve_drive(pages.DRIVE)))
    for name, example in pages.EXAMPLES.items():
        keys = {f"effects.{name}.{key}": value for key, value in example.values.items()}
        drive = drive_from_flat({**nominal, **keys}, name)
        assert {key: drive.effects[name][key] for key in example.values} == dict(example.values)


def test_no_page_tells_of_a_wrong_cause(pages: ModuleType) -> None:
    """From the recording of its picture each effect is named alone and rightly."""
    found = json.loads((DOCS / "effects" / "confusion.json").read_text(encoding="utf-8"))
    assert set(found) == set(CATALOGUE)
    for name, one in found.items():
        assert set(one["named"]) == {name}
        assert "names nothing" not in pages.page(name)


def test_the_index_lists_every_effect_and_port(pages: ModuleType) -> None:
    """docs/effects.md holds the tables that `pages.py` prints, a row for each effect and port."""
    index = (DOCS / "effects.md").read_text(encoding="utf-8")
    assert pages.index_table() in index and pages.port_rows() in index
    assert pages.index_table().count("\n") == len(CATALOGUE) + 1
    assert set(pages.given_at_ports()) == set(pages.ports.ARGUMENTS)
