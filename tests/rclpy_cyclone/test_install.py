"""The finder serves rclpy only where there is no genuine one, and costs next to nothing."""

import os
import subprocess
import sys

import pytest

pytest.importorskip("rclpy_cyclone.finder", reason="scripts/setup leaves it out beside genuine ROS")


def run(program, *path):
    """Run a program in a fresh interpreter and return what it prints."""
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(path)}
    out = subprocess.run(
        [sys.executable, "-c", program], env=env, capture_output=True, text=True, check=True
    )
    return out.stdout.strip()


def test_genuine_rclpy_goes_first(tmp_path):
    """Where a genuine rclpy is importable, none of our modules is served, messages included."""
    (tmp_path / "rclpy").mkdir()
    (tmp_path / "rclpy" / "__init__.py").write_text("genuine = True\n")
    program = (
        "import rclpy_cyclone; rclpy_cyclone.install()\n"
        "print(rclpy_cyclone.active())\n"
        "import rclpy; print(rclpy.genuine)\n"
        "try:\n    import std_msgs.msg\nexcept ImportError:\n    print('no messages')"
    )
    assert run(program, str(tmp_path)).split("\n") == ["genuine", "True", "no messages"]


def test_served_where_there_is_none():
    """Without a genuine rclpy ours is served, with its messages."""
    program = (
        "import rclpy_cyclone; rclpy_cyclone.install()\n"
        "import rclpy, std_msgs.msg\n"
        "print(rclpy_cyclone.active(), std_msgs.msg.String(data='x'))"
    )
    assert run(program) == "rclpy_cyclone std_msgs.msg.String(data='x')"


def test_start_imports_nothing_heavy():
    """Installing the finder imports neither numpy, nor rosbags, nor cyclonedds, nor importlib."""
    program = (
        "import sys; before = set(sys.modules)\n"
        "import rclpy_cyclone; rclpy_cyclone.install()\n"
        "print(sorted(m for m in set(sys.modules) - before if not m.startswith('rclpy_cyclone')))"
    )
    assert run(program) == "[]"
    assert "numpy" not in run("import sys; print(list(sys.modules))")
