"""Sums of values times waves at many evenly spaced rates, the values anywhere along an axis.

A Fourier transform of samples that are not even: each is spread over its neighbourhood on an even
grid by a Gaussian, the grid is transformed, and the Gaussian is divided out (Greengard, Lee,
"Accelerating the nonuniform fast Fourier transform", SIAM Review 46, 2004).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.fft import ifft, next_fast_len

from ...arrays import FloatArray
from ...drive.compiled import called

_REACH = 12  # grid points to each side that a value is spread over: right to 11 digits
_FINER = 2  # points of the grid per rate
_FEWEST = 4 * _REACH  # points of a grid


def wave_sums(
    values: FloatArray, along: FloatArray, first: float, spacing: float, count: int
) -> NDArray[np.complex128]:
    """Sum of values x exp(i rate along) at the rates first + k spacing, complex128[count].

    values, along: float64[n].
    """
    middle = count // 2
    size = next_fast_len(max(_FINER * count, _FEWEST))
    ratio = size / max(count, _FEWEST // _FINER)
    # Width of the Gaussian, in (grid points)^2: what it loses at its ends, and of other periods.
    width = _REACH / (math.pi * ratio * (ratio - 0.5)) * ratio**2 / 4.0
    turned = values * np.exp(1j * (first + middle * spacing) * along)
    at = (spacing * along / math.tau % 1.0) * size
    grid = np.zeros((2, size))
    falls = np.exp(-(np.arange(-_REACH, _REACH + 1.0) ** 2) / (4.0 * width))
    _spread(at, turned.real.copy(), turned.imag.copy(), falls, 4.0 * width, grid)
    order = np.arange(count) - middle
    spectrum = ifft(grid[0] + 1j * grid[1])[order] * size
    # By the transform of the Gaussian.
    made: NDArray[np.complex128] = spectrum * (
        np.exp((math.tau * order / size) ** 2 * width) / math.sqrt(4.0 * math.pi * width)
    )
    return made


@called
def _spread(at, real, imaginary, falls, width, grid):
    """Add each value to the grid about its place.

    falls: of the Gaussian at whole points, exp(-point^2 / width).
    """
    size = grid.shape[1]
    reach = falls.shape[0] // 2
    for sample in range(at.shape[0]):
        point = int(at[sample])
        off = at[sample] - point
        near = math.exp(-off * off / width)
        step = math.exp(2.0 * off / width)
        share = near * step ** (1 - reach)
        place = point + 1 - reach
        for index in range(1, 2 * reach + 1):
            here = place
            if here < 0:
                here += size
            elif here >= size:
                here -= size
            weight = share * falls[index]
            grid[0, here] += weight * real[sample]
            grid[1, here] += weight * imaginary[sample]
            share *= step
            place += 1
