"""Single-sided amplitude spectrum and the lines that stand out of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..errors import InputError

WINDOW = "hann"
# A Hann line is four bins wide. With fewer periods than this in the signal it runs into the mean.
MIN_PERIODS = 3.0
# How much higher, in parts of the peak, the far flank may be before a peak counts as broad.
BROAD = 0.15


@dataclass(frozen=True)
class Line:
    """A spectral line: frequency in Hz and peak amplitude in the signal's unit."""

    frequency_hz: float
    amplitude: float


@dataclass(frozen=True)
class Spectrum:
    """Amplitude over frequency: a sine A sin(2 pi f t) shows as a line of height A at f.

    Attributes:
        frequency_hz: float64[m], 0 to half the sampling rate.
        amplitude: float64[m], peak amplitude in the signal's unit.
        resolution_hz: distance of two bins, 1 / duration.
    """

    frequency_hz: FloatArray
    amplitude: FloatArray
    resolution_hz: float


def amplitude_spectrum(values: FloatArray, rate_hz: float) -> Spectrum:
    """Spectrum under a periodic Hann window, scaled by its sum, of the signal less its mean.

    Args:
        values: float64[n], evenly sampled, no NaN.
        rate_hz: sampling rate.

    Raises:
        InputError: fewer than 4 samples, or a value that is not finite.
    """
    from scipy.signal import get_window

    if values.size < 4:
        raise InputError(f"a spectrum needs 4 samples or more, got {values.size}")
    if not np.isfinite(values).all():
        raise InputError("a spectrum needs finite values, got NaN or infinity")
    window = get_window(WINDOW, values.size, fftbins=True)
    # The weighted mean, so that nothing of it leaks into the first bins.
    centred = values - np.average(values, weights=window)
    amplitude = 2.0 * np.abs(np.fft.rfft(centred * window)) / window.sum()
    amplitude[0] /= 2.0
    if values.size % 2 == 0:
        amplitude[-1] /= 2.0
    resolution = rate_hz / values.size
    return Spectrum(np.arange(amplitude.size) * resolution, amplitude, resolution)


def check_line(samples: int, rate_hz: float, line_hz: float) -> None:
    """Refuse a signal that cannot show a line: too short, or too slowly sampled.

    Raises:
        InputError: `line_hz` is not positive, has fewer than 3 periods in the signal, or lies
            beyond half the sampling rate.
    """
    if not (np.isfinite(line_hz) and line_hz > 0.0):
        raise InputError(f"a line at {line_hz:g} Hz, expected more than 0")
    duration = samples / rate_hz
    if duration * line_hz < MIN_PERIODS * (1.0 - 1e-9):
        raise InputError(
            f"signal of {duration:.4g} s is too short for a line at {line_hz:.4g} Hz, which needs "
            f"{MIN_PERIODS / line_hz:.4g} s"
        )
    if line_hz >= 0.5 * rate_hz:
        raise InputError(
            f"signal sampled at {rate_hz:.6g} Hz cannot show a line at {line_hz:.4g} Hz, expected "
            f"one below {0.5 * rate_hz:.6g} Hz"
        )


def line_at(values: FloatArray, rate_hz: float, line_hz: float) -> Line:
    """The sine of a given frequency in a signal, by least squares under a Hann window.

    The window keeps other lines out: four bins away and more they count less than 1 %.

    Args:
        values: float64[n], evenly sampled, finite.
        rate_hz: sampling rate.
        line_hz: the frequency.

    Raises:
        InputError: see `check_line`.
    """
    from scipy.signal import get_window

    check_line(values.size, rate_hz, line_hz)
    weight = np.sqrt(get_window(WINDOW, values.size, fftbins=True))
    phase = 2.0 * np.pi * line_hz / rate_hz * np.arange(values.size)
    columns = np.stack([np.cos(phase), np.sin(phase), np.ones_like(phase)], axis=1)
    fitted, *_ = np.linalg.lstsq(weight[:, None] * columns, weight * values, rcond=None)
    return Line(line_hz, float(np.hypot(fitted[0], fitted[1])))


def dominant_lines(
    spectrum: Spectrum,
    *,
    count: int = 10,
    min_ratio: float = 0.03,
    lowest_hz: float | None = None,
) -> tuple[Line, ...]:
    """The strongest lines, strongest first, each interpolated between bins.

    The height of a bin falls by up to 15 % when a line lies between two. Under a Hann window the
    ratio of the two highest bins gives the true place and height of a single line in closed form
    (Grandke, IEEE Trans. Instrum. Meas. 32, 1983). Broad peaks are not interpolated.

    Args:
        spectrum: from `amplitude_spectrum`.
        count: lines at most.
        min_ratio: weakest line listed, relative to the strongest. The window's own side lobes
            reach 0.027.
        lowest_hz: the lowest frequency of interest. Lines with fewer than 3 periods in the signal
            cannot be told from its mean and are never listed.

    Raises:
        InputError: the signal holds fewer than 3 periods of `lowest_hz`.
    """
    floor_hz = MIN_PERIODS * spectrum.resolution_hz
    if lowest_hz is not None and lowest_hz < floor_hz * (1 - 1e-9):
        raise InputError(
            f"signal of {1.0 / spectrum.resolution_hz:.4g} s is too short for a line at "
            f"{lowest_hz:.4g} Hz, which needs {MIN_PERIODS / lowest_hz:.4g} s"
        )
    height = spectrum.amplitude
    inner = np.arange(1, height.size - 1)
    peaks = inner[(height[1:-1] > height[:-2]) & (height[1:-1] >= height[2:])]
    lines: list[Line] = []
    for bin_ in peaks[np.argsort(height[peaks])[::-1]].tolist():
        line = _interpolated(spectrum, bin_)
        if line.frequency_hz < floor_hz - 0.5 * spectrum.resolution_hz:
            continue
        if lines and line.amplitude < min_ratio * lines[0].amplitude:
            break
        # Within a main lobe's width of a stronger line a maximum is no line of its own.
        near = 3.0 * spectrum.resolution_hz
        if any(abs(line.frequency_hz - other.frequency_hz) < near for other in lines):
            continue
        lines.append(line)
        if len(lines) == count:
            break
    return tuple(sorted(lines, key=lambda line: -line.amplitude))


def _interpolated(spectrum: Spectrum, bin_: int) -> Line:
    height = spectrum.amplitude
    side = 1 if height[bin_ + 1] >= height[bin_ - 1] else -1
    ratio = height[bin_ + side] / height[bin_]
    # Where the line stands, in bins towards `side`. Noise may put it outside of what is possible.
    offset = min(max((2.0 * ratio - 1.0) / (ratio + 1.0), 0.0), 0.5)
    # A sweep or a broad resonance is no single line: its other flank is too high for one. There
    # the correction would add up to 18 % that is not there, so the bin is taken as it is.
    flank = _hann(1.0 + offset) / _hann(offset)
    if height[bin_ - side] > (flank + BROAD) * height[bin_]:
        return Line(float(spectrum.frequency_hz[bin_]), float(height[bin_]))
    return Line(
        frequency_hz=float((bin_ + side * offset) * spectrum.resolution_hz),
        amplitude=float(height[bin_] / _hann(offset)),
    )


def _hann(offset: float) -> float:
    """Height of the window's main lobe, `offset` bins (0 to 2) from its top of 1."""
    if abs(offset - 1.0) < 1e-6:
        return 0.5
    return float(np.sinc(offset) / (1.0 - offset**2))
