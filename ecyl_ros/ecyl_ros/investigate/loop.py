"""The loop: play, diagnose, ask what is open, plan the motion that tells, and play again."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from ..api.diagnosing import diagnose
from ..api.result import DiagnosisResult
from ..drive.parameters import DriveParameters
from ..drive.reference.planned import Planned
from ..errors import InputError
from ..gap.report import quantities as q
from ..nodes.realtime import FEW_MISSED
from ..plan.healthy import Healthy
from ..plan.make import BUDGET_S, Plan, make_plan
from ..recording.atomic import write_text
from .bounds import Bounds, bounds_for
from .page import write_page
from .played import Played, missed
from .question import HEALTHY, Question, question
from .story import DECIDED, ENDED, OPEN, Step, Story
from .survey import survey

LONGEST_S = 60.0  # of a motion: what was not decided by one is asked again by one twice as long
_AGAIN = 2  # times that a motion is played once more, where the drive missed many ticks in it
FIRST = "nothing is known of this machine yet: a little of everything"


@dataclass(frozen=True)
class Settings:
    """What an investigation may take.

    Attributes:
        motions: at the most. minutes: after which no other motion is begun.
        duration_s: of a motion. error_m, current_a: bounds instead of those from the model.
        plan_s: that a plan may take.
    """

    motions: int = 4
    minutes: float = 60.0
    duration_s: float = 8.0
    error_m: float | None = None
    current_a: float | None = None
    plan_s: float = BUDGET_S


class Investigation:
    """One machine, from what is known of it to an answer; `run` does all of it."""

    def __init__(
        self,
        drive: DriveParameters,
        drive_file: Path,
        machine: str,
        out: Path,
        settings: Settings,
        play: Callable[[Planned, Bounds, Path], Played],
        tell: Callable[[str], None],
        progress: Callable[[str], Callable[[float], None]],
    ) -> None:
        """
        Args:
            drive: the nominal model, with the limits that motions keep. drive_file: it was read
                from. machine: what is moved, in words. out: folder, which is made.
            play: plays a motion within bounds on the machine and records it to a file.
            tell: takes a line for the user. progress: begins a piece of work, and gives what takes
                its share done.
        """
        self._drive, self._drive_file, self._out = drive, drive_file, out
        self._settings, self._play = settings, play
        self._tell, self._progress = tell, progress
        self._asked: list[frozenset[object]] = []
        self._recordings: list[Path] = []
        self._duration_s = settings.duration_s
        self.story = Story(str(drive_file), machine)

    def run(self, asked: Question | None = None) -> Story:
        """Until everything open is decided, the budget is spent, or the drive had to be stopped.

        asked: what is open already; without it the first motion asks for nothing in particular.

        Raises:
            InputError: before the first motion: limits that leave none, a drive that is not there.
        """
        begun = time.monotonic()
        while True:
            number = len(self.story.steps) + 1
            try:
                motion, healthy, plan = self._motion(asked)
                bounds = bounds_for(
                    self._drive, healthy, self._settings.error_m, self._settings.current_a
                )
                self._announce(number, asked, motion, plan)
                step = self._played(number, asked, motion, plan, bounds)
            except InputError as error:
                if number == 1:
                    raise
                return self._close(OPEN, f"no further motion: {error}")
            if step.played.ended is not None:
                self._keep(step)
                return self._close(ENDED, self._why_ended(step))
            try:
                step = self._diagnosed(step)
            except InputError as error:
                if number == 1:
                    raise
                self._keep(step)
                return self._close(OPEN, f"the recordings cannot be judged together: {error}")
            self._keep(step)
            said = self._answer(step)
            if said is not None:
                return self._close(*said)
            asked = step.left
            if number >= self._settings.motions:
                return self._close(OPEN, f"the budget of motions, {number}, is spent")
            if time.monotonic() - begun > 60.0 * self._settings.minutes:
                return self._close(
                    OPEN, f"the budget of {self._settings.minutes:g} minutes is spent"
                )

    def interrupted(self) -> Story:
        """The story of an investigation that was stopped while nothing moved."""
        return self._close(ENDED, "stopped by Ctrl-C while the drive was at rest")

    def _motion(self, asked: Question | None) -> tuple[Planned, Healthy, Plan | None]:
        if asked is None:
            return *survey(self._drive, self._duration_s), None
        if asked.asked in self._asked:
            self._duration_s = min(2.0 * self._duration_s, LONGEST_S)
        self._asked.append(asked.asked)
        plan = make_plan(
            self._drive,
            self._duration_s,
            asked.pairs,
            asked.alone,
            asked.known,
            asked.signals,
            [],
            budget_s=self._settings.plan_s,
            tell=self._progress("planning"),
        )
        healthy = Healthy.on(self._drive, plan.motion, plan.motion.duration_s)
        excess = healthy.excess(self._drive)
        if excess is not None:
            raise InputError(
                f"limits: on the planned motion the healthy drive takes {excess}; expected lower "
                "limits.speed or limits.acceleration"
            )
        return plan.motion, healthy, plan

    def _announce(
        self, number: int, asked: Question | None, motion: Planned, plan: Plan | None
    ) -> None:
        self._tell(f"motion {number}, {motion.duration_s:g} s: {asked.why if asked else FIRST}")
        if plan is not None and plan.pairs:
            first, *others = plan.predictions
            usual = max(others, key=lambda one: min(one.apart))
            self._tell(
                f"  predicted to separate them by {min(first.apart):.2f} noise floors "
                f"({usual.motion}: {min(usual.apart):.2f}); a diagnosis needs {plan.needed:.2f}"
            )

    def _played(
        self,
        number: int,
        asked: Question | None,
        motion: Planned,
        plan: Plan | None,
        bounds: Bounds,
    ) -> Step:
        made = not self._out.exists()
        file = self._out / f"motion_{number}.yaml"
        write_text(file, motion.as_file({"drive": self._drive_file.name}))
        try:
            played = self._in_time(motion, bounds, file.with_suffix(".mcap"))
        except BaseException:
            file.unlink(missing_ok=True)
            if made:
                with suppress(OSError):  # a recording is in it
                    self._out.rmdir()
            raise
        self._tell(
            f"  recorded {played.samples} samples: tracking error up to "
            f"{q.amount(played.error_m, 'm')} (bound {q.amount(bounds.error_m, 'm')}), current up "
            f"to {q.amount(played.current_a, 'A')} (bound {q.amount(bounds.current_a, 'A')})"
        )
        if played.missed_ticks:
            self._tell(f"  {missed(played)}")
        why = asked.why if asked else FIRST
        return Step(number, why, motion.duration_s, file, played, bounds, plan)

    def _in_time(self, motion: Planned, bounds: Bounds, file: Path) -> Played:
        """What came of a motion, played once more where the computer was too late too often."""
        played = self._play(motion, bounds, file)
        for late in range(1, _AGAIN + 1):
            recording, ticks = played.recording, played.samples * self._drive.telemetry_every
            few = (played.missed_ticks or 0) <= FEW_MISSED * ticks
            if played.ended is not None or recording is None or few:
                break
            self._tell(f"  {missed(played)}: once more")
            kept = file.with_stem(f"{file.stem}_late_{late}")
            os.replace(recording, kept)
            try:
                played = self._play(motion, bounds, file)
            except InputError as error:
                self._tell(f"  not played again: {error}")
                os.replace(kept, recording)
                break
        return played

    def _diagnosed(self, step: Step) -> Step:
        assert step.played.recording is not None  # of a motion played to its end
        self._recordings.append(step.played.recording)
        found = judged(self._recordings, self._drive_file, self._progress("diagnosing"))
        found.write_json(self._out / f"{step.stem}.json")
        found.write_report(self._out / f"{step.stem}.html")
        left = question(found.to_dict())
        self._tell(f"  {found.sentence}")
        return replace(step, diagnosis=found, sentence=found.sentence, left=left)

    def _answer(self, step: Step) -> tuple[str, str] | None:
        """(outcome, why) where there is nothing further to ask."""
        left = step.left
        if left is None:
            return DECIDED, "the last diagnosis leaves nothing open"
        if left.asked not in self._asked:
            return None
        if left.alone and step.diagnosis is not None and step.diagnosis.verdict in HEALTHY:
            return DECIDED, "no motion shows what the motion planned for it does not show"
        if self._duration_s >= LONGEST_S:
            return OPEN, f"a motion of {LONGEST_S:g} s planned for it has not decided: {left.why}"
        return None

    def _why_ended(self, step: Step) -> str:
        rest = "the drive is at rest" if step.played.at_rest else "it was not seen to come to rest"
        return f"{step.played.ended}; {rest}"

    def _keep(self, step: Step) -> None:
        self.story = self.story.and_then(step)
        self._write()

    def _close(self, outcome: str, said: str) -> Story:
        self.story = self.story.closed(outcome, said)
        if self.story.steps:
            self._write()
        return self.story

    def _write(self) -> None:
        text = json.dumps(self.story.as_json(), indent=2) + "\n"
        write_text(self._out / "investigation.json", text)
        write_page(self.story, self._out / "index.html")


def judged(
    recordings: Sequence[Path], drive_file: Path, tell: Callable[[float], None]
) -> DiagnosisResult:
    """The diagnosis of one machine's recordings, oldest first: of all together."""
    every = recordings[0] if len(recordings) == 1 else list(recordings)
    return diagnose(every, drive_file, progress=tell)
