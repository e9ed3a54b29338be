"""The compiler settings of every numeric kernel, in one place.

Fast-math stays off: results must agree to the last bit whether a function is called tick by tick
from a node or inlined in the engine's loop.
"""

from numba import njit

kernel = njit(cache=True, fastmath=False, error_model="numpy")
