"""What a case's seed fixes before any effect: motion, the healthy machine, its peaks."""

from __future__ import annotations

import math
import zlib
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....arrays import FloatArray
from ....drive.drive_file import drive_to_flat
from ....drive.parameters import DriveParameters
from ....errors import InputError
from .effects import EFFECTS
from .excitation import draw_reference
from .imposed import Scale, Values
from .machine import Run, noise_floor, record_machine, run_machine
from .nuisances import Nuisances, add_nuisances, steps_of
from .physics import Physics, nominal_physics
from .sheet import draw_errors, draw_feed, off_sheet, taken_by

DURATION_S = 12.0
PEAK_SPEED_RAD_S = 26.0  # of the rotor that a reference may ask for, unless a setup says more
NOMINAL = 1.1  # recorded minus nominal without any effect, in floors, at most this everywhere
QUIET_COMMAND = 0.15  # a command without noise is held to this share of what noise would make it
_IN_TIME = ("periodic_disturbance",)  # effects with a phase of time
_BETWEEN_NS = 60_000_000_000  # from the begin of one recording to that of the next
DRAWS = 60  # before no machine is called possible
_KEPT = 4  # stages: a case is drawn on one and recorded on it


@dataclass(frozen=True)
class Setup:
    """A drive as its file has it, and how it is moved and recorded.

    Attributes:
        drive: the data sheet and the controller.
        peak_speed: of the rotor that a reference may ask for, rad/s.
        missing: signals that the recording lacks.
        drawn: whether the drive is the case's own.
        several: how many recordings there are of each machine, and how long each is, s; None: one
            of the usual length.
        silent: whether the drive's file states no tolerances.
        full_draws, shrinks: of nuisances: draws at full size, and the factor of size from each
            later draw to the next.
    """

    drive: DriveParameters
    peak_speed: float = PEAK_SPEED_RAD_S
    missing: frozenset[str] = frozenset()
    drawn: bool = False
    several: tuple[int, float] | None = None
    silent: bool = False
    full_draws: int = 10
    shrinks: float = 0.8

    @classmethod
    def of(cls, drive: DriveParameters | Setup) -> Setup:
        """A drive with everything recorded, or the setup itself."""
        return drive if isinstance(drive, Setup) else cls(drive)

    @property
    def facts(self) -> dict[str, Any]:
        """What a label says of the setup; nothing where the drive file is the study's own."""
        found: dict[str, Any] = {}
        if self.several is not None:
            found = {"recordings": self.several[0], "seconds_each": self.several[1]}
        if not self.drawn:
            return found
        flat = drive_to_flat(self.drive).items()
        numbers = {key: one for key, one in flat if one != math.inf}
        return found | {"missing": sorted(self.missing), "drive": numbers}

    @property
    def duration_s(self) -> float:
        """Of each recording."""
        return DURATION_S if self.several is None else self.several[1]

    def reference(self, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
        """A motion of one recording: position m and velocity m/s at each control tick."""
        drive = self.drive
        speed = min(self.peak_speed * drive.transmission.rod_per_rotor, drive.limits.speed)
        return draw_reference(rng, self.duration_s, 1.0 / drive.controller.rate, speed)

    @property
    def floor(self) -> dict[str, float]:
        """Noise floor of each signal that is recorded."""
        floor = noise_floor(self.drive)
        return {name: value for name, value in floor.items() if name not in self.missing}


@dataclass(frozen=True)
class Stage:
    """What a case's seed fixes before any effect.

    Attributes:
        reference: position m and velocity m/s at each control tick.
        machine: the healthy machine at its sheet's values, with what makes it a little different.
        errors: relative ones of its constants; the machine has them, its controller does not.
        nuisances, scale: of it; peaks are those of a machine with these constants.
        healthy: its run without noise.
        number: of the recording among several.
    """

    reference: tuple[FloatArray, FloatArray]
    machine: Physics
    errors: Mapping[str, float]
    nuisances: Nuisances
    scale: Scale
    healthy: Run
    number: int = 0

    @classmethod
    def of(cls, seed: int, drive: DriveParameters | Setup, sheet: float = 0.0) -> Stage:
        """Draw reference, nuisances and errors; nuisances that a nominal model notices are redrawn.

        The last few are remembered.

        sheet: relative standard deviation of the machine's constants off the drive's.
        """
        asked = (seed, Setup.of(drive), sheet)
        for of, stage in _last:
            if of == asked:
                return stage
        stage = cls._drawn(*asked)
        _last.append((asked, stage))
        return stage

    @classmethod
    def _drawn(cls, seed: int, setup: Setup, sheet: float) -> Stage:
        """See `of`."""
        drive = setup.drive
        _check_noise(drive)
        rng = np.random.default_rng([seed, 0])
        reference = setup.reference(rng)
        plain = Nuisances(steps_of(drive), 0.0, 0.0, 0, 0)
        nominal = run_machine(nominal_physics(drive), plain, drive, reference)
        if not nominal.finite:
            raise InputError("the drive is unstable with its nominal parameters; no case drawn")
        made, nuisances = _made(nominal, setup, reference, rng)
        draws = np.random.default_rng([seed, 4])
        for _ in range(DRAWS if sheet else 1):
            errors = draw_errors(draws, sheet)
            errors |= draw_feed(draws, errors)
            own = (
                nominal
                if not sheet
                else run_machine(off_sheet(nominal_physics(drive), errors), plain, drive, reference)
            )
            healthy = run_machine(off_sheet(made, errors), nuisances, drive, reference)
            if own.finite and healthy.finite:
                return cls(reference, made, errors, nuisances, _scale(own, drive), healthy)
        raise InputError(f"no machine off its sheet by {sheet:g} is stable under its controller")

    def others(self, seed: int, setup: Setup) -> list[Stage]:
        """The same machine in further recordings, each with a motion and a noise of its own.

        Raises InputError where the machine is not stable on one of them.
        """
        return [
            self.on(setup.reference(np.random.default_rng([seed, 5, number])), number, setup.drive)
            for number in range(1, setup.several[0] if setup.several else 1)
        ]

    def on(
        self, reference: tuple[FloatArray, FloatArray], number: int, drive: DriveParameters
    ) -> Stage:
        """The same machine in its recording of this number, with a motion and a noise of its own.

        reference: position m and velocity m/s at each control tick.

        Raises InputError where the machine is not stable on it.
        """
        nuisances = replace(
            self.nuisances,
            noise_seed=self.nuisances.noise_seed + number,
            epoch_ns=self.nuisances.epoch_ns + number * _BETWEEN_NS,
        )
        machine = off_sheet(self.machine, self.errors)
        healthy = run_machine(machine, nuisances, drive, reference)
        if not healthy.finite:
            raise InputError("the machine is not stable on one of its motions; no case drawn")
        return replace(
            self, reference=reference, nuisances=nuisances, healthy=healthy, number=number
        )

    def with_effects(self, effects: Mapping[str, Values], seed: int) -> Physics:
        """The healthy machine with effects on it.

        A constant that an effect gives a value of its own is not off the sheet beside that.
        """
        taken = taken_by(effects)
        errors = {key: value for key, value in self.errors.items() if key not in taken}
        machine = off_sheet(self.machine, errors)
        for name, values in effects.items():
            EFFECTS[name].impose(machine, values, hidden_phases(name, seed, self.number))
        return machine


_last: deque[tuple[tuple[int, Setup, float], Stage]] = deque(maxlen=_KEPT)


def hidden_phases(name: str, seed: int, number: int = 0) -> FloatArray:
    """Phases of an effect in a case's recording of this number, float64[2], rad."""
    # No clock ties what swings in time to the begin of a recording.
    own = [number] if name in _IN_TIME and number else []
    phases = np.random.default_rng([seed, zlib.crc32(name.encode()), *own])
    return phases.uniform(0.0, 2.0 * np.pi, size=2)


def _check_noise(drive: DriveParameters) -> None:
    for sensor in ("rotor_position", "rotor_velocity", "current", "rod_position"):
        if getattr(drive.sensors, f"{sensor}_noise") <= 0.0:
            raise InputError(
                f"sensors.{sensor}_noise is 0, expected the drive's own noise: effects are "
                "drawn and judged against it"
            )


def _made(
    nominal: Run, setup: Setup, reference: tuple[FloatArray, FloatArray], rng: np.random.Generator
) -> tuple[Physics, Nuisances]:
    """A machine that the nominal model, `nominal`, does not tell from itself."""
    drive = setup.drive
    scale, floor = _scale(nominal, drive), setup.floor
    bound = dict(floor)
    if "voltage_q_v" in floor:
        bound["voltage_q_v"] *= QUIET_COMMAND
    for attempt in range(DRAWS):
        size = setup.shrinks ** max(0, attempt - setup.full_draws)
        machine, nuisances = add_nuisances(
            nominal_physics(drive), drive, scale.torque_nm, rng, size
        )
        recorded = record_machine(machine, nuisances, drive, reference)
        gap = {name: rms(recorded.signal(name) - nominal.signals[name]) for name in floor}
        if all(gap[name] <= NOMINAL * bound[name] for name in floor):
            return machine, nuisances
    raise InputError(
        f"no machine within {NOMINAL:g} noise floors of the nominal model in {DRAWS} draws: "
        "the sensors' noise in the drive file is too small for its other values"
    )


def rms(values: FloatArray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def peak(values: FloatArray) -> float:
    """Largest absolute value."""
    return float(np.max(np.abs(values)))


def gaps_between(run: Run, other: Run, floor: Mapping[str, float]) -> dict[str, float]:
    """RMS of the difference of two runs in noise floors, by signal of `floor`."""
    return {name: rms(run.signals[name] - other.signals[name]) / floor[name] for name in floor}


def _scale(run: Run, drive: DriveParameters) -> Scale:
    current = peak(run.signals["current_q_a"])
    return Scale(
        torque_nm=drive.motor.torque_constant * current,
        current_a=current,
        voltage_v=peak(run.signals["voltage_q_v"]),
        speed_rad_s=peak(run.signals["rotor_velocity_rad_per_s"]),
        stroke_m=peak(run.signals["rod_position_m"]),
    )
