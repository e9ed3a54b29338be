"""The locked-output bench of the paper's section 3: a hysteresis loop, and the transmission in it.

`simulated.simulated_loop` makes a loop from a drive's own transmission law, `measured` reads one
from a file; `identify.identify` takes either to a median curve, three lines, clearance, stiffness.
"""
