"""Empirical mode decomposition of a signal, and the frequency of each mode in two ways."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..errors import InputError
from ..recording.signals import FloatArray
from .spectrum import amplitude_spectrum, dominant_lines

FILTER_ORDER = 8
EDGE = 0.05  # fraction at either end left out where Hilbert's phase is not to be trusted


@dataclass(frozen=True)
class EmdSettings:
    """How a signal is decomposed. Modes depend on all of this, so it is stated with them.

    Attributes:
        max_imfs: modes taken off before the rest is called residue.
        band_hz: highest frequency of interest. Signals sampled at twice `oversampling * band_hz`
            or more are low-passed (zero phase) and thinned out: without that the first modes are
            measurement noise, and sifting takes minutes.
        oversampling: sampling rate kept, in multiples of band_hz. Sifting places extrema on
            samples, and needs many per period.
        mirrored_extrema: extrema mirrored at each end for the envelope splines.
    """

    max_imfs: int = 5
    band_hz: float = 25.0
    oversampling: float = 20.0
    mirrored_extrema: int = 2


@dataclass(frozen=True)
class Imf:
    """One intrinsic mode function.

    Attributes:
        values: float64[n], in the signal's unit, on the decomposition's time grid.
        std: standard deviation.
        frequency_hz, amplitude: its strongest spectral line; NaN where the signal holds fewer than
            3 periods of it.
        hilbert_frequency_hz: instantaneous frequency averaged with squared amplitude as weight,
            5 % at either end left out. It lies above the line where the mode is not one sine.
    """

    values: FloatArray = field(repr=False)
    std: float
    frequency_hz: float
    amplitude: float
    hilbert_frequency_hz: float


@dataclass(frozen=True)
class Decomposition:
    """Modes from fast to slow, and what is left: the signal (low-passed) is the sum of all.

    Attributes:
        time_s: float64[n], from the signal's first sample.
        rate_hz: sampling rate of the modes, after thinning out.
        lowpass_hz: corner of the low-pass; None where none was needed.
    """

    time_s: FloatArray = field(repr=False)
    rate_hz: float
    lowpass_hz: float | None
    imfs: tuple[Imf, ...]
    residue: FloatArray = field(repr=False)
    settings: EmdSettings

    @property
    def energy_ratio(self) -> float:
        """Energy of all parts over that of their sum; 1 where they are orthogonal.

        Well above 1, neighbouring modes hold the same motion with opposite signs, and no single
        one of them has a meaning of its own. NaN without modes.
        """
        if not self.imfs:
            return float("nan")
        parts = [imf.values for imf in self.imfs] + [self.residue - self.residue.mean()]
        total = np.sum(parts, axis=0)
        return float(sum(part @ part for part in parts) / (total @ total))


def decompose(
    values: FloatArray, rate_hz: float, settings: EmdSettings | None = None
) -> Decomposition:
    """Decompose by PyEMD: cubic envelopes, extrema by parabola, ends mirrored.

    Args:
        values: float64[n], evenly sampled.
        rate_hz: sampling rate.
        settings: see `EmdSettings`.

    Returns:
        Up to `max_imfs` modes; none for a signal that never moves.

    Raises:
        InputError: fewer than 16 samples, or a value that is not finite.
    """
    settings = settings or EmdSettings()
    if values.size < 16:
        raise InputError(f"EMD needs 16 samples or more, got {values.size}")
    if not np.isfinite(values).all():
        raise InputError("EMD needs finite values, got NaN or infinity")
    thinned, rate, corner = _thin_out(values, rate_hz, settings)
    time = np.arange(thinned.size) / rate
    mean = float(thinned.mean())
    scale = float(thinned.std())
    if scale <= 1e-12 * max(abs(mean), float(np.finfo(float).tiny)):
        return Decomposition(time, rate, corner, (), thinned, settings)
    rows, residue = _sift((thinned - mean) / scale, time, settings)
    imfs = tuple(_described(row * scale, rate) for row in rows)
    return Decomposition(time, rate, corner, imfs, residue * scale + mean, settings)


def _thin_out(
    values: FloatArray, rate_hz: float, settings: EmdSettings
) -> tuple[FloatArray, float, float | None]:
    factor = int(rate_hz / (settings.oversampling * settings.band_hz) + 1e-9)
    corner = 1.5 * settings.band_hz
    if corner >= 0.5 * rate_hz:
        return values, rate_hz, None
    if factor < 2:
        factor = 1
    from scipy.signal import butter, sosfiltfilt

    # Forwards and backwards: no phase, order doubled. At band_hz 0.15 % is lost.
    sos = butter(FILTER_ORDER, corner, fs=rate_hz, output="sos")
    pad = min(values.size - 1, int(3 * rate_hz / settings.band_hz))
    return sosfiltfilt(sos, values, padlen=pad)[::factor].copy(), rate_hz / factor, corner


def _sift(
    values: FloatArray, time_s: FloatArray, settings: EmdSettings
) -> tuple[list[FloatArray], FloatArray]:
    from PyEMD import EMD

    emd = EMD(spline_kind="cubic", extrema_detection="parabol", nbsym=settings.mirrored_extrema)
    emd.emd(values, time_s, max_imf=settings.max_imfs)
    imfs, residue = emd.get_imfs_and_residue()
    return list(imfs), residue


def _described(values: FloatArray, rate_hz: float) -> Imf:
    spectrum = amplitude_spectrum(values, rate_hz)
    lines = dominant_lines(spectrum, count=1)
    # A mode slower than the spectrum resolves has its height below the lowest line listed; a
    # lesser line above must not pass for the mode's.
    seen = bool(lines) and lines[0].amplitude >= spectrum.amplitude[1:].max()
    return Imf(
        values=values,
        std=float(values.std()),
        frequency_hz=lines[0].frequency_hz if seen else float("nan"),
        amplitude=lines[0].amplitude if seen else float("nan"),
        hilbert_frequency_hz=hilbert_frequency(values, rate_hz),
    )


def hilbert_frequency(values: FloatArray, rate_hz: float) -> float:
    """Mean instantaneous frequency in Hz of the analytic signal, squared amplitude as weight."""
    from scipy.signal import hilbert

    analytic = hilbert(values)
    cycles = np.diff(np.unwrap(np.angle(analytic))) / (2.0 * np.pi)
    weight = np.abs(analytic[:-1]) * np.abs(analytic[1:])
    edge = int(EDGE * cycles.size)
    inner = slice(edge, cycles.size - edge)
    total = float(weight[inner].sum())
    if total <= 0.0:
        return float("nan")
    return float((cycles[inner] * weight[inner]).sum() / total * rate_hz)
