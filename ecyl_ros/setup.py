"""ament_python package: `colcon build` on ROS 2 Jazzy, `pip install` on machines without ROS."""

import re
from glob import glob
from pathlib import Path

from setuptools import find_packages, setup

NAME = "ecyl_ros"
HERE = Path(__file__).resolve().parent
# The one place of the version is the package itself; package.xml is held to it by a test.
(VERSION,) = re.findall(
    r'^__version__ = "(.+)"$', (HERE / NAME / "__init__.py").read_text(encoding="utf-8"), re.M
)

setup(
    name=NAME,
    version=VERSION,
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    # Said outright, so that an editable install is a path entry: an import hook would lose against
    # the folder of the same name when Python runs from the repository's top level.
    package_dir={"": "."},
    package_data={NAME: ["py.typed", "paper/templates/*.j2"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", sorted(glob("launch/*.launch.py"))),
        (f"share/{NAME}/config", sorted(glob("config/*.yaml"))),
        (f"share/{NAME}/layouts", sorted(glob("layouts/*"))),
    ],
    python_requires=">=3.10",
    install_requires=[
        "numpy>=1.26",
        "scipy>=1.11",
        "numba>=0.59",
        "joblib>=1.4",
        "threadpoolctl>=3.1",
        "mcap>=1.5",
        "mcap-ros2-support>=0.5",
        "rosbags>=0.10",
        "EMD-signal>=1.6",
        "pandas>=2.0",
        "argcomplete>=3.0",
        "matplotlib>=3.6",
        "pyyaml>=6.0",
        "rich>=13",
        "ruckig>=0.10",
        "jinja2>=3.1",
    ],
    extras_require={"dask": ["dask[distributed]>=2024.1"]},  # `ecyl sensitivity --dask`
    zip_safe=False,
    long_description=(HERE / "README.md").read_text(encoding="utf-8"),
    long_description_content_type="text/markdown",
    maintainer="The ecyl_ros founders",
    maintainer_email="maintainers@ecyl-ros.example",
    description="An electric-cylinder servo drive as a ROS 2 graph; diagnosis of its gap",
    license="Apache-2.0",
    license_files=["LICENSE"],
    entry_points={
        "console_scripts": [
            "ecyl = ecyl_ros.cli.main:main",
            "plant = ecyl_ros.nodes.entry:plant",
            "controller = ecyl_ros.nodes.entry:controller",
            "reference = ecyl_ros.nodes.entry:reference",
            "analyser = ecyl_ros.nodes.entry:analyser",
            "recorder = ecyl_ros.nodes.entry:recorder",
            "gap_monitor = ecyl_ros.nodes.entry:gap_monitor",
            "round_trip = ecyl_ros.nodes.entry:round_trip",
        ],
        "ros2cli.command": ["ecyl = ecyl_ros.cli.ros2_command:EcylCommand"],
    },
)
