"""Empirical mode decomposition of a signal, and how far each of its modes can be trusted.

A mode is not a thing of its own: how many there are and what is in them depends on where sifting
stops, on how the ends are continued, and on what happens to lie near in frequency. So each comes
with its frequency in two ways (the strongest line of its spectrum, and Hilbert's), the share of
its power that lies away from that line (mode mixing), and how much of it changes when the signal's
ends are cut off (edge effect).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..arrays import FloatArray
from ..errors import InputError
from .spectrum import amplitude_spectrum, check_line, dominant_lines

FILTER_ORDER = 8
MIN_SAMPLES = 16
EDGE = 0.05  # fraction at either end left out where Hilbert's phase is not to be trusted
CUT = 0.07  # fraction cut off at either end to see what the ends do; no whole number of anything
INNER = 0.15  # fraction at either end beyond which modes with and without the ends are compared
OCTAVE = 2.0**0.5  # a mode's power within this factor of its line, up and down, is its own


@dataclass(frozen=True)
class EmdSettings:
    """How a signal is decomposed. Modes depend on all of this, so it is stated with them.

    Attributes:
        max_imfs: modes extracted before the rest is called residue.
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
        mixed: share of its power that is not within half an octave of the line, 0 to 1; NaN where
            there is no line. Near 0 the mode is one oscillation; from some 0.15 it mixes several,
            or one that comes and goes.
        edge_change: RMS of what the mode changes by in the middle 70 % of the signal when 7 % are
            cut off at either end, over its standard deviation there. Near 0 the mode is the
            signal's own; from some 0.3 it depends on how the ends are continued. NaN where the
            shorter signal has no such mode.
    """

    values: FloatArray = field(repr=False)
    std: float
    frequency_hz: float
    amplitude: float
    hilbert_frequency_hz: float
    mixed: float = float("nan")
    edge_change: float = float("nan")


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
    values: FloatArray,
    rate_hz: float,
    settings: EmdSettings | None = None,
    *,
    line_hz: float | None = None,
) -> Decomposition:
    """Decompose by PyEMD: cubic envelopes, extrema by parabola, ends mirrored.

    Args:
        values: float64[n], evenly sampled.
        rate_hz: sampling rate.
        settings: see `EmdSettings`.
        line_hz: a line that the modes are wanted for.

    Returns:
        Up to `max_imfs` modes; none for a signal that never moves.

    Raises:
        InputError: fewer than 16 samples, a value that is not finite, or a signal too short or
            too slowly sampled for `line_hz`, or low-passed below it.
    """
    settings = settings or EmdSettings()
    if line_hz is not None:
        check_line(values.size, rate_hz, line_hz)
        if line_hz > settings.band_hz:
            raise InputError(
                f"a line at {line_hz:.4g} Hz, expected at most the {settings.band_hz:.4g} Hz that "
                "modes are taken up to"
            )
    if values.size < MIN_SAMPLES:
        raise InputError(f"EMD needs {MIN_SAMPLES} samples or more, got {values.size}")
    if not np.isfinite(values).all():
        raise InputError("EMD needs finite values, got NaN or infinity")
    thinned, rate, corner = _thin_out(values, rate_hz, settings)
    time = np.arange(thinned.size) / rate
    mean = float(thinned.mean())
    scale = float(thinned.std())
    if scale <= 1e-12 * max(abs(mean), float(np.finfo(float).tiny)):
        return Decomposition(time, rate, corner, (), thinned, settings)
    scaled = (thinned - mean) / scale
    rows, residue = _sift(scaled, time, settings)
    changes = _edge_changes(scaled, time, rows, settings)
    imfs = tuple(
        _described(row * scale, rate, change) for row, change in zip(rows, changes, strict=True)
    )
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


def _edge_changes(
    values: FloatArray, time_s: FloatArray, rows: list[FloatArray], settings: EmdSettings
) -> list[float]:
    """How much each mode depends on the signal's ends; see `Imf.edge_change`."""
    cut, inner = (int(share * values.size) for share in (CUT, INNER))
    nothing = [float("nan")] * len(rows)
    if cut < 1 or values.size - 2 * cut < MIN_SAMPLES:
        return nothing
    part = slice(cut, values.size - cut)
    shorter, _ = _sift(values[part], time_s[part] - time_s[cut], settings)
    middle = slice(inner, values.size - inner)
    changes = nothing
    for number, (whole, short) in enumerate(zip(rows, shorter, strict=False)):
        spread = float(whole[middle].std())
        moved = whole[middle] - short[inner - cut : short.size - (inner - cut)]
        if spread > 0.0:
            changes[number] = float(np.sqrt(np.mean(moved**2))) / spread
    return changes


def _mixed(values: FloatArray, rate_hz: float, line_hz: float) -> float:
    """Share of the power that is not within half an octave of a line."""
    spectrum = amplitude_spectrum(values, rate_hz)
    power = spectrum.amplitude**2
    total = float(power[1:].sum())
    # A line is four bins wide under the window, however low it lies.
    reach = 2.0 * spectrum.resolution_hz
    low = min(line_hz / OCTAVE, line_hz - reach)
    high = max(line_hz * OCTAVE, line_hz + reach)
    own = power[(spectrum.frequency_hz >= low) & (spectrum.frequency_hz <= high)]
    return float(1.0 - own.sum() / total) if total > 0.0 else float("nan")


def _described(values: FloatArray, rate_hz: float, edge_change: float) -> Imf:
    spectrum = amplitude_spectrum(values, rate_hz)
    lines = dominant_lines(spectrum, count=1)
    # A mode slower than the spectrum resolves has its height below the lowest line listed; a
    # lesser line above must not pass for the mode's.
    seen = bool(lines) and lines[0].amplitude >= spectrum.amplitude[1:].max()
    frequency = lines[0].frequency_hz if seen else float("nan")
    return Imf(
        values=values,
        std=float(values.std()),
        frequency_hz=frequency,
        amplitude=lines[0].amplitude if seen else float("nan"),
        hilbert_frequency_hz=hilbert_frequency(values, rate_hz),
        mixed=_mixed(values, rate_hz, frequency) if seen else float("nan"),
        edge_change=edge_change,
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
