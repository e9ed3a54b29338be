"""Stand-ins for rigid drives: their equations, faults, sensors and recordings."""
