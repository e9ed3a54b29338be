"""What an installed package must do where there is no repository.

Runs in the environment it was installed into, from an empty folder: `python smoke.py` for what
takes a moment, `python smoke.py --full` to simulate, diagnose and run the node graph as well.
"""

from __future__ import annotations

import importlib.metadata
import subprocess
import sys
from pathlib import Path

ECYL = Path(sys.executable).with_name("ecyl")
LICENCE = "Apache License"


def ecyl(*words: str) -> str:
    """What `ecyl` prints; it has to end with 0."""
    done = subprocess.run([ECYL, *words], capture_output=True, text=True)
    assert done.returncode == 0, f"ecyl {' '.join(words)}: {done.stderr}"
    return done.stdout


def carried(name: str) -> None:
    """The installed distribution has its licence and says that it is typed."""
    files = importlib.metadata.files(name) or []
    (licence,) = (file for file in files if file.name == "LICENSE")
    assert LICENCE in licence.read_text()
    said = importlib.metadata.metadata(name)
    assert "Apache-2.0" in (said.get("License-Expression"), said.get("License"))
    assert any(file.name == "py.typed" for file in files), f"{name}: no py.typed"


def quick() -> None:
    """Version, licence, profiles, layouts, launch files, messages without ROS."""
    import ecyl_ros
    from ecyl_ros.drive.drive_file import config_folder, load_drive, profiles

    home = Path(ecyl_ros.__file__).resolve()
    assert home.is_relative_to(Path(sys.prefix).resolve()), f"{home}: not in {sys.prefix}"
    assert ecyl("--version").split() == ["ecyl", importlib.metadata.version("ecyl_ros")]
    assert profiles() == ["bench", "paper", "servo_1khz", "si", "worn_1khz"]
    for profile in profiles():
        load_drive(profile)
    share = config_folder().parent
    assert share.is_relative_to(Path(sys.prefix).resolve()), share
    assert len(list((share / "layouts").iterdir())) == 5
    assert (share / "launch" / "drive.launch.py").is_file() and (share / "package.xml").is_file()
    for name in ("ecyl_ros", "rclpy_cyclone"):
        carried(name)
    import rclpy
    from sensor_msgs.msg import JointState

    assert rclpy.ok() is False and JointState(name=["rod"]).name == ["rod"]


def full() -> None:
    """The demo finds the worn drive's fault; engine and graph give the same bytes."""
    assert "wrong backlash" in ecyl("demo", "demo")
    assert "<html" in Path("demo", "worn.html").read_text()[:200]
    spec = "moves:positions=0.004;-0.002,speed=0.05,acceleration=1,jerk=50,dwell=0.2"
    for verb in ("simulate", "run"):
        run = ["--drive", "bench", "--reference", spec, "--duration", "1"]
        ecyl(verb, *run, "--out", f"{verb}.mcap")
    assert Path("run.mcap").read_bytes() == Path("simulate.mcap").read_bytes()


if __name__ == "__main__":
    quick()
    if "--full" in sys.argv:
        full()
    print("smoke test passed")
