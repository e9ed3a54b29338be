"""The documentation against the code it speaks of."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from ecyl_ros.cli.main import VERBS, main
from ecyl_ros.drive.describe import key_table, tolerance_table
from ecyl_ros.drive.drive_file import profiles

ROOT = Path(__file__).parents[2]
PAGES = [
    *ROOT.glob("*.md"),
    *sorted((ROOT / "docs").rglob("*.md")),
    ROOT / "bags" / "README.md",
    ROOT / "rclpy_cyclone" / "README.md",
]


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


def test_every_command_of_the_pages_exists(capsys: pytest.CaptureFixture[str]) -> None:
    """Verbs and long flags of `ecyl`, scripts and benchmarks that a page names are there."""
    known: dict[str, str] = {}
    for verb in VERBS:
        with pytest.raises(SystemExit) as ended:
            main([verb, "--help"])
        assert ended.value.code == 0
        known[verb] = capsys.readouterr().out
    for page in PAGES:
        text = page.read_text(encoding="utf-8").replace("\\\n", " ")
        for verb, rest in re.findall(
            r"(?:^|`|    )ecyl ([a-z][\w-]*)([^\n`|]*)", text, re.MULTILINE
        ):
            assert verb in known, (page, verb)
            for flag in re.findall(r"(?<!\S)--[a-z][\w-]*", rest):
                assert flag in known[verb], (page, verb, flag)
        for name in re.findall(r"scripts/([a-z_]+)", text):
            assert (ROOT / "scripts" / name).is_file(), (page, name)
        for name in re.findall(r"scripts/bench (?:--\S+ \S+ )*([a-z_]+)", text):
            assert (ROOT / "benchmarks" / f"{name}.py").is_file(), (page, name)
        for name in re.findall(r"benchmarks/(\w+\.py)", text):
            assert (ROOT / "benchmarks" / name).is_file(), (page, name)


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
