"""The drives a study is drawn of: how cases are planned, completed, and handed to a diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple, Protocol

from ...drive.parameters import DriveParameters
from ...recording.signals import Recording
from .case import KINDS, LAW, Case
from .cylinder.baselines import BASELINES
from .cylinder.cases import complete_case, plan_cases, record_cases, stated
from .cylinder.effects import EFFECTS
from .cylinder.inside import INSIDE
from .cylinder.outside import OUTSIDE
from .cylinder.stage import Setup
from .random_drives import draw_setup
from .rigid import cases as rigid
from .rigid.faults import FAULTS
from .subject import Sheet
from .workers import in_processes

Baseline = Callable[[Recording, Any], list[str]]


@dataclass(frozen=True)
class Choice:
    """What is drawn: `kinds` alone, `effects` alone, and nothing `without` what no diagnosis knows.

    effects: None for all.
    """

    kinds: tuple[str, ...] = KINDS
    effects: tuple[str, ...] | None = None
    without: tuple[str, ...] = ()


class Given(NamedTuple):
    """What a diagnosis sees of a case, beside the names it has to do without.

    others: recordings of the same machine, to be diagnosed together with `recording`.
    """

    recording: Recording
    drive: Sheet
    others: tuple[Recording, ...] = ()


class Drives(Protocol):
    """A family of drives; picklable, so that workers can draw and record their cases."""

    @property
    def name(self) -> str:
        """As in labels and on the command line."""

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of case that can be drawn."""

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects that can be drawn."""

    @property
    def nameable(self) -> tuple[str, ...]:
        """Effects that a diagnosis can be made to do without."""

    @property
    def baselines(self) -> Mapping[str, Baseline]:
        """Other methods that answer the same question of such drives."""

    def plan(self, count: int, seed: int, choice: Choice) -> list[Case]:
        """Cases without parameters; the same for the same count, seed and choice."""

    def complete(self, case: Case) -> Case:
        """A planned case with everything drawn that its label holds."""

    def given(self, case: Case) -> Given:
        """The recording of the case's machine, and its sheet."""


class _Cylinders:
    """What all cylinders have in common."""

    kinds: tuple[str, ...] = (*KINDS, LAW)
    effects: tuple[str, ...] = tuple(EFFECTS)
    nameable: tuple[str, ...] = (*INSIDE, *(one.twin for one in OUTSIDE.values() if one.twin))
    baselines: Mapping[str, Baseline] = MappingProxyType(BASELINES)
    sheet: float
    name: str

    def setup(self, seed: int) -> Setup:
        """The data sheet behind a case, and how it is moved and recorded."""
        raise NotImplementedError

    def plan(self, count: int, seed: int, choice: Choice) -> list[Case]:
        """See `Drives`."""
        return plan_cases(
            count,
            seed,
            kinds=choice.kinds,
            effects=choice.effects,
            without=choice.without,
            drives=self.name,
            sheet=self.sheet,
        )

    def complete(self, case: Case) -> Case:
        """See `Drives`."""
        return complete_case(case, self.setup)

    def given(self, case: Case) -> Given:
        """See `Drives`."""
        setup = self.setup(case.seed)
        first, *others = record_cases(case, setup)
        return Given(first, stated(setup, case.sheet), tuple(others))


@dataclass(frozen=True)
class BenchDrives(_Cylinders):
    """Machines of one drive file, at its constants or off them by `sheet`, relative.

    several: how many recordings of each there are, and how long each is, s; None: one.
    silent: whether drive files state no tolerances, so that the documented ones hold.
    """

    drive: DriveParameters
    sheet: float = 0.0
    several: tuple[int, float] | None = None
    silent: bool = False
    name: str = field(default="bench", init=False)

    def setup(self, seed: int) -> Setup:
        """The study's own drive, whatever the seed."""
        return Setup(self.drive, several=self.several, silent=self.silent)


@dataclass(frozen=True)
class RandomDrives(_Cylinders):
    """A drive of its own in each case, its machine off the sheet by `sheet`, relative.

    several, silent: as `BenchDrives` has them.
    """

    sheet: float = 0.0
    several: tuple[int, float] | None = None
    silent: bool = False
    name: str = field(default="random", init=False)

    def setup(self, seed: int) -> Setup:
        """The drive of a seed."""
        return replace(draw_setup(seed), several=self.several, silent=self.silent)


@dataclass(frozen=True)
class RigidDrives:
    """Rigid drives of all kinds; `sheet`: standard deviation off their files, None as they come.

    several: how many recordings of each there are, and how long each is, s; None: one of 30 s.
    silent: as `BenchDrives` has it.
    """

    sheet: float | None = None
    several: tuple[int, float] | None = None
    silent: bool = False
    name: str = field(default="rigid", init=False)
    kinds: ClassVar[tuple[str, ...]] = rigid.KINDS
    effects: ClassVar[tuple[str, ...]] = tuple(FAULTS)
    nameable: ClassVar[tuple[str, ...]] = tuple(FAULTS)
    baselines: ClassVar[Mapping[str, Baseline]] = MappingProxyType({})

    def plan(self, count: int, seed: int, choice: Choice) -> list[Case]:
        """See `Drives`."""
        return rigid.plan_cases(
            count,
            seed,
            kinds=choice.kinds,
            effects=choice.effects,
            without=choice.without,
            sheet=self.sheet,
            several=self.several,
            silent=self.silent,
        )

    def complete(self, case: Case) -> Case:
        """See `Drives`."""
        return rigid.complete_case(case)

    def given(self, case: Case) -> Given:
        """See `Drives`."""
        (first, *others), drawn = rigid.record_case(case)
        machine = replace(drawn.machine, tolerances=drawn.tolerances)
        return Given(first, machine, tuple(others))


def draw_cases(
    drives: Drives,
    count: int,
    seed: int,
    choice: Choice | None = None,
    *,
    workers: int = 1,
    progress: Callable[[float], None] | None = None,
) -> list[Case]:
    """Draw a study in `workers` processes; the same for the same drives, count, seed and choice.

    progress: called with the share done, 0 to 1.
    """
    plan = drives.plan(count, seed, choice or Choice())
    done: dict[int, Case] = {}
    for case in in_processes(drives.complete, plan, workers):
        done[case.index] = case
        if progress is not None:
            progress(len(done) / len(plan))
    return [done[case.index] for case in plan]
