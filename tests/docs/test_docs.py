"""The documentation against the code it speaks of."""

from __future__ import annotations

import re
from pathlib import Path

from ecyl_ros.cli.main import VERBS
from ecyl_ros.drive.describe import key_table, tolerance_table
from ecyl_ros.drive.drive_file import profiles

ROOT = Path(__file__).parents[2]
PAGES = [*ROOT.glob("*.md"), *sorted((ROOT / "docs").rglob("*.md"))]


def test_the_drive_file_page_holds_the_table_the_code_prints() -> None:
    """Keys, units, ranges, defaults and tolerances in docs/drive-file.md are those in force."""
    page = (ROOT / "docs" / "drive-file.md").read_text()
    assert key_table() in page and tolerance_table() in page
    for profile in profiles():
        assert f"`{profile}`" in page


def test_links_lead_somewhere() -> None:
    """Every relative link in README and docs names a file that exists."""
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
            if "://" not in target:
                assert (page.parent / target).exists(), (page, target)


def test_the_readme_names_every_verb() -> None:
    """README's table of commands has each verb of `ecyl`."""
    readme = (ROOT / "README.md").read_text()
    for verb in VERBS:
        assert f"ecyl {verb}" in readme


def test_the_nodes_page_names_every_topic_and_parameter() -> None:
    """docs/nodes.md has every topic of the wire and every parameter of the nodes."""
    from ecyl_ros.nodes import wire
    from ecyl_ros.nodes.drive_node import COMMON_PARAMETERS

    page = (ROOT / "docs" / "nodes.md").read_text()
    topics = [
        value for name, value in vars(wire).items() if name.isupper() and isinstance(value, str)
    ]
    for topic in topics:
        if "/" in topic:
            assert f"`{topic}`" in page, topic
    for name in (*COMMON_PARAMETERS, "duration", "summary_file", "lookahead", "window", "out"):
        assert f"`{name}`" in page, name


def test_the_contributors_example_is_the_code_itself() -> None:
    """The effect that CONTRIBUTING walks through stands there as it stands in its file."""
    page = (ROOT / "CONTRIBUTING.md").read_text()
    shown = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    source = (ROOT / "ecyl_ros/ecyl_ros/effects/inverter_gain.py").read_text()
    (own,) = shown
    assert source.endswith(own)
