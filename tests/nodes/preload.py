"""What every node imports and compiles, for the process that the tests' nodes are forked from."""

import rclpy

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.warm_up import warm_up
from ecyl_ros.nodes import analyser, controller, gap_monitor, plant, recorder, reference

NODES = (rclpy, analyser, controller, gap_monitor, plant, recorder, reference)

warm_up(load_drive("bench"))
