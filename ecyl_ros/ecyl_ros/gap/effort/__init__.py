"""Drives that the closed-loop replay of a full electric cylinder cannot play: judged by effort.

A rigid drive has one inertia, no clearance to see, no electrical signals, and perhaps a controller
that nobody knows. Its gap is then looked for in force or torque: what the measured motion needs,
by inverse dynamics, against what was measured (`judge`). A drive of which only command and position
are known is judged by how it follows (`follow`).
"""
