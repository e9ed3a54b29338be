"""The verdict in plain sentences."""

from __future__ import annotations

import math
from dataclasses import replace

from ...effects.catalogue import RIGID
from ..compete.strain import SOUND
from ..diagnosis import Cause, ConditionShare, Diagnosis, FittedParameter, SheetValue, SignalGap
from ..judge.verdict import EXPLAINED_SHRINK, NO_GAP_RATIO, STRUCTURELESS, shrink_of
from ..listed import listed
from . import law as law_words
from . import quantities as q
from . import together, words

_NOISE_NAME = "measurement noise"
_NOISE = 1.2  # what is left is called measurement noise up to this multiple of the floor
_BUT_FOR = 2.0  # ... but for a signal that is left further above its own
_TELLING = 1.5  # a condition is worth a word if it holds so many times its share of the time
_MUCH = 0.3  # ... and this share of the gap
_BY_SHEET = 0.1  # share of the gap that the sheet's constants remove, from which it is told
_MORE = 1.1  # times what all that was found leaves: then it is told what that removes


def sentence(diagnosis: Diagnosis) -> str:
    """What came out, in one to four sentences of plain text; what spoils it all goes first."""
    said = " ".join(one for one in (_said(diagnosis), together.sentences(diagnosis)) if one)
    return f"Check first: {diagnosis.caution}. {said}" if diagnosis.caution else said


def _said(diagnosis: Diagnosis) -> str:
    if diagnosis.verdict == "no_gap":
        return _no_gap(diagnosis)
    if diagnosis.verdict == "within_sheet":
        return _within_sheet(diagnosis)
    if diagnosis.verdict == "not_judgeable":
        who = "These recordings" if diagnosis.recordings else "This recording"
        return f"{who} cannot be judged: {diagnosis.reason}."
    if diagnosis.law is not None:
        return law_words.sentence(diagnosis, diagnosis.law)
    if diagnosis.verdict == "unexplained" or not diagnosis.causes:
        return _unexplained(diagnosis)
    if diagnosis.verdict == "explained":
        return _explained(diagnosis)
    return _partly(diagnosis)


def strongest(
    diagnosis: Diagnosis, after: bool = False, judged: bool | None = None
) -> SignalGap | None:
    """The signal whose gap stands highest over its floor; before unless `after`.

    judged: of those that the verdict rests on, or of the others; None: of all.
    """

    def over(one: SignalGap) -> float:
        return (one.after if after else one.gap) / one.floor

    known = [one for one in diagnosis.signals if one.floor > 0.0 and judged in (None, one.judged)]
    return max((one for one in known if math.isfinite(over(one))), key=over, default=None)


def telling_condition(diagnosis: Diagnosis) -> ConditionShare | None:
    """The condition that holds far more of the gap than of the time; None where none does."""
    fit = [
        one
        for one in diagnosis.when
        if one.share >= _MUCH and one.share >= _TELLING * max(one.time_share, 1e-9)
    ]
    return max(fit, key=lambda one: one.share - one.time_share, default=None)


def when_in_words(when: ConditionShare) -> str:
    """A condition with its share of the time, unless its name is that."""
    text = words.condition(when.condition)
    if when.condition == "time":
        return text
    return f"{text}, {q.whole_percent(when.time_share)} of the time"


def _over_floor(diagnosis: Diagnosis, value: float) -> str:
    return q.times(value, diagnosis.floor)


def _floor(diagnosis: Diagnosis, adjective: str = "measurement ") -> str:
    """What a signal's floor is called."""
    return f"its {adjective}noise" if diagnosis.floor_is == _NOISE_NAME else diagnosis.floor_is


def _the_floor(diagnosis: Diagnosis) -> str:
    """What the floor of all signals together is called."""
    return "the measurement noise" if diagnosis.floor_is == _NOISE_NAME else diagnosis.floor_is


def _no_gap(diagnosis: Diagnosis) -> str:
    worst, built_up = (strongest(diagnosis, judged=one) for one in (True, False))
    text = f"There is no gap to explain: the nominal model already reaches {_the_floor(diagnosis)}"
    if worst is None:
        return f"{text}."
    times = f"{q.times(worst.gap, worst.floor)} times {_floor(diagnosis, '')}"
    name, share = words.signal(worst.name), _share_of_effort(diagnosis)
    if share and worst.gap > NO_GAP_RATIO * worst.floor:
        text = (
            f"There is no gap to explain: the nominal model leaves {share} of the {name}, as "
            f"little as a model of one inertia can, at {times}."
        )
    else:
        text = f"{text}. The signal furthest from it, the {name}, is at {times}."
    if built_up is None or built_up.gap <= NO_GAP_RATIO * built_up.floor:
        return text
    return (
        f"{text} In the replay the remaining error builds up: the "
        f"{words.signal(built_up.name)} reaches {q.times(built_up.gap, built_up.floor)} times "
        "its own floor."
    )


def _within_sheet(diagnosis: Diagnosis) -> str:
    share = q.percent(diagnosis.shrink)
    if share == q.percent(0.0):
        return (
            "No cause is needed: the nominal model already leaves no more than "
            f"{_over_floor(diagnosis, diagnosis.after)} times {_the_floor(diagnosis)}, with too "
            "little structure for a cause."
        )
    text = (
        "No cause is needed: the gap is within the tolerances of the data sheet. With its "
        f"constants as found, {'all' if share == '100 %' else share} of the gap is gone on "
        "held-out data."
    )
    most = _furthest(diagnosis)
    if most is not None:
        text += (
            f" The {words.constant(most.parameter)} is furthest from its nominal value, by "
            f"{abs(most.pull):.1f} of its tolerance"
        )
        text += ", which a sound machine's may be (up to two)." if abs(most.pull) > 1.0 else "."
    worst = strongest(diagnosis, after=True, judged=True)
    if worst is not None and worst.after > _BUT_FOR * worst.floor:
        # As near as noise for most of the time, or it would not be within the sheet.
        text += (
            f" The {words.signal(worst.name)} is left at {q.times(worst.after, worst.floor)} times "
            "its noise by few and large differences, such as impacts that come early or late."
        )
    return text


def _furthest(diagnosis: Diagnosis) -> SheetValue | None:
    """The stated constant that lies furthest off its sheet, of those that the recording shows."""
    seen = [one for one in diagnosis.sheet if one.seen and one.stated]
    return max(seen, key=lambda one: abs(one.pull), default=None)


def _off_sheet(diagnosis: Diagnosis) -> str:
    """The constant that is at fault, or stands for what is; empty where all may be sound."""
    most = _furthest(diagnosis)
    if most is None or abs(most.pull) <= SOUND:
        return ""
    return (
        f" The {words.constant(most.parameter)} fits best {abs(most.pull):.1f} tolerances "
        f"{'above' if most.pull > 0.0 else 'below'} its nominal value: it is wrong, or what is not "
        "explained bends it."
    )


def _lessened(one: Cause) -> FittedParameter | None:
    """By how much a friction is below what the sheet has, where it is told as what comes on top."""
    form = RIGID.get(one.effect)
    below = form is not None and form.on_top and one.effect.endswith("friction")
    first = one.parameters[0] if one.parameters else None
    if first is None or not below or len(one.parameters) > 1 or first.high >= 0.0:
        return None
    return replace(first, value=-first.value, low=-first.high, high=-first.low)


def _alone(one: Cause) -> str:
    name = words.with_article(one.effect)
    if not one.parameters:
        return name
    less = _lessened(one)
    if less is not None:
        return f"{name}, below the sheet's by {q.with_interval(less)}"
    if len(one.parameters) == 1:
        return f"{name}: {q.with_interval(one.parameters[0])}"
    parts = [f"{q.parameter_label(p.name)} {q.with_interval(p)}" for p in one.parameters]
    return f"{name}: {', '.join(parts)}"


def _among_others(one: Cause) -> str:
    name = words.with_article(one.effect)
    if not one.parameters:
        return name
    less = _lessened(one)
    if less is not None:
        return f"{name} (below the sheet's by {q.with_interval(less)})"
    if len(one.parameters) == 1:
        return f"{name} of {q.with_interval(one.parameters[0])}"
    parts = []
    for parameter in one.parameters:
        value, _, _, unit = q.interval(parameter)
        parts.append(f"{q.parameter_label(parameter.name)} {q.joined(value, unit)}")
    return f"{name} ({', '.join(parts)})"


def _named(diagnosis: Diagnosis) -> str:
    if len(diagnosis.causes) == 1:
        return _alone(diagnosis.causes[0])
    return listed([_among_others(one) for one in diagnosis.causes])


def _adding(diagnosis: Diagnosis) -> str:
    what = "it" if len(diagnosis.causes) == 1 else "them"
    share = q.percent(diagnosis.shrink)
    text = (
        f"Adding {what} removes {'all' if share == '100 %' else share} of the gap on held-out data"
    )
    before, best = diagnosis.misfit_before, diagnosis.misfit_best
    if before > diagnosis.misfit_after > _MORE * best > 0.0:
        whole = shrink_of(before, best, before - diagnosis.misfit_perfect)
        text += f", {q.percent(whole)} with what is too unsure to be named"
    surplus = diagnosis.before - diagnosis.floor
    if diagnosis.within_sheet is not None and surplus > 0.0:
        alone = shrink_of(diagnosis.before, diagnosis.within_sheet, surplus)
        if alone >= _BY_SHEET:
            text += f" ({q.percent(alone)} by constants within the data sheet alone)"
    return text


def _doubts(diagnosis: Diagnosis) -> str:
    text = ""
    several = len(diagnosis.causes) > 1
    for one in diagnosis.causes:
        if one.alternatives:
            others = listed([words.with_article(name) for name in one.alternatives], "or")
            what = f"the {words.title(one.effect)}" if several else "it"
            who = "These recordings" if diagnosis.recordings else "This recording"
            text += f" {who} cannot tell {what} from {others}."
    return text


def _sureness(diagnosis: Diagnosis) -> str:
    return f" Confidence {q.confidence(min(one.confidence for one in diagnosis.causes))}."


def _explained(diagnosis: Diagnosis) -> str:
    return (
        f"The gap is explained by {_named(diagnosis)}. {_adding(diagnosis)}; {_left(diagnosis)}."
        f"{_sureness(diagnosis)}{_doubts(diagnosis)}"
    )


def _left(diagnosis: Diagnosis) -> str:
    """What the residual is, of all signals together and where one stands out."""
    if diagnosis.after > _NOISE * diagnosis.floor:
        return (
            f"the residual is {_over_floor(diagnosis, diagnosis.after)} times "
            f"{'the ' if diagnosis.floor_is == _NOISE_NAME else ''}{diagnosis.floor_is}"
        )
    left = f"the residual is {diagnosis.floor_is}"
    worst = strongest(diagnosis, after=True)
    if worst is None or worst.after <= _BUT_FOR * worst.floor:
        return left
    which = f"the {words.signal(worst.name)}"
    high = f"at {q.times(worst.after, worst.floor)} times its own"
    # Noise that goes round the loop, or blows that differ by chance, move a sound machine as well.
    if worst.judged and diagnosis.misfit_after <= _NOISE * diagnosis.misfit_perfect:
        return f"{left}, as a perfect model would leave it, with {which} {high}"
    return f"{left} but for {which}, {high}"


def _partly(diagnosis: Diagnosis) -> str:
    worst = strongest(diagnosis, after=True)
    where = ""
    if worst is not None:
        where = (
            f", most clearly in the {words.signal(worst.name)} "
            f"({q.times(worst.after, worst.floor)} times {_floor(diagnosis, '')})"
        )
    what = "structure that nothing in the catalogue explains remains"
    if 0.0 < diagnosis.misfit_after <= _NOISE * diagnosis.misfit_perfect:
        what = "what remains is about what a perfect model would leave"
    elif 0.0 < diagnosis.misfit_best <= _NOISE * diagnosis.misfit_perfect:
        what = "what remains is explained by effects that are too unsure to be named"
    return (
        f"The gap is partly explained by {_named(diagnosis)}. {_adding(diagnosis)}; {what}{where}."
        f"{_sureness(diagnosis)}{_doubts(diagnosis)}"
    )


def _of_effort(diagnosis: Diagnosis) -> str:
    """How much of a rigid drive's effort its model leaves; empty of other drives."""
    share = _share_of_effort(diagnosis)
    if not share:
        return ""
    effort = words.signal(diagnosis.signals[0].name)
    return f" With its constants as the sheet allows, {share} of the {effort} is left."


def _share_of_effort(diagnosis: Diagnosis) -> str:
    """The same in percent."""
    effort = diagnosis.signals[0].name if diagnosis.signals else ""
    left = [one for one in diagnosis.measured if one.name == f"relative_{effort}_error"]
    return q.percent(left[0].value) if left else ""


def _unexplained(diagnosis: Diagnosis) -> str:
    worst = strongest(diagnosis)
    text = "The gap is not explained by anything in the catalogue."
    if worst is not None:
        text += (
            f" It shows most clearly in the {words.signal(worst.name)}, at "
            f"{q.times(worst.gap, worst.floor)} times {_floor(diagnosis)}"
        )
        when = telling_condition(diagnosis)
        if when is not None:
            text += f"; {q.whole_percent(when.share)} of the gap lies {when_in_words(when)}"
        text += "."
    text += _of_effort(diagnosis) + _off_sheet(diagnosis)
    if diagnosis.block is not None:
        text += f" Effects in {words.block(diagnosis.block)} come closest."
    alone = min(
        (one.judged for one in diagnosis.candidates if not one.effects),
        default=diagnosis.misfit_before,
    )
    whole = diagnosis.misfit_before - diagnosis.misfit_perfect
    if diagnosis.misfit_before - alone >= _BY_SHEET * whole > 0.0:
        text += (
            " Other values of the data sheet's constants alone lower the misfit from "
            f"{q.number(diagnosis.misfit_before)} to {q.number(alone)} noise floors."
        )
    best = next((one for one in diagnosis.candidates if one.effects), None)
    if best is not None:
        closest = listed([words.with_article(one) for one in best.effects])
        near = best.judged <= STRUCTURELESS * diagnosis.misfit_perfect
        near = near or alone - best.judged >= EXPLAINED_SHRINK * (alone - diagnosis.misfit_perfect)
        why = "but not surely enough to be named" if near else "too much to be named"
        text += (
            f" The closest candidate is {closest}: it leaves a misfit of {q.number(best.judged)} "
            f"noise floors ({q.number(alone)} without it), {why}."
        )
    return text
