"""The DDS side: everything that knows Cyclone DDS, and nothing that knows rclpy's API."""
