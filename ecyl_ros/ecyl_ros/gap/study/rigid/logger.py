"""What a data logger makes of a run: coarse counts, late effort, noise, frozen stretches."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....arrays import FloatArray
from ....recording.signals import Recording
from .motion import LOOP_HZ

RATES_HZ = (50.0, 100.0, 125.0, 200.0, 250.0, 500.0, 1000.0)
SPEEDS = ("missing", "differences", "own")  # how a speed comes into a recording
EPOCH_NS = 1_700_000_000_000_000_000


@dataclass(frozen=True)
class Logger:
    """How a drive is recorded.

    Attributes:
        rate_hz: of the samples.
        resolution: of the logged position, m or rad.
        speed: one of `SPEEDS`.
        reference: whether the reference is logged.
        effort_noise: standard deviation, in the unit of the recorded effort.
        ripple: amplitude and frequency, Hz, of a ripple on the effort far above the motion's band.
        lag_samples: by which the effort is logged late (early where negative), in samples.
        frozen: (start s, length s) of stretches in which every signal keeps its last value.
    """

    rate_hz: float
    resolution: float
    speed: str
    reference: bool
    effort_noise: float
    ripple: tuple[float, float]
    lag_samples: float
    frozen: tuple[tuple[float, float], ...]

    @property
    def every(self) -> int:
        """Ticks of the loop per sample."""
        return round(LOOP_HZ / self.rate_hz)


def draw_logger(
    rng: np.random.Generator,
    linear: bool,
    actuation: str,
    level: float,
    duration_s: float,
    prompt: bool,
) -> Logger:
    """A logger for a drive on whose effort a fault of `level` is to be seen.

    actuation: what is recorded. level: in its unit. prompt: log fast and in time, as who looks for
    a delay does.
    """
    rate = float(rng.choice([one for one in RATES_HZ if one >= 500.0] if prompt else RATES_HZ))
    speed = str(rng.choice(SPEEDS, p=(0.4, 0.3, 0.3)))
    if linear:
        resolution = float(np.exp(rng.uniform(*np.log([1e-6, 5e-5]))))
    else:
        resolution = math.tau / 2.0 ** int(rng.integers(8, 17))
    if actuation == "loop":  # its effort is told from what it saw, tick by tick: it logs itself
        rate, resolution, speed = LOOP_HZ, 1e-2 * resolution, "missing"
    frozen: list[tuple[float, float]] = []
    if rng.random() < 0.25:
        for _ in range(int(rng.integers(1, 4))):
            start = float(rng.uniform(0.1, 0.9)) * duration_s
            frozen.append((start, float(rng.uniform(0.1, 0.5))))
    lag = 0.0
    if not prompt and actuation != "loop" and rng.random() < 0.5:
        lag = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.0, 2.0))
    ripple = level * float(rng.uniform(0.1, 1.0)) if rng.random() < 0.4 else 0.0
    return Logger(
        rate_hz=rate,
        resolution=resolution,
        speed=speed,
        reference=actuation == "loop" or bool(rng.random() < 0.7),
        effort_noise=level * float(np.exp(rng.uniform(*np.log([0.01, 1.0])))),
        ripple=(ripple, rate * float(rng.uniform(0.3, 0.48))),
        lag_samples=lag,
        frozen=tuple(frozen),
    )


def quantised(values: FloatArray, step: float) -> FloatArray:
    """The nearest whole number of steps."""
    made: FloatArray = step * np.round(values / step)
    return made


def record(
    logger: Logger,
    rng: np.random.Generator,
    *,
    linear: bool,
    effort_signal: str | None,
    position: FloatArray,
    speed: FloatArray,
    effort: FloatArray,
    reference: FloatArray,
) -> Recording:
    """The recording of a run given at each tick of the loop; effort in the signal's own unit.

    effort_signal: field of `Recording`; None where no effort is recorded.
    """
    ticks = np.arange(0, position.size, logger.every)
    time = ticks / LOOP_HZ
    counts = quantised(position[ticks], logger.resolution)
    signals: dict[str, FloatArray] = {
        "rod_position_m" if linear else "rotor_position_rad": counts,
    }
    end = "m" if linear else "rad"
    if logger.reference:
        signals[f"reference_position_{end}"] = reference[ticks]
    if logger.speed == "differences":
        found = np.diff(counts, prepend=counts[0]) * logger.rate_hz
    elif logger.speed == "own":
        noise = 2e-3 * float(np.max(np.abs(speed)))
        found = speed[ticks] + noise * rng.normal(size=ticks.size)
    if logger.speed != "missing":
        signals["rod_velocity_m_per_s" if linear else "rotor_velocity_rad_per_s"] = found
    if effort_signal is not None:
        late = ticks - logger.lag_samples * logger.every
        seen = np.interp(late, np.arange(effort.size), effort)
        amplitude, hertz = logger.ripple
        seen += amplitude * np.sin(math.tau * hertz * time + rng.uniform(0.0, math.tau))
        signals[effort_signal] = seen + logger.effort_noise * rng.normal(size=ticks.size)
    kept = np.arange(ticks.size)
    for start, length in logger.frozen:
        stands = (time >= start) & (time < start + length)
        if stands.any():
            kept[stands] = np.flatnonzero(stands)[0]
    frozen: dict[str, Any] = {name: values[kept] for name, values in signals.items()}
    return Recording(stamp_ns=EPOCH_NS + np.round(time * 1e9).astype(np.int64), **frozen)
