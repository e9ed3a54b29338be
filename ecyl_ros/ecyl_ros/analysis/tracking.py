"""How well the rod follows its reference: the figures of one recording."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..arrays import FloatArray
from ..errors import InputError
from ..recording.signals import Recording
from .emd import Decomposition, EmdSettings, decompose
from .lag import Lag, lag_and_gain
from .spectrum import Line, Spectrum, amplitude_spectrum, dominant_lines, line_at
from .uniform import MIN_SAMPLES, uniform

REFERENCE = "reference_position_m"
ROD = "rod_position_m"
ROTOR = "rotor_position_rad"
OVERLAP = 1.1  # energy ratio of the empirical modes from which a note warns


@dataclass(frozen=True)
class TrackingAnalysis:
    """Tracking figures of the rod, error = reference - position, SI units.

    Attributes:
        skip_s: time left out at the start.
        duration_s, rate_hz: of the part analysed.
        samples: instants at which both reference and position are known.
        error_std_m, error_rms_m, error_mean_m, error_max_m: of the error; the last is the largest
            absolute value.
        lag: fit of lag, gain and offset of the position behind the reference.
        lines: dominant lines of the error's spectrum, strongest first.
        spectrum: the whole of it.
        emd: the error's empirical modes with the settings used.
        asked: the line of the error that was asked for; None where none was.
        notes: one line each on what was missing, interpolated or derived.
        time_s, reference_m, position_m, error_m: the even samples behind the figures, float64[n].
        relative_angle_rad: rotor less load at the same instants, less its mean; None where the
            load is not recorded.
    """

    skip_s: float
    duration_s: float
    rate_hz: float
    samples: int
    error_std_m: float
    error_rms_m: float
    error_mean_m: float
    error_max_m: float
    lag: Lag
    lines: tuple[Line, ...]
    spectrum: Spectrum = field(repr=False)
    emd: Decomposition
    notes: tuple[str, ...]
    time_s: FloatArray = field(repr=False)
    reference_m: FloatArray = field(repr=False)
    position_m: FloatArray = field(repr=False)
    error_m: FloatArray = field(repr=False)
    relative_angle_rad: FloatArray | None = field(repr=False, default=None)
    asked: Line | None = None


def analyse(
    recording: Recording,
    skip_s: float = 0.0,
    *,
    rotor_to_rod_m_per_rad: float | None = None,
    emd_settings: EmdSettings | None = None,
    line_hz: float | None = None,
) -> TrackingAnalysis:
    """Analyse how the rod follows its reference.

    Args:
        recording: needs reference_position_m and rod_position_m.
        skip_s: time from the first stamp to leave out, for the machine to settle.
        rotor_to_rod_m_per_rad: where the rod is not measured, take rotor_position_rad times this
            for its position. That leaves clearance and twist behind the rotor out of the error.
            lead / (2 pi gear_ratio) of the drive.
        emd_settings: of the decomposition.
        line_hz: a line of the error to give the amplitude of, whether it stands out or not.

    Raises:
        InputError: a signal needed is missing, skip_s is negative or leaves fewer than 16 samples,
            the factor is not a finite number other than zero, or what is left is too short or too
            slowly sampled for `line_hz`.
    """
    if not np.isfinite(skip_s) or skip_s < 0.0:
        raise InputError(f"skip is {skip_s:g} s, expected 0 or more")
    if not recording.has(REFERENCE):
        raise InputError(f"{REFERENCE} is not in the recording; tracking needs it")
    part = recording.slice(start_s=skip_s)
    if len(part) < MIN_SAMPLES:
        raise InputError(
            f"skip is {skip_s:g} s, which leaves {len(part)} samples of a recording of "
            f"{recording.duration_s:.6g} s; {MIN_SAMPLES} needed"
        )
    position, note = _position(part, rotor_to_rod_m_per_rad)
    notes = [*recording.notes, *([note] if note else [])]
    reference = part.signal(REFERENCE)
    known = np.isfinite(reference) & np.isfinite(position)
    samples = int(known.sum())
    if samples < len(part):
        notes.append(f"reference and position are both known in {samples} of {len(part)} samples")
    relative = part.rotor_position_rad - part.load_position_rad
    has_load = bool(np.isfinite(relative[known]).all())
    even = uniform(
        part.time_s, reference, position, *([np.where(known, relative, 0.0)] if has_load else [])
    )
    if even.note:
        notes.append(even.note)
    # Figures that need no grid come from the samples as they were measured.
    raw_error = (reference - position)[known]
    error = even.signals[0] - even.signals[1]
    asked = None if line_hz is None else line_at(error, even.rate_hz, line_hz)
    spectrum = amplitude_spectrum(error, even.rate_hz)
    emd = decompose(error, even.rate_hz, emd_settings)
    if emd.energy_ratio > OVERLAP:
        notes.append(
            f"empirical modes overlap (their energies add up to {emd.energy_ratio:.2f} of the "
            "error's): read neighbouring modes together"
        )
    return TrackingAnalysis(
        skip_s=skip_s,
        duration_s=float(even.time_s[-1]),
        rate_hz=even.rate_hz,
        samples=samples,
        error_std_m=float(raw_error.std()),
        error_rms_m=float(np.sqrt(np.mean(raw_error**2))),
        error_mean_m=float(raw_error.mean()),
        error_max_m=float(np.abs(raw_error).max()),
        lag=lag_and_gain(even.signals[0], even.signals[1], even.rate_hz),
        lines=dominant_lines(spectrum),
        spectrum=spectrum,
        emd=emd,
        notes=tuple(notes),
        time_s=even.time_s,
        reference_m=even.signals[0],
        position_m=even.signals[1],
        error_m=error,
        relative_angle_rad=even.signals[2] - even.signals[2].mean() if has_load else None,
        asked=asked,
    )


def _position(part: Recording, factor: float | None) -> tuple[FloatArray, str]:
    if part.has(ROD):
        return part.signal(ROD), ""
    if factor is None:
        raise InputError(
            f"{ROD} is not measured in the part analysed; give the rotor-to-rod factor "
            f"(lead / (2 pi gear_ratio), m/rad) to use {ROTOR} instead"
        )
    if not np.isfinite(factor) or factor == 0.0:
        raise InputError(f"rotor-to-rod factor is {factor:g}, expected m/rad other than 0")
    if not part.has(ROTOR):
        raise InputError(f"neither {ROD} nor {ROTOR} is measured in the part analysed")
    return (
        part.signal(ROTOR) * factor,
        f"{ROD} is not measured: taken from {ROTOR} times {factor:.6g} m/rad",
    )
