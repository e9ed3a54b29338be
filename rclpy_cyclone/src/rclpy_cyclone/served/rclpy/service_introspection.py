"""Not offered: importing this module fails with a clear message."""

raise ImportError("rclpy.service_introspection is not offered by rclpy_cyclone")
