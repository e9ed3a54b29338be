"""The signals of one recording as equally long arrays in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, StampArray
from .frame import from_frame, to_frame

if TYPE_CHECKING:
    from pandas import DataFrame


# Every signal by name, with its unit. The names are the fields of `Recording`, the columns of a
# CSV file and what messages to the user call them.
SIGNALS: dict[str, str] = {
    "reference_position_m": "m",
    "reference_velocity_m_per_s": "m/s",
    "rotor_position_rad": "rad",
    "rotor_velocity_rad_per_s": "rad/s",
    "rotor_torque_nm": "N m",
    "rod_position_m": "m",
    "rod_velocity_m_per_s": "m/s",
    "rod_force_n": "N",
    "load_position_rad": "rad",
    "load_velocity_rad_per_s": "rad/s",
    "current_d_a": "A",
    "current_q_a": "A",
    "voltage_d_v": "V",
    "voltage_q_v": "V",
}

# What only recordings of other machines hold: no topic of ours carries it. A `mode` is a number
# that says which state a drive was in (a flag, a gain set); what it counts is the drive's own.
FOREIGN_SIGNALS: dict[str, str] = {
    "reference_position_rad": "rad",
    "reference_velocity_rad_per_s": "rad/s",
    "injected_force_n": "N",
    "injected_torque_nm": "N m",
    "mode": "1",
}

_NOT_GIVEN: Any = None  # becomes NaN throughout


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Recording:
    """Signals of one run on one grid of stamps.

    Every signal is a read-only float64[n] in SI units, NaN where nothing measured it; a signal
    that is not given at all is NaN throughout.

    Attributes:
        stamp_ns: int64[n], sample instants in ns, strictly increasing.
        reference_position_m, reference_velocity_m_per_s: what the rod was asked to do.
        rotor_position_rad, rotor_velocity_rad_per_s: the motor encoder.
        rotor_torque_nm: torque constant x i_q.
        rod_position_m, rod_velocity_m_per_s, rod_force_n: the rod's scale and force sensor.
        load_position_rad, load_velocity_rad_per_s: the load side at the rotor; known only in
            emulated drives.
        current_d_a, current_q_a: measured dq currents (power or amplitude invariance as the drive
            has it; the torque constant goes with it).
        voltage_d_v, voltage_q_v: commanded dq voltages.
        reference_position_rad, reference_velocity_rad_per_s: what a rotary output was asked to do.
        injected_force_n: a known force put on the rod from outside, positive along its motion.
        injected_torque_nm: a known torque put on the rotor beside what the loop commands: a test
            signal, a feedforward.
        mode: which state the drive was in, as a number.
        resolution: signal -> step in SI that it was quantised to, of those for which it is known.
        notes: one line each on what is missing or was cut off when the recording was read.

    Raises:
        ValueError: arrays of unequal length, not one-dimensional, or stamps that do not increase.
    """

    stamp_ns: StampArray
    reference_position_m: FloatArray = _NOT_GIVEN
    reference_velocity_m_per_s: FloatArray = _NOT_GIVEN
    rotor_position_rad: FloatArray = _NOT_GIVEN
    rotor_velocity_rad_per_s: FloatArray = _NOT_GIVEN
    rotor_torque_nm: FloatArray = _NOT_GIVEN
    rod_position_m: FloatArray = _NOT_GIVEN
    rod_velocity_m_per_s: FloatArray = _NOT_GIVEN
    rod_force_n: FloatArray = _NOT_GIVEN
    load_position_rad: FloatArray = _NOT_GIVEN
    load_velocity_rad_per_s: FloatArray = _NOT_GIVEN
    current_d_a: FloatArray = _NOT_GIVEN
    current_q_a: FloatArray = _NOT_GIVEN
    voltage_d_v: FloatArray = _NOT_GIVEN
    voltage_q_v: FloatArray = _NOT_GIVEN
    reference_position_rad: FloatArray = _NOT_GIVEN
    reference_velocity_rad_per_s: FloatArray = _NOT_GIVEN
    injected_force_n: FloatArray = _NOT_GIVEN
    injected_torque_nm: FloatArray = _NOT_GIVEN
    mode: FloatArray = _NOT_GIVEN
    resolution: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        stamps = np.array(self.stamp_ns)
        if stamps.ndim != 1 or not np.issubdtype(stamps.dtype, np.integer):
            raise ValueError("stamp_ns must be a one-dimensional array of integers")
        stamps = stamps.astype(np.int64, copy=False)
        if np.any(stamps[1:] <= stamps[:-1]):
            raise ValueError("stamp_ns must increase strictly")
        self._freeze("stamp_ns", stamps)
        for name in (*SIGNALS, *FOREIGN_SIGNALS):
            given = getattr(self, name)
            if given is _NOT_GIVEN:
                values = np.full(stamps.size, np.nan)
            else:
                values = np.array(given, dtype=np.float64)
            if values.shape != stamps.shape:
                raise ValueError(f"{name} has shape {values.shape}, stamp_ns {stamps.shape}")
            self._freeze(name, values)

    def _freeze(self, name: str, values: NDArray[Any]) -> None:
        values.setflags(write=False)
        object.__setattr__(self, name, values)

    def __len__(self) -> int:
        return int(self.stamp_ns.size)

    @cached_property
    def time_s(self) -> FloatArray:
        """float64[n], seconds since the first stamp.

        The difference is taken between integers: a float of seconds since 1970 resolves only
        0.2 us.
        """
        return (self.stamp_ns - self.stamp_ns[:1]) / 1e9

    @property
    def rate_hz(self) -> float:
        """Sampling rate from the median step between stamps; NaN with fewer than two samples."""
        if len(self) < 2:
            return float("nan")
        return 1e9 / float(np.median(np.diff(self.stamp_ns)))

    @property
    def duration_s(self) -> float:
        """Time from the first to the last stamp, 0 for an empty recording."""
        return float(self.time_s[-1]) if len(self) else 0.0

    def has(self, name: str) -> bool:
        """Whether the signal was measured at one instant or more (a finite value)."""
        return bool(np.isfinite(self.signal(name)).any())

    def signal(self, name: str) -> FloatArray:
        """float64[n] by its name in `SIGNALS` or `FOREIGN_SIGNALS`; KeyError for another name."""
        if name not in SIGNALS and name not in FOREIGN_SIGNALS:
            raise KeyError(name)
        values: FloatArray = getattr(self, name)
        return values

    def slice(self, start_s: float = 0.0, stop_s: float = float("inf")) -> Recording:
        """The part with start_s <= time_s < stop_s; stamps keep their values."""
        return self.at(np.flatnonzero((self.time_s >= start_s) & (self.time_s < stop_s)))

    def at(self, rows: NDArray[np.int64]) -> Recording:
        """Some of the samples, by their rows int64[k] in rising order; stamps keep their values."""
        names = ("stamp_ns", *SIGNALS, *FOREIGN_SIGNALS)
        arrays = {name: getattr(self, name)[rows] for name in names}
        return replace(self, **arrays)

    def to_pandas(self) -> DataFrame:
        """The measured signals as columns by name, the index time in s since the first stamp.

        The column `stamp_ns` keeps the stamps whole; `attrs` hold `resolution` and `notes`.
        """
        names = (name for name in (*SIGNALS, *FOREIGN_SIGNALS) if self.has(name))
        signals = {name: self.signal(name) for name in names}
        return to_frame(self.stamp_ns, self.time_s, signals, self.resolution, self.notes)

    @classmethod
    def from_pandas(cls, frame: DataFrame) -> Recording:
        """The recording that a frame holds.

        Args:
            frame: columns by the names of the signals, SI units; others are left aside. The
                instants are the column `stamp_ns`, or the column `time_s`, or the index: dates,
                time spans, or seconds.

        Raises:
            InputError: no column with a signal's name, one that holds no numbers, or instants that
                are missing or do not increase.
        """
        return cls(**from_frame(frame, {*SIGNALS, *FOREIGN_SIGNALS}))

    def __repr__(self) -> str:
        names = ", ".join(name for name in (*SIGNALS, *FOREIGN_SIGNALS) if self.has(name))
        rate = f" at {self.rate_hz:.6g} Hz" if len(self) > 1 else ""
        return f"<recording: {self.duration_s:.6g} s{rate}: {names or 'nothing measured'}>"
