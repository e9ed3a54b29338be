"""Not offered: importing this module fails with a clear message."""

raise ImportError("rclpy.lifecycle is not offered by rclpy_cyclone")
