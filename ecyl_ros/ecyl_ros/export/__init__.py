"""Drives for other simulators: MJCF, URDF and SDF, and joint values of these as a drive file."""
