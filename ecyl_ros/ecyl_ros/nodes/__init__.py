"""The drive as ROS 2 nodes: plant, controller, reference, analyser, and a recorder beside them."""
