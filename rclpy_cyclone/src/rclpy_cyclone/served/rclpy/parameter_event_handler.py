"""Not offered: importing this module fails with a clear message."""

raise ImportError("rclpy.parameter_event_handler is not offered by rclpy_cyclone")
