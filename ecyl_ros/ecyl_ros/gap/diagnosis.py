"""What a diagnosis says: the data behind terminal summary, JSON and report."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ..arrays import BoolArray, FloatArray
from ..drive.rigid.machine import Machine
from .describe.description import Description
from .limits.limit import Alike, Limit
from .several.of_recording import OfRecording, Unseen

VERDICTS = (
    "no_gap",
    "within_sheet",
    "explained",
    "partly_explained",
    "described",
    "unexplained",
    "not_judgeable",
)


@dataclass(frozen=True)
class SignalGap:
    """RMS of recorded less simulated on held-out stretches, in the signal's unit; NaN where the
    replay ran away.

    judged: whether the verdict rests on it; what a rigid drive's replay builds up is only shown.
    """

    name: str
    unit: str
    gap: float
    after: float
    floor: float
    judged: bool = True

    def as_json(self) -> dict[str, Any]:
        """Plain data; None for NaN."""
        return {
            key: None if isinstance(value, float) and math.isnan(value) else value
            for key, value in asdict(self).items()
        }


@dataclass(frozen=True)
class ConditionShare:
    """Share of the gap's energy that falls under a condition, and the share of time it holds."""

    condition: str
    share: float
    time_share: float


@dataclass(frozen=True)
class PortCheck:
    """A block judged with measured signals at its ports: what its own equation leaves.

    ratio: RMS of what is left over what noise alone leaves; 1 where the block is as modelled.
    typical: the RMS that the median of what is left suggests, which seldom and large differences
    (impacts of the flanks) do not lift; the RMS itself unless given.
    """

    block: str
    what: str
    unit: str
    rms: float
    floor: float
    typical: float | None = None

    @property
    def ratio(self) -> float:
        """RMS over floor."""
        return self.rms / self.floor if self.floor > 0.0 else 0.0

    @property
    def typical_ratio(self) -> float:
        """`typical` over floor."""
        if self.typical is None:
            return self.ratio
        return self.typical / self.floor if self.floor > 0.0 else 0.0


@dataclass(frozen=True)
class FittedParameter:
    """A parameter of a cause in SI units."""

    name: str
    unit: str
    value: float
    low: float
    high: float
    at_bound: bool = False


@dataclass(frozen=True)
class Cause:
    """An effect that earned its place.

    confidence: probability that it is a true cause, calibrated by the sealed study.
    shrink: share of the whole gap that adding it removed, in the order the causes are listed.
    shrink_alone_lost: share that comes back when it alone is left out of the set.
    alternatives: effects that this recording cannot tell from it.
    excitation: what a recording would need to tell them apart.
    """

    effect: str
    block: str
    title: str
    confidence: float
    parameters: tuple[FittedParameter, ...]
    shrink: float
    shrink_alone_lost: float
    alternatives: tuple[str, ...] = ()
    excitation: str = ""


@dataclass(frozen=True)
class SheetValue:
    """A constant of the data sheet as the recording shows it, in its unit.

    tolerance: half width that holds 95 % of healthy machines. value, low, high: found, with its
    95 % interval. seen: whether the recording says more of it than the sheet does. stated: whether
    the drive file states it; what it leaves out may have any value, and no pull.
    """

    parameter: str
    unit: str
    nominal: float
    tolerance: float
    value: float
    low: float
    high: float
    seen: bool
    stated: bool = True

    @property
    def pull(self) -> float:
        """How far it is off its nominal value, in tolerances: 1 at the edge of the sheet."""
        return (self.value - self.nominal) / self.tolerance

    @property
    def told(self) -> bool:
        """Whether its value tells something: of the machine, or that the model went beyond the
        sheet for it."""
        return self.seen or (self.stated and abs(self.pull) > 1.0)


@dataclass(frozen=True)
class Candidate:
    """A set of effects that competed: misfit over the noise floor, fitted and held out."""

    effects: tuple[str, ...]
    fitted: float
    judged: float


@dataclass(frozen=True, eq=False)
class Series:
    """Time series for pictures, at the recording's samples.

    time_s: float64[n]. reference_m: float64[n]. recorded, before, after: float64[signals, n] in
    the order of `Diagnosis.signals`. held_out: bool[n]. usable: bool[n]. start_ns: stamp of the
    first sample. position, speed: float64[n] with their units, of a drive that is not judged by
    rotor and rod.
    """

    time_s: FloatArray
    reference_m: FloatArray
    recorded: FloatArray
    before: FloatArray
    after: FloatArray
    held_out: BoolArray
    usable: BoolArray
    start_ns: int = 0
    position: FloatArray | None = None
    position_unit: str = "m"
    speed: FloatArray | None = None
    speed_unit: str = "m/s"


@dataclass(frozen=True)
class StretchGap:
    """The gap on one stretch of a long recording.

    begin_s, end_s: from the beginning of the recording. before, after: robust misfit of the nominal
    model, and with the causes added, over that of a perfect model; 1 is noise. gap: whether the
    nominal model is off its floor there, by more than chance and by no less than a tenth of where
    it is most. judged: whether the diagnosis is of this stretch.
    """

    begin_s: float
    end_s: float
    before: float
    after: float
    gap: bool
    judged: bool


@dataclass(frozen=True)
class Measured:
    """A value of the machine that the recording gives, whether or not it is a cause.

    low, high: 95 % interval; equal to the value where none is known. nominal: what the drive file
    says; None where it says nothing.
    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    meaning: str
    nominal: float | None = None


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The result of `diagnose`; see the module and `docs/diagnosis.md`.

    Attributes:
        source: what was diagnosed (a path). drive: the nominal model (a path or name).
        verdict: one of `VERDICTS`. block: where the gap lies; None without a gap.
        signals, when, frequency_hz, ports: where the gap lies, by signal, condition, frequency and
            block.
        causes: in the order they earn their place.
        before, after, floor, shrink: pooled over the signals, on held-out stretches, each signal
            over the standard deviation of its recorded signal. `steps` holds the pooled gap after
            each cause was added, in order (waterfall).
        candidates: what competed, best first.
        notes: what the diagnosis rests on and could not judge or tell, one line each.
        sheet: the constants that the data sheet leaves open, as they were found beside the causes.
            within_sheet: the pooled gap with these alone, without causes.
        values: {effect: {parameter: value}} of the causes, shape parameters included, as a drive
            file takes them.
        seconds, replays: what it took.
        misfit_before, misfit_after, misfit_perfect, misfit_best: robust RMS over the noise floor of
            the nominal model, with the causes, of a perfect model, and of the best set, named or
            not. margin: the best rival's over the best set's.
        measured: values of the machine that the recording gives (drives judged by effort or by
            how they follow).
        floor_is: what the floor stands for.
        stretches: of a long recording, those that were looked at, by time.
        law: of `described`, the cause that the library lacks.
        caution: what has to be put right before anything else holds (a signal of the wrong
            sign, or scale).
        reason: of `not_judgeable`, what recording would do.
        limits: the smallest size of each effect, beside what was found, that the recording would
            have shown; alike: pairs of effects that it hardly tells apart.
        recordings: what is said of each, where several were diagnosed together. unseen: the last of
            them against what the others alone say.
        closest: of a rigid drive, the machine that comes closest to the recording, values fitted to
            all of it. judged: the one that the gap after is of, fitted without what is held out.
    """

    source: str
    drive: str
    verdict: str
    block: str | None
    signals: tuple[SignalGap, ...]
    when: tuple[ConditionShare, ...]
    frequency_hz: tuple[float, ...]
    ports: tuple[PortCheck, ...]
    causes: tuple[Cause, ...]
    before: float
    after: float
    floor: float
    shrink: float
    steps: tuple[float, ...]
    candidates: tuple[Candidate, ...]
    notes: tuple[str, ...]
    values: dict[str, dict[str, float]]
    series: Series
    seconds: float = 0.0
    replays: int = 0
    misfit_before: float = 0.0
    misfit_after: float = 0.0
    misfit_perfect: float = 0.92
    misfit_best: float = 0.0
    margin: float = 1.0
    duration_s: float = 0.0
    rate_hz: float = 0.0
    measured: tuple[Measured, ...] = ()
    floor_is: str = "measurement noise"
    stretches: tuple[StretchGap, ...] = ()
    sheet: tuple[SheetValue, ...] = ()
    within_sheet: float | None = None
    law: Description | None = None
    caution: str = ""
    reason: str = ""
    limits: tuple[Limit, ...] = ()
    alike: tuple[Alike, ...] = ()
    recordings: tuple[OfRecording, ...] = ()
    unseen: Unseen | None = None
    closest: Machine | None = None
    judged: Machine | None = None

    @property
    def name(self) -> str:
        """Of what was diagnosed, without the folders that it lies in."""
        names = [one.name for one in self.recordings] or [Path(self.source).name]
        return ", ".join(names)

    @property
    def added(self) -> str:
        """What was added to the nominal model beyond its constants; empty for nothing."""
        if self.law is not None:
            return "law"
        return {0: "", 1: "cause"}.get(len(self.causes), "causes")

    @property
    def closes(self) -> bool:
        """Whether anything that was found, causes, constants or a law, closes the gap."""
        return bool(self.causes) or self.verdict == "within_sheet" or self.law is not None

    @property
    def has_twin(self) -> bool:
        """Whether a drive file can hold what closes the gap: not a second law of a rigid drive."""
        return self.closes and not (
            self.law is not None and self.law.in_balance and self.closest is None
        )

    def as_json(self) -> dict[str, Any]:
        """The diagnosis as plain data, schema `ecyl.diagnosis/1`."""
        return {
            "schema": "ecyl.diagnosis/1",
            "recording": self.source,
            "drive": self.drive,
            "verdict": self.verdict,
            "reason": self.reason,
            "location": {
                "block": self.block,
                "signals": [one.as_json() for one in self.signals],
                "when": [asdict(one) for one in self.when],
                "frequency_hz": list(self.frequency_hz),
                "ports": [
                    {key: getattr(one, key) for key in ("block", "what", "unit", "rms", "floor")}
                    for one in self.ports
                ],
            },
            "causes": [
                {
                    "effect": one.effect,
                    "confidence": one.confidence,
                    "parameters": {
                        p.name: {"value": p.value, "ci95": [p.low, p.high], "at_bound": p.at_bound}
                        for p in one.parameters
                    },
                    "shrink": one.shrink,
                    "alternatives": list(one.alternatives),
                }
                for one in self.causes
            ],
            "law": None if self.law is None else self.law.as_json(),
            "gap": {
                "before": self.before,
                "sheet": self.before if self.within_sheet is None else self.within_sheet,
                "after": self.after,
                "floor": self.floor,
                "shrink": self.shrink,
                "held_out": True,
            },
            "sheet": [
                {
                    "parameter": one.parameter,
                    "unit": one.unit,
                    "nominal": one.nominal,
                    "tolerance": one.tolerance,
                    "value": one.value,
                    "ci95": [one.low, one.high],
                    "pull": one.pull,
                    "seen": one.seen,
                }
                for one in self.sheet
            ],
            "limits": [one.as_json() for one in self.limits],
            "alike": [one.as_json() for one in self.alike],
            "misfit": {
                "before": self.misfit_before,
                "after": self.misfit_after,
                "perfect": self.misfit_perfect,
                "best": self.misfit_best,
                "margin": self.margin,
            },
            "candidates": [
                {"effects": list(one.effects), "fitted": one.fitted, "held_out": one.judged}
                for one in self.candidates
            ],
            "measured": [
                {
                    "name": one.name,
                    "unit": one.unit,
                    "value": one.value,
                    "ci95": [one.low, one.high],
                    "nominal": one.nominal,
                    "meaning": one.meaning,
                }
                for one in self.measured
            ],
            "floor_is": self.floor_is,
            "stretches": [
                {
                    "from_s": one.begin_s,
                    "to_s": one.end_s,
                    "before": one.before,
                    "after": one.after,
                    "gap": one.gap,
                    "judged": one.judged,
                }
                for one in self.stretches
            ],
            "caution": self.caution,
            "notes": list(self.notes),
            "seconds": self.seconds,
            **self._of_several(),
        }

    def _of_several(self) -> dict[str, Any]:
        """What there is to say of several recordings alone."""
        if not self.recordings:
            return {}
        return {
            "recordings": [one.as_json() for one in self.recordings],
            "unseen": None if self.unseen is None else self.unseen.as_json(),
        }
