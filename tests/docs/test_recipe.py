"""README's recipe for ROS 2 against setup.py and package.xml."""

from __future__ import annotations

import ast
import re
import shlex
import xml.etree.ElementTree as ET
from pathlib import Path

from ecyl_ros.cli.ros2_command import MODULES

ROOT = Path(__file__).parents[2]
# rosdep's keys for distributions whose key is not `python3-` and their own name.
KEYS = {"pyyaml": "python3-yaml"}
MODULE_OF = {"mcap-ros2-support": "mcap_ros2", "EMD-signal": "PyEMD"}


def _required() -> dict[str, str]:
    """Distribution -> requirement, of setup.py."""
    tree = ast.parse((ROOT / "ecyl_ros/setup.py").read_text())
    lists = [
        ast.literal_eval(node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.keyword) and node.arg == "install_requires"
    ]
    return {re.split("[<>=]", text)[0]: text for text in lists[0]}


def _from_the_distribution() -> set[str]:
    """What rosdep brings: the keys in package.xml."""
    package = ET.parse(ROOT / "ecyl_ros/package.xml")
    return {str(node.text) for node in package.iter("exec_depend")}


def test_pip_brings_what_the_distribution_does_not() -> None:
    """The pip line holds setup.py's requirements that package.xml has no rosdep key for."""
    line = re.search(r"^pip install (.+)$", (ROOT / "README.md").read_text(), re.MULTILINE)
    assert line is not None
    keys = _from_the_distribution()
    missing = {
        text for name, text in _required().items() if KEYS.get(name, f"python3-{name}") not in keys
    }
    assert set(shlex.split(line[1])) == missing | {"numpy<2"}


def test_every_import_of_a_node_is_a_dependency() -> None:
    """package.xml names each ROS package that the code imports, and no key nobody needs."""
    keys = _from_the_distribution()
    source = "\n".join(path.read_text() for path in (ROOT / "ecyl_ros").rglob("*.py"))
    found = set(re.findall(r"^\s*(?:from|import) (\w+)", source, re.MULTILINE))
    ros = {name for name in found if re.search("_msgs$|_interfaces$|^rclpy$|^launch|^ament", name)}
    assert ros <= keys
    python = {KEYS.get(name, f"python3-{name}") for name in _required()}
    assert {key for key in keys if key.startswith("python3-")} <= python | {"python3-venv"}


def test_ros2_ecyl_knows_which_modules_pip_brings() -> None:
    """The modules `ros2 ecyl` looks for are those of the pip line."""
    line = re.search(r"^pip install (.+)$", (ROOT / "README.md").read_text(), re.MULTILINE)
    assert line is not None
    names = [re.split("[<>=]", word)[0] for word in shlex.split(line[1])]
    assert {MODULE_OF.get(name, name) for name in names} - {"numpy"} == set(MODULES)
