"""Rigid drives judged by effort: what a replay in closed loop of a full cylinder cannot play.

A rigid drive has one inertia, no clearance to see, no electrical signals, and perhaps a controller
that nobody knows. Its gap is looked for in force or torque: what the measured motion (`motion`)
needs, by inverse dynamics (`terms`), against what was measured (`balance`).
"""
