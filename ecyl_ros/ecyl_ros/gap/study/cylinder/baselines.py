"""What others would name: all nominal parameters fitted at once, and the best single swap.

Both fit the nominal model's own parameters in closed loop on the engine.
Neither has a form for an effect the model lacks; what they name is what absorbs it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from ....arrays import FloatArray
from ....drive.engine import VOLTAGE, simulate
from ....drive.parameters import DriveParameters, SensorParameters
from ....drive.reference.recorded import Recorded
from ....recording.signals import Recording
from .machine import noise_floor

Baseline = Callable[[Recording, DriveParameters], list[str]]

# Every physical number of the nominal model, with the effect that its being wrong is called.
PARAMETERS: dict[tuple[str, str], str] = {
    ("motor", "resistance"): "resistance_error",
    ("motor", "inductance"): "inductance_error",
    ("motor", "torque_constant"): "torque_constant_error",
    ("motor", "back_emf_constant"): "back_emf_error",
    ("motor", "rotor_inertia"): "rotor_inertia_error",
    ("motor", "viscous_friction"): "rotor_viscous_friction",
    ("transmission", "lead"): "lead_error",
    ("transmission", "backlash"): "backlash_error",
    ("transmission", "stiffness"): "stiffness_error",
    ("transmission", "contact_damping"): "contact_damping_error",
    ("load", "inertia"): "load_inertia_error",
    ("load", "viscous_friction"): "load_viscous_friction",
}
LARGEST_FACTOR = 5.0  # a parameter is sought between nominal over this and nominal times this
FITS = 30  # trial steps of the fit of all parameters; most settle in fewer
SINGLE_FITS = 6  # of one parameter alone
STRETCH_S = 8.0  # of the recording that is fitted to, from its start
WORTH = 0.1  # share of the pooled gap a swap must remove to be named
AT_FLOOR = 1.2  # pooled gap in noise floors up to which nothing is named


def _scaled(drive: DriveParameters, logs: dict[tuple[str, str], float]) -> DriveParameters:
    """The drive with parameters multiplied by exp(log)."""
    for (group, name), log in logs.items():
        part = getattr(drive, group)
        value = getattr(part, name)
        factor = math.exp(log)
        changed = (
            tuple(factor * one for one in value) if isinstance(value, tuple) else factor * value
        )
        drive = replace(drive, **{group: replace(part, **{name: changed})})
    return drive


class ClosedLoop:
    """Residuals of the nominal model against a recording, as a function of its parameters."""

    def __init__(self, recording: Recording, drive: DriveParameters) -> None:
        """Take every signal of the recording that the model gives, over its noise floor."""
        recording = recording.slice(0.0, STRETCH_S)
        self._drive = replace(drive, sensors=SensorParameters())
        rate = drive.sample_rate
        count = len(recording)
        reference = Recorded.from_recording(recording, "recording")
        self._reference = [reference.sample(index / rate) for index in range(count + 1)]
        self._duration_s = count / rate
        self._measured = {
            name: (recording.signal(name), floor)
            for name, floor in noise_floor(drive).items()
            if recording.has(name)
        }

    def residuals(self, logs: dict[tuple[str, str], float]) -> FloatArray:
        """(recorded - simulated) / floor of all signals in a row, limited to 1e6."""
        run = simulate(
            _scaled(self._drive, logs), lambda index: self._reference[index], self._duration_s
        )
        parts = []
        for name, (values, floor) in self._measured.items():
            model = run.samples[:, VOLTAGE + 1] if name == "voltage_q_v" else run.signal(name)
            parts.append((values - model) / floor)
        return np.clip(np.nan_to_num(np.concatenate(parts), nan=1e6), -1e6, 1e6)

    def fit(
        self, keys: list[tuple[str, str]], evaluations: int
    ) -> tuple[FloatArray, FloatArray, float]:
        """(logarithmic changes, their 95 % half widths, RMS residual) of a least-squares fit."""
        bound = math.log(LARGEST_FACTOR)
        found = least_squares(
            lambda x: self.residuals(dict(zip(keys, x, strict=True))),
            np.zeros(len(keys)),
            bounds=(-bound, bound),
            diff_step=1e-3,
            x_scale=0.1,
            max_nfev=evaluations,
        )
        freedom = len(found.fun) - len(keys)
        variance = 2.0 * found.cost / freedom
        covariance = variance * np.linalg.pinv(found.jac.T @ found.jac)
        half = student.ppf(0.975, freedom) * np.sqrt(np.maximum(np.diag(covariance), 0.0))
        return found.x, half, float(np.sqrt(np.mean(found.fun**2)))


def _keys(drive: DriveParameters) -> list[tuple[str, str]]:
    """Parameters that are there to be scaled; a friction of zero is not."""

    def value(group: str, name: str) -> float:
        found = getattr(getattr(drive, group), name)
        return found[0] if isinstance(found, tuple) else found

    return [key for key in PARAMETERS if value(*key) > 0.0]


def fit_all(recording: Recording, drive: DriveParameters) -> list[str]:
    """Fit all parameters at once; names those off nominal by more than their 95 % interval.

    The largest relative move comes first, as a user would read it.
    """
    keys = _keys(drive)
    moves, half, _ = ClosedLoop(recording, drive).fit(keys, FITS)
    order = np.argsort(-np.abs(moves))
    return [PARAMETERS[keys[index]] for index in order if abs(moves[index]) > half[index]]


def best_swap(recording: Recording, drive: DriveParameters) -> list[str]:
    """Fit each parameter alone; names the one that removes most, if that is worth a name."""
    loop = ClosedLoop(recording, drive)
    before = float(np.sqrt(np.mean(loop.residuals({}) ** 2)))
    if before <= AT_FLOOR:
        return []
    after = {key: loop.fit([key], SINGLE_FITS)[2] for key in _keys(drive)}
    best = min(after, key=lambda key: after[key])
    return [PARAMETERS[best]] if after[best] <= (1.0 - WORTH) * before else []


BASELINES: dict[str, Baseline] = {
    "all parameters at once": fit_all,
    "best single parameter": best_swap,
}
