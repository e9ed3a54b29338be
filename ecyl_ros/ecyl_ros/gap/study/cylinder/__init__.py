"""Stand-ins for electric cylinders: their equations, faults, nuisances and recordings."""
