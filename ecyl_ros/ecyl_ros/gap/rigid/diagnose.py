"""A rigid drive judged by the effort that its measured motion needs: from a recording on."""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection

import numpy as np

from ...drive.rigid.machine import Machine
from ...errors import InputError
from ...recording.signals import Recording
from ..describe.rigid import with_rigid_description
from ..diagnosis import Diagnosis
from .assemble import assembled
from .balance import Balance
from .compete import compete, concluded
from .contest import Contest
from .floor import repeatability, white_part
from .held import gains_off, off_sheet, said_of, unbelieved
from .judge import Judgement
from .lag import MOVED, in_bounds, lag_left, sampling_lag
from .lower import rigid_band
from .motion import Motion, motion_of
from .noise import blur_of, measurement_noise, weighed
from .null import Null
from .offsets import without_offsets
from .one_factor import of_one_factor, said_of_one_factor
from .own_band import looked_at_again
from .rest import moving
from .simplest import simplest
from .solution import Solution
from .terms import Catalogue

_FINER = 0.8  # a floor below this share of the last one has the effects compete again
_REFUTED = 0.5  # of the floor: what leaves less on unseen rows shows that it is no floor
_DIGITS = 1e-6  # of the effort: what logs resolve, whatever was measured
_ROUNDS = 3  # of competitions, each with the floor and the lag that the last one found
_SIMPLER = 2  # times that a set may be made simpler
_TOO_LITTLE = 12  # compared samples per second of use: fewer stretches say nothing


def diagnose_rigid(
    recording: Recording,
    machine: Machine,
    *,
    without: Collection[str],
    mode: float | None,
    source: str,
    drive_name: str,
    tell: Callable[[float], None],
) -> Diagnosis:
    """See `diagnose.diagnose`; tell: called now and then with the share done.

    Raises:
        InputError: no position, no effort, no motion, no such mode.
    """
    motion = motion_of(recording, machine, source, mode)
    check_motion(motion, machine, source)
    judgement = judged(motion, machine, without, source, tell)
    found = assembled(judgement, mode, [recording], source, drive_name, without)
    again = functools.partial(
        diagnose_rigid,
        recording,
        without=without,
        mode=mode,
        source=source,
        drive_name=drive_name,
        tell=lambda share: tell(0.9 + 0.1 * share),
    )
    found = looked_at_again(found, motion, machine, again)
    return with_rigid_description(found, judgement, without)


def judged(
    motion: Motion,
    machine: Machine,
    without: Collection[str],
    source: str,
    tell: Callable[[float], None],
    differing: Collection[str] = (),
    known: tuple[float, str] | None = None,
) -> Judgement:
    """What competed for the effort that a motion needs, and how it came out.

    differing: effects that are found for each recording by itself, where the motion is of several.
    known: a floor to begin with, and what it is; by how the effort repeats unless given.

    Raises:
        InputError: too few samples to compare.
    """
    tell(0.05)
    catalogue = Catalogue(motion, machine, differing)
    motion = without_offsets(motion, catalogue.along)
    motion = weighed(motion, inertia_of(catalogue))

    def competed(held: Collection[str] = ()) -> Judgement:
        return _competed(motion, machine, without, source, tell, differing, known, held)

    judgement = competed()
    held, off, said = set[str](), list[str](), list[str]()
    lower = rigid_band(judgement)
    if lower is not None:
        motion = lower
        said.append(
            f"frequencies above {lower.weight_hz:.3g} Hz have less weight: lower bands give "
            "another inertia, as if parts are not rigid, or the position's noise is not white; "
            f"judge.bandwidth: {lower.weight_hz:.2g} in the drive file leaves them out"
        )
        judgement = competed()
    while more := unbelieved(judgement) - held:
        off += off_sheet(judgement, more)
        held |= more
        gains = gains_off(judgement)
        judgement = competed(held)
        if instead := gains_off(judgement) - gains:
            held |= instead
            judgement = competed(held)
    if same := of_one_factor(judgement):
        said.append(said_of_one_factor(same))
        judgement = competed({*held, *same})
    judgement.notes += said
    if off:
        judgement.notes.append(said_of(judgement, off))
    return judgement


def _competed(
    motion: Motion,
    machine: Machine,
    without: Collection[str],
    source: str,
    tell: Callable[[float], None],
    differing: Collection[str],
    known: tuple[float, str] | None,
    held: Collection[str],
) -> Judgement:
    """The same in the band of a motion; held: effects that stand for constants which keep to their
    tolerance, and do not compete."""
    without = {*without, *held}
    catalogue = Catalogue(motion, machine, differing)
    inertia = inertia_of(catalogue)
    blur = blur_of(motion, machine, inertia)
    model = catalogue.model
    balance = Balance(motion, catalogue.nominal(), model, blur)
    lag_s = sampling_lag(motion, catalogue.along, balance.fitted)
    balance = Balance(motion, catalogue.nominal(), model, blur, lag_s)
    if int(balance.usable.sum()) < 8 * _TOO_LITTLE:
        remedy = "fewer gaps, or a higher judge.bandwidth where noise of the position allows it"
        if motion.refreshed_s:
            remedy = f"or an effort that is new more often than every {motion.refreshed_s:.3g} s"
        raise InputError(
            f"{source}: {int(balance.usable.sum())} samples can be compared at a bandwidth of "
            f"{motion.bandwidth_hz:.3g} Hz, expected at least {8 * _TOO_LITTLE}: more seconds, "
            f"{remedy}"
        )
    floor, floor_is = known or _floor(balance, catalogue, _broad(balance, catalogue))
    floor = min(floor, float(np.std(balance.effort[balance.usable])) or floor)
    null = Null(balance, catalogue, held)
    for number in range(_ROUNDS):
        contest = compete(null, floor, without, _part(tell, number))
        finer, finer_is = _finer_floor(balance, catalogue, contest)
        more = lag_left(contest.winner, lag_s)
        moved, lower = abs(more) > MOVED / motion.rate_hz, finer < _FINER * floor
        if lower or finer > floor:
            floor, floor_is = finer, finer_is
        if not (moved or lower) or number == _ROUNDS - 1:
            break
        if moved:  # what shakes the machine bends a lag that is sought without it
            lag_s = in_bounds(motion, lag_s + more)
            balance = Balance(motion, catalogue.nominal(), model, blur, lag_s)
            null = Null(balance, catalogue, held)
    judgement = Judgement(null, contest, floor, floor_is)
    for _ in range(_SIMPLER):
        simpler = simplest(judgement)
        if simpler is None:
            break
        contest = concluded(null, floor, without, contest, simpler)
        judgement = Judgement(null, contest, floor, floor_is)
    return judgement


def _part(tell: Callable[[float], None], number: int) -> Callable[[float], None]:
    """Tells the share done of one competition out of some."""
    return lambda share: tell(0.1 + (number + share) * 0.8 / _ROUNDS)


def _resolved(balance: Balance) -> float:
    """RMS below which no log tells efforts from each other."""
    return _DIGITS * float(np.sqrt(np.mean(balance.effort[balance.usable] ** 2)))


def _finer_floor(balance: Balance, catalogue: Catalogue, contest: Contest) -> tuple[float, str]:
    """The floor once a set has won.

    What depends on time, or varies fast over the position, does not repeat until then.
    """
    winner = contest.winner
    finer, finer_is = _floor(balance, catalogue, winner)
    # A fit that leaves far less than the floor on rows it never saw refutes the floor.
    judged = balance.judged if balance.judged.any() else balance.usable
    rows = moving(judged, balance.motion, catalogue.along)
    looped = catalogue.machine.actuation == "loop"  # a delay cancels noise that went round it
    least = winner.inertia(catalogue.model) * balance.blur.noise if looped else 0.0
    least = max(least, _resolved(balance))
    left = max(winner.rms(rows), least)
    if left < _REFUTED * finer:
        # Then by the one that leaves least, whether it has won or not: no set is its own floor.
        rivals = (one.rms(rows) for one in (*contest.rivals, *contest.singles))
        finer = max(min([left, *rivals]), least)
        finer_is = "what the closest model leaves"
    white = min(white_part(balance, winner), left)
    if white > finer:
        finer, finer_is = white, "white noise"
    return finer, finer_is


def inertia_of(catalogue: Catalogue) -> float:
    """About what it is, in the unit of the effort: by the file, or by the motion."""
    if catalogue.model.inertia is not None:
        return catalogue.model.inertia
    plain = Balance(catalogue.motion, catalogue.nominal(), catalogue.model)
    return _broad(plain, catalogue).inertia(catalogue.model)


def check_motion(
    motion: Motion, machine: Machine, source: str, *, changes: bool | None = None
) -> None:
    """Raise InputError where a motion cannot be judged: no effort, no motion, another unit.

    changes: whether the effort does, in this recording unless another beside it may.
    """
    if not np.isfinite(motion.effort).any():
        wanted = machine.actuation or ("force" if machine.linear else "torque")
        raise InputError(
            f"{source}: no effort ({wanted}) recorded; expected one to compare the motion with, or "
            "a drive file of kind follower, which takes reference and position alone"
        )
    unit = machine.effects_unit
    if unit is not None and unit != motion.effort_unit:
        raise InputError(
            f"{source}: effort comes in {motion.effort_unit}, the effects of the drive file are "
            f"counted in {unit}; expected the same actuation.signal and actuation.gain"
        )
    moved = motion.velocity[motion.usable]
    if moved.size == 0 or not np.ptp(motion.position[motion.usable]) > 20.0 * motion.position_noise:
        raise InputError(
            f"{source}: the output does not move by more than 20 times its noise of "
            f"{motion.position_noise:.3g} {'m' if machine.linear else 'rad'}; expected motion"
        )
    if not (effort_changes(motion) if changes is None else changes):
        raise InputError(
            f"{source}: the effort never changes; expected one that does, for a constant may not "
            "be what drives the motion (beside recordings with another effort it is compared)"
        )


def effort_changes(motion: Motion) -> bool:
    """Whether the effort of a recording is another at times."""
    return bool(np.ptp(motion.effort[motion.usable]) > 0.0)


def _broad(balance: Balance, catalogue: Catalogue) -> Solution:
    """A fit that takes most of the smooth dependence on the motion away."""
    return balance.fit([*catalogue.unknown(), *catalogue.smooth()])


def _floor(balance: Balance, catalogue: Catalogue, fit: Solution) -> tuple[float, str]:
    """Standard deviation of what does not repeat once `fit` is taken away, and what it is."""
    turns = not catalogue.machine.linear and catalogue.along.turns
    repeats = repeatability(balance, fit, turns)
    noise = measurement_noise(catalogue, fit)
    if repeats is None or repeats <= noise:
        return max(noise, _resolved(balance)), "measurement noise"
    return repeats, "what the same motion does not repeat"
