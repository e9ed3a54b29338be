"""Drawing the cases of a study: balanced over the catalogue, each effect visible, none absurd."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from ...drive.parameters import DriveParameters
from ...effects.catalogue import CATALOGUE
from ...errors import InputError
from ...recording.signals import Recording
from .excitation import FloatArray, draw_reference
from .imposed import Draw, Imposed, Scale, Values
from .inside import INSIDE
from .machine import Run, noise_floor, record_machine, run_machine
from .nuisances import Nuisances, add_nuisances
from .outside import OUTSIDE
from .physics import Physics, nominal_physics

KINDS = ("single", "pair", "none", "outside", "withheld", "beyond")
SHARES = {
    "single": 0.46,
    "pair": 0.2,
    "none": 0.2,
    "outside": 0.08,
    "withheld": 0.04,
    "beyond": 0.02,
}

DURATION_S = 12.0
PEAK_SPEED_RAD_S = 26.0  # of the rotor that a reference may ask for
VISIBLE = 4.0  # an effect's gap in at least one signal, in noise floors of that signal
NOMINAL = 1.1  # recorded minus nominal without any effect, in floors, at most this everywhere
QUIET_COMMAND = 0.15  # a command without noise is held to this share of what noise would make it
ABSURD = 3.0  # peak speed, current or voltage over the nominal drive's, at most
FULL_SIZE_DRAWS = 10  # of nuisances, before they are drawn smaller and smaller
DRAWS = 60  # before an effect is called impossible to show on a drive

# Two forms of one friction: a pair of them is one friction of the second form.
SAME_CAUSE = ({"rotor_coulomb_friction", "stribeck_friction"},)

EFFECTS: dict[str, Imposed] = INSIDE | OUTSIDE


@dataclass(frozen=True)
class Case:
    """One drawn drive; everything about it follows from these fields and the nominal drive.

    Attributes:
        index: place in the study.
        seed: of reference, nuisances, phases and noise.
        kind: one of `KINDS`: one effect of the contract's catalogue; two; none; one that the
            diagnosis does not know; one of the catalogue withheld from it; one beyond the
            contract's catalogue that it may know.
        effects: true parameters by effect; empty for `none`.
        withheld: effects that the diagnosis is not given.
        gaps: for each effect its own gap (the others in place) in noise floors, by signal.
    """

    index: int
    seed: int
    kind: str
    effects: dict[str, Values] = field(default_factory=dict)
    withheld: tuple[str, ...] = ()
    gaps: dict[str, dict[str, float]] = field(default_factory=dict)

    def label(self) -> dict[str, Any]:
        """What is sealed: plain data."""
        return {
            "index": self.index,
            "seed": self.seed,
            "kind": self.kind,
            "effects": self.effects,
            "withheld": list(self.withheld),
            "gaps": self.gaps,
        }

    @classmethod
    def from_label(cls, label: dict[str, Any]) -> Case:
        """The case of which `label` is the label."""
        return cls(**{**label, "withheld": tuple(label["withheld"])})

    @property
    def names(self) -> set[str]:
        """The case's effects as a catalogue may call them."""
        return {EFFECTS[name].twin or name for name in self.effects}

    @property
    def nameable(self) -> set[str]:
        """Those of them that the diagnosis was given, if it knows them."""
        return {name for name in self.names - set(self.withheld) if not name.startswith("x_")}

    @property
    def blocks(self) -> set[str]:
        """Where the case's effects act."""
        return {EFFECTS[name].block for name in self.effects}


@dataclass(frozen=True)
class Stage:
    """What a case's seed fixes before any effect: motion, the healthy machine, its peaks."""

    reference: tuple[FloatArray, FloatArray]
    machine: Physics
    nuisances: Nuisances
    scale: Scale
    healthy: Run

    @classmethod
    def of(cls, seed: int, drive: DriveParameters) -> Stage:
        """Draw reference and nuisances; nuisances that a nominal model would notice are redrawn."""
        for sensor in ("rotor_position", "rotor_velocity", "current", "rod_position"):
            if getattr(drive.sensors, f"{sensor}_noise") <= 0.0:
                raise InputError(
                    f"sensors.{sensor}_noise is 0, expected the drive's own noise: effects are "
                    "drawn and judged against it"
                )
        rng = np.random.default_rng([seed, 0])
        tick_s = 1.0 / drive.controller.rate
        speed = min(PEAK_SPEED_RAD_S * drive.transmission.rod_per_rotor, drive.limits.speed)
        reference = draw_reference(rng, DURATION_S, tick_s, speed)
        plain = Nuisances(max(1, round(tick_s / 1e-5)), 0.0, 0.0, 0, 0)
        nominal = run_machine(nominal_physics(drive), plain, drive, reference)
        if not nominal.finite:
            raise InputError("the drive is unstable with its nominal parameters; no case drawn")
        scale = _scale(nominal, drive)
        floor = noise_floor(drive)
        for attempt in range(DRAWS):
            size = 0.8 ** max(0, attempt - FULL_SIZE_DRAWS)
            machine, nuisances = add_nuisances(
                nominal_physics(drive), drive, scale.torque_nm, rng, size
            )
            recorded = record_machine(machine, nuisances, drive, reference)
            gap = {name: _rms(recorded.signal(name) - nominal.signals[name]) for name in floor}
            bound = floor | {"voltage_q_v": QUIET_COMMAND * floor["voltage_q_v"]}
            if all(gap[name] <= NOMINAL * bound[name] for name in floor):
                healthy = run_machine(machine, nuisances, drive, reference)
                return cls(reference, machine, nuisances, scale, healthy)
        raise InputError(
            f"no machine within {NOMINAL:g} noise floors of the nominal model in {DRAWS} draws: "
            "the sensors' noise in the drive file is too small for its other values"
        )

    def with_effects(self, effects: dict[str, Values], seed: int) -> Physics:
        """The healthy machine with effects on it."""
        machine = replace(self.machine)
        for name, values in effects.items():
            phases = np.random.default_rng([seed, zlib.crc32(name.encode())])
            EFFECTS[name].impose(machine, values, phases.uniform(0.0, 2.0 * np.pi, size=2))
        return machine


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _peak(values: FloatArray) -> float:
    return float(np.max(np.abs(values)))


def _scale(run: Run, drive: DriveParameters) -> Scale:
    current = _peak(run.signals["current_q_a"])
    return Scale(
        torque_nm=drive.motor.torque_constant * current,
        current_a=current,
        voltage_v=_peak(run.signals["voltage_q_v"]),
        speed_rad_s=_peak(run.signals["rotor_velocity_rad_per_s"]),
        stroke_m=_peak(run.signals["rod_position_m"]),
    )


def _absurd(run: Run, stage: Stage) -> bool:
    """Whether the machine runs away, or does what nobody would record."""
    if not run.finite:
        return True
    names = ("rotor_velocity_rad_per_s", "current_q_a", "voltage_q_v", "rod_position_m")
    return any(_peak(run.signals[n]) > ABSURD * _peak(stage.healthy.signals[n]) for n in names)


def _gaps(run: Run, other: Run, floor: dict[str, float]) -> dict[str, float]:
    return {name: _rms(run.signals[name] - other.signals[name]) / floor[name] for name in floor}


def draw_effects(
    names: Iterable[str], seed: int, drive: DriveParameters
) -> tuple[dict[str, Values], dict[str, dict[str, float]]]:
    """(parameters, gaps) of named effects on the machine of `seed`, redrawn until all are visible.

    An effect is visible if taking it alone out of the machine changes some signal by `VISIBLE`
    noise floors. Raises InputError naming the effects where no draw shows them.
    """
    names = list(names)
    if not names:
        return {}, {}
    stage, floor = Stage.of(seed, drive), noise_floor(drive)
    rng = np.random.default_rng([seed, 1])

    def run(effects: dict[str, Values]) -> Run:
        if not effects:
            return stage.healthy
        machine = stage.with_effects(effects, seed)
        return run_machine(machine, stage.nuisances, drive, stage.reference)

    for _ in range(DRAWS):
        draw = Draw(rng, drive, stage.scale)
        effects = {name: EFFECTS[name].draw(draw) for name in names}
        complete = run(effects)
        if _absurd(complete, stage):
            continue
        gaps = {}
        for name in names:
            rest = {other: values for other, values in effects.items() if other != name}
            gaps[name] = _gaps(complete, run(rest), floor)
        if all(max(gap.values()) >= VISIBLE for gap in gaps.values()):
            return effects, gaps
    raise InputError(f"{' with '.join(names)}: no visible and sane size in {DRAWS} draws")


def _rounds(names: list[str], rng: np.random.Generator) -> Iterator[str]:
    """Every name once in random order, then again: equally often however many are taken."""
    while True:
        yield from (names[index] for index in rng.permutation(len(names)))


def plan_cases(
    count: int,
    seed: int,
    *,
    kinds: tuple[str, ...] = KINDS,
    effects: tuple[str, ...] | None = None,
    without: tuple[str, ...] = (),
) -> list[Case]:
    """Cases without parameters: kinds in their shares, effects equally often, in mixed order.

    Args:
        count: cases.
        seed: the same count and seed give the same cases.
        kinds: of these kinds alone, in the same proportion to each other.
        effects: cases of these effects alone; the second effect of a pair is any.
        without: effects that no diagnosis of this study is given; only withheld cases hold them.
    """
    rng = np.random.default_rng([seed, count])
    chosen = [name for name in EFFECTS if effects is None or name in effects]
    inside = [name for name in chosen if name in INSIDE and name not in without]
    outside = [name for name in chosen if name in OUTSIDE]
    withheld = [name for name in chosen if name in INSIDE and (not without or name in without)]
    beyond = [name for name in outside if EFFECTS[name].twin and EFFECTS[name].twin not in without]
    names_of = {
        "single": inside,
        "pair": inside,
        "outside": outside,
        "withheld": withheld,
        "beyond": beyond,
    }
    usable = [kind for kind in KINDS if kind in kinds and (kind == "none" or names_of[kind])]
    if not usable:
        raise InputError(
            f"no case is left of --kinds {','.join(kinds)} with the effects asked for; "
            "expected x_ effects for outside, the catalogue's for the others"
        )
    rounds = {kind: _rounds(names, rng) for kind, names in names_of.items()}
    partners = _rounds([name for name in INSIDE if name not in without], rng)
    cases = []
    for index, kind in enumerate(_kinds(count, usable, rng)):
        names = [] if kind == "none" else [next(rounds[kind])]
        if kind == "pair":
            names.append(
                next(
                    name
                    for name in partners
                    if name != names[0] and {names[0], name} not in SAME_CAUSE
                )
            )
        hidden = set(without) | (set(names) if kind == "withheld" else set())
        # A finer form of what is left out would be that same cause under another name.
        hidden |= {finer for finer, one in CATALOGUE.items() if hidden & set(one.refines)}
        if kind == "outside":
            hidden |= {twin for name in names if (twin := EFFECTS[name].twin)}
        cases.append(
            Case(
                index=index,
                seed=int(rng.integers(2**31)),
                kind=kind,
                effects={name: {} for name in names},
                withheld=tuple(sorted(hidden)),
            )
        )
    return cases


def _kinds(count: int, usable: list[str], rng: np.random.Generator) -> list[str]:
    """A kind for each case: in the shares of `SHARES`, largest remainders rounded up, mixed."""
    total = sum(SHARES[kind] for kind in usable)
    wanted = {kind: SHARES[kind] / total * count for kind in usable}
    numbers = {kind: int(wanted[kind] + 1e-9) for kind in usable}
    by_remainder = sorted(usable, key=lambda kind: numbers[kind] - wanted[kind])
    for kind in by_remainder[: count - sum(numbers.values())]:
        numbers[kind] += 1
    return [str(kind) for kind in rng.permutation([k for k in usable for _ in range(numbers[k])])]


def complete_case(case: Case, drive: DriveParameters) -> Case:
    """The planned case with parameters drawn so that its effects are visible."""
    for attempt in range(5):  # another motion where this one shows the effects at no sane size
        seed = case.seed + attempt
        try:
            effects, gaps = draw_effects(case.effects, seed, drive)
        except InputError:
            if attempt == 4:
                raise
        else:
            return replace(case, seed=seed, effects=effects, gaps=gaps)
    raise AssertionError("unreachable")


def draw_cases(
    count: int,
    seed: int,
    drive: DriveParameters,
    *,
    kinds: tuple[str, ...] = KINDS,
    effects: tuple[str, ...] | None = None,
    without: tuple[str, ...] = (),
    workers: int = 1,
    progress: Callable[[float], None] | None = None,
) -> list[Case]:
    """Draw a study; arguments as in `plan_cases`.

    workers: processes. progress: called with the share done, 0 to 1.
    """
    plan = plan_cases(count, seed, kinds=kinds, effects=effects, without=without)
    done = Parallel(n_jobs=min(workers, count), return_as="generator")(
        delayed(complete_case)(case, drive) for case in plan
    )
    cases = []
    for case in done:
        cases.append(case)
        if progress is not None:
            progress(len(cases) / count)
    return cases


def record_case(case: Case, drive: DriveParameters) -> Recording:
    """The recording of a case's machine."""
    stage = Stage.of(case.seed, drive)
    machine = stage.with_effects(case.effects, case.seed)
    return record_machine(machine, stage.nuisances, drive, stage.reference)
