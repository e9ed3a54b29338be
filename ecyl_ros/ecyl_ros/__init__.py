"""Emulate an electric-cylinder servo drive as a ROS 2 graph and diagnose its sim-to-real gap."""

__version__ = "0.2.0"
