"""The report: one HTML file that needs nothing else, most important things first."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ... import __version__
from ...effects.catalogue import CATALOGUE
from ...recording.atomic import write_text
from ..diagnosis import Cause, Diagnosis, FittedParameter
from ..listed import listed
from . import law, limits, pulls, residual, stretch, together, words
from . import quantities as q
from .markup import escape, figure, key, table, typeset
from .rivals import contains
from .style import CSS
from .verdict import sentence, strongest
from .waterfall import waterfall

_LOUD = 2.0  # a block or signal this many times over its floor is set bold


def write_report(diagnosis: Diagnosis, path: str | Path) -> None:
    """Write `report_html`, whole or not at all; InputError where that cannot be."""
    write_text(path, report_html(diagnosis))


def report_html(diagnosis: Diagnosis) -> str:
    """The page as text."""
    body = [
        _head(diagnosis),
        _closing(diagnosis),
        "" if diagnosis.recordings else _stretch(diagnosis),
        _causes(diagnosis),
        _law(diagnosis),
        _sheet(diagnosis),
        _section("The recordings", *together.parts(diagnosis, _keys(diagnosis, recorded=True))),
        _limits(diagnosis),
        _measured(diagnosis),
        _where(diagnosis),
        _stretches(diagnosis),
        _runners_up(diagnosis),
        _notes(diagnosis),
        _smallprint(diagnosis),
    ]
    name = escape(diagnosis.name)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Diagnosis of {name}</title>\n<style>{CSS}</style>\n</head>\n<body>\n"
        + "\n".join(part for part in body if part)
        + "\n</body>\n</html>\n"
    )


def _head(diagnosis: Diagnosis) -> str:
    source, drive = escape(diagnosis.name), escape(Path(diagnosis.drive).name)
    return (
        f"<header><h1>{words.verdict(diagnosis.verdict)}</h1>"
        f'<p class="verdict">{typeset(sentence(diagnosis))}</p>'
        f'<p class="quiet from">{source} against {drive}, '
        f"{q.number(diagnosis.duration_s)} s at {q.number(diagnosis.rate_hz)} Hz</p></header>"
    )


def _section(heading: str, *parts: str) -> str:
    content = "".join(parts)
    return f"<section><h2>{heading}</h2>{content}</section>" if content else ""


def _closing(diagnosis: Diagnosis) -> str:
    caption = (
        "RMS of the residual (recorded minus simulated) on held-out data, pooled over the signals, "
        f"each over the standard deviation of what was recorded. Dashed: {diagnosis.floor_is}."
    )
    facts = []
    if diagnosis.closes:
        facts += [("removed", f"{q.percent(diagnosis.shrink)} of what exceeds the floor")]
    misfit = q.number(diagnosis.misfit_before)
    if diagnosis.closes:
        misfit += f" before, {q.number(diagnosis.misfit_after)} after"
    facts += [
        ("misfit", f"{misfit}: the same in noise floors, robust against single spikes"),
        ("a perfect model", f"has a misfit of about {q.number(diagnosis.misfit_perfect, 2)}"),
    ]
    items = "".join(f"<dt>{typeset(name)}</dt><dd>{typeset(text)}</dd>" for name, text in facts)
    heading = "How the gap closes" if diagnosis.closes else "How large the gap is"
    picture = figure(waterfall(diagnosis), caption)
    return _section(heading, f'<div class="pair">{picture}<dl>{items}</dl></div>')


def _keys(diagnosis: Diagnosis, *, recorded: bool) -> str:
    kinds = [("recorded", "recorded")] if recorded else []
    kinds.append(("before", "nominal model"))
    if diagnosis.causes:
        added = "cause" if len(diagnosis.causes) == 1 else "causes"
        kinds.append(("after", f"with the {added} added"))
    elif diagnosis.law is not None:
        kinds.append(("after", "with the law"))
    elif diagnosis.closes:
        kinds.append(("after", "with the constants found"))
    if not recorded:
        kinds.append(("floor", diagnosis.floor_is))
    return key(*kinds)


def _stretch(diagnosis: Diagnosis) -> str:
    chosen = stretch.worst(diagnosis)
    if chosen is None:
        return ""
    time = diagnosis.series.time_s
    what = "The held-out stretch with the largest gap"
    span = f"{time[chosen.start]:.2f} s to {time[chosen.stop - 1]:.2f} s"
    return _section(
        "Recorded against simulated",
        f"<p>{what}, {typeset(span)}. No parameter was fitted to it.</p>",
        _keys(diagnosis, recorded=True),
        stretch.figures(diagnosis, chosen),
    )


def _causes(diagnosis: Diagnosis) -> str:
    return _section(
        "Causes" if len(diagnosis.causes) != 1 else "Cause",
        *(_cause(one, len(diagnosis.causes) > 1) for one in diagnosis.causes),
    )


def _cause(one: Cause, several: bool) -> str:
    rows = [_parameter(one.effect, parameter) for parameter in one.parameters]
    head = [("parameter", ""), ("value", "num"), ("95 % interval", "num"), ("in SI", "num")]
    if not any(row[-1] for row in rows):
        head, rows = head[:-1], [row[:-1] for row in rows]
    parts = [f"<h3>{typeset(words.heading(one.effect))}</h3>"]
    effect = CATALOGUE.get(one.effect)
    if effect is not None:
        parts.append(f"<p>{typeset(effect.summary)}</p>")
    if rows:
        parts.append(table("", head, rows))
    facts = [
        ("confidence", q.confidence(one.confidence)),
        ("acts in", words.block(one.block)),
        ("removes", f"{q.percent(one.shrink)} of the gap"),
    ]
    if several:
        back = f"without it {q.percent(one.shrink_alone_lost)} of the gap comes back"
        facts.append(("ablation", back))
    if one.alternatives:
        others = listed([words.title(name) for name in one.alternatives], "or")
        facts.append(("could also be", others))
        facts.append(("to tell them apart", one.excitation or "another recording"))
    else:
        facts.append(("could also be", "nothing else in the catalogue fits as well"))
    items = "".join(f"<dt>{typeset(name)}</dt><dd>{typeset(text)}</dd>" for name, text in facts)
    name = f"<dt>in drive files</dt><dd>{escape(one.effect)}</dd>"
    return f"<article>{''.join(parts)}<dl>{items}{name}</dl></article>"


def _law(diagnosis: Diagnosis) -> str:
    """The law that describes the gap: its curve, what it was read from, its course over time."""
    found = diagnosis.law
    if found is None:
        return ""
    items = "".join(f"<dt>{typeset(n)}</dt><dd>{typeset(t)}</dd>" for n, t in law.facts(found))
    pictures = "".join(law.pictures(found))
    return _section("The law", f"<dl>{items}</dl>", f'<div class="pair">{pictures}</div>')


def _parameter(effect: str, one: FittedParameter) -> list[str]:
    value, low, high, unit = q.interval(one)
    known = CATALOGUE.get(effect)
    meaning = {p.name: p.meaning for p in known.parameters} if known else {}
    label = q.parameter_label(one.name)
    if one.name in meaning:
        label += f" ({meaning[one.name]})"
    si = q.joined(q.number(one.value, 5), one.unit) if unit != one.unit else ""
    note = " at the bound of the fit" if one.at_bound else ""
    return [
        typeset(label),
        f"<b>{typeset(q.joined(value, unit))}</b>",
        typeset(f"{q.ends(low, high)}{note}"),
        typeset(si),
    ]


def _measured(diagnosis: Diagnosis) -> str:
    if not diagnosis.measured:
        return ""
    head = [("quantity", ""), ("value", "num"), ("95 % interval", "num"), ("nominal", "num")]
    rows = []
    for one in diagnosis.measured:
        cells = [typeset(text) for text in q.measured(one)]
        label = q.parameter_label(one.name)
        meaning = f' <span class="quiet">{typeset(one.meaning)}</span>' if one.meaning else ""
        rows.append([f"{typeset(label[:1].upper() + label[1:])}{meaning}", *cells])
    caption = (
        "Values fitted to the whole recording, nominal value and correction together. What the "
        "drive file leaves out has no nominal value."
    )
    return _section("The machine as measured", table(caption, head, rows))


def _sheet(diagnosis: Diagnosis) -> str:
    if not diagnosis.sheet:
        return ""
    head = [("constant", ""), ("nominal", "num"), ("found", "num"), ("95 % interval", "num")]
    head += [("pull", "num"), ("", "share")]
    rows = []
    for one in diagnosis.sheet:
        *cells, pull = q.sheet_value(one)
        label = words.constant(one.parameter)
        rows.append(
            [
                f'{typeset(label[:1].upper() + label[1:])} <span class="quiet">'
                f"{escape(one.parameter)}</span>",
                *(typeset(cell).replace("+-", "±") for cell in cells),
                f"<b>{typeset(pull)}</b>" if one.told and abs(one.pull) > 1.0 else typeset(pull),
                pulls.bar(one),
            ]
        )
    caption = (
        "Every constant is fitted beside the causes, at a price for leaving its tolerance, the "
        "half width that holds 95 % of healthy machines. The pull is the distance from the nominal "
        "value in tolerances: 1 is the edge of the sheet. Not determined is a "
        "constant of which the recording says no more than the sheet."
    )
    warned = f"<p>{typeset(words.MOVED_BY_GAP)}</p>" if diagnosis.verdict == "unexplained" else ""
    return _section("The sheet", warned, table(caption, head, rows))


def _limits(diagnosis: Diagnosis) -> str:
    if not diagnosis.limits:
        return ""
    head = [("effect", ""), ("seen from", "num"), ("in SI", "num"), ("stated for", "")]
    first = limits.chosen(diagnosis)
    rows = []
    for one in [*first, *(one for one in diagnosis.limits if one not in first)]:
        seen = "" if one.smallest_seen is None else f"{one.smallest_seen:.3g}"
        label = typeset(words.heading(one.effect))
        rows.append(
            [
                f"<b>{label}</b>" if one in first else label,
                typeset(limits.size(one)),
                typeset(q.joined(seen, one.unit)) if seen else "",
                typeset(limits.at(one)),
            ]
        )
    caption = (
        "The smallest size of each effect, in addition to the causes found, that this recording "
        "would have shown on 95 of 100 machines within the sheet. Smaller ones could hide in it."
    )
    alike = "".join(f"<li>{typeset(one)}</li>" for one in limits.pairs(diagnosis))
    said = limits.sentence(diagnosis)
    return _section(
        "Detection limits",
        f"<p>{typeset(said)}</p>" if said else "",
        f"<ul>{alike}</ul>" if alike else "",
        table(caption, head, rows),
    )


def _where(diagnosis: Diagnosis) -> str:
    pictures = residual.figures(diagnosis)
    return _section(
        "Where the gap lies" if diagnosis.verdict != "no_gap" else "Signal by signal",
        _signals(diagnosis),
        _ports(diagnosis),
        _conditions(diagnosis),
        _frequencies(diagnosis),
        _residual_heading(diagnosis) + _keys(diagnosis, recorded=False) + pictures
        if pictures
        else "",
    )


def _stretches(diagnosis: Diagnosis) -> str:
    """The stretches of a long recording that were looked at."""
    if not diagnosis.stretches:
        return ""
    both = bool(diagnosis.causes)
    head = [("stretch", ""), ("misfit", "num")]
    head += [("after", "num")] if both else []
    head += [("", "")]
    rows = []
    for one in diagnosis.stretches:
        remark = "judged" if one.judged else "" if one.gap else "no gap"
        row = [typeset(f"{one.begin_s:.1f} s to {one.end_s:.1f} s"), q.number(one.before)]
        row += [q.number(one.after)] if both else []
        rows.append([*row, f"<b>{remark}</b>" if one.judged else remark])
    caption = (
        "Misfit of the nominal model over that of a perfect one: 1 is noise. The rest of this page "
        "is about the stretch that was judged."
    )
    return _section("Over the whole recording", table(caption, head, rows))


def _signals(diagnosis: Diagnosis) -> str:
    both = diagnosis.closes
    head = [("signal", ""), ("gap / floor", "num")]
    head += [("after / floor", "num")] if both else []
    head += [("gap", "num")]
    head += [("after", "num")] if both else []
    head += [("floor", "num"), ("unit", "")]
    rows = []
    for one in diagnosis.signals:
        values = [one.gap, one.after] if both else [one.gap]
        row = [typeset(words.signal(one.name))]
        row += [_ratio(value / one.floor if one.floor > 0.0 else np.nan) for value in values]
        figures = q.in_one_unit(values, one.floor, one.unit, words.RAN_AWAY)
        rows.append(row + [typeset(one) for one in figures])
    caption = (
        "By signal: RMS of the residual on held-out stretches; the floor is "
        f"{diagnosis.floor_is}{' alone' if diagnosis.floor_is == 'measurement noise' else ''}."
    )
    return table(caption, head, rows) if rows else ""


def _ratio(value: float) -> str:
    text = q.number(value)
    return f"<b>{text}</b>" if value >= _LOUD else text


def _ports(diagnosis: Diagnosis) -> str:
    head = [("block", ""), ("residual / floor", "num"), ("judged by", ""), ("residual", "num")]
    head += [("floor", "num"), ("unit", "")]
    rows = [
        [
            typeset(words.block(one.block)),
            _ratio(one.ratio),
            escape(one.what),
            *(typeset(figure) for figure in q.in_one_unit([one.rms], one.floor, one.unit)),
        ]
        for one in diagnosis.ports
    ]
    caption = (
        "By block: the residual of its own nominal equation with measured signals at its ports, so "
        "that the loop does not carry the fault of one block into another. About 1 where the "
        "block is as modelled."
    )
    return table(caption, head, rows) if rows else ""


def _conditions(diagnosis: Diagnosis) -> str:
    head = [("when", ""), ("of the gap", "num"), ("of the time", "num"), ("", "share")]
    rows = []
    for one in diagnosis.when:
        widths = [100.0 * min(max(share, 0.0), 1.0) for share in (one.share, one.time_share)]
        rows.append(
            [
                typeset(words.condition(one.condition)),
                typeset(q.whole_percent(one.share)),
                typeset(q.whole_percent(one.time_share)),
                f'<span class="part" style="width:{widths[0]:.1f}%"></span>'
                f'<span class="part time" style="width:{widths[1]:.1f}%"></span>',
            ]
        )
    caption = (
        "By condition: share of the gap's energy against share of the time. Conditions overlap."
    )
    return table(caption, head, rows) if rows else ""


def _frequencies(diagnosis: Diagnosis) -> str:
    if not diagnosis.frequency_hz:
        return ""
    lines = listed([f"{q.number(one)} Hz" for one in diagnosis.frequency_hz])
    return f"<p>Strongest lines of the gap's spectrum: {typeset(lines)}.</p>"


def _residual_heading(diagnosis: Diagnosis) -> str:
    about = strongest(diagnosis)
    assert about is not None  # there are pictures
    return (
        f"<h3>Residual of the {typeset(words.signal(about.name))}, recorded minus simulated</h3>"
        '<p class="caption">The signal with the largest ratio of gap to floor.</p>'
    )


def _runners_up(diagnosis: Diagnosis) -> str:
    if not diagnosis.candidates:
        return ""
    best = min(one.judged for one in diagnosis.candidates)
    head = [("set of effects", ""), ("fitted", "num"), ("held out", "num"), ("over best", "num")]
    rows = [
        [
            _candidate(diagnosis, one.effects),
            q.number(one.fitted),
            q.number(one.judged),
            f"× {q.number(one.judged / best)}" if best > 0.0 and np.isfinite(one.judged) else "-",
        ]
        for one in diagnosis.candidates
    ]
    caption = (
        "Misfit in noise floors, robust against single spikes, on fitted and on held-out "
        "stretches; best first"
        + ("; the named set in bold." if diagnosis.causes else "; none was named.")
    )
    return _section("Other candidates", table(caption, head, rows))


def _candidate(diagnosis: Diagnosis, effects: tuple[str, ...]) -> str:
    text = typeset(words.effect_set(effects))
    named = {one.effect for one in diagnosis.causes}
    if named and set(effects) == named:
        return f"<b>{text}</b>"
    return f"{text} (contains the named causes)" if contains(effects, named) else text


def _notes(diagnosis: Diagnosis) -> str:
    if not diagnosis.notes:
        return ""
    items = "".join(f"<li>{escape(one)}</li>" for one in diagnosis.notes)
    return _section("Notes", f"<ul>{items}</ul>")


def _smallprint(diagnosis: Diagnosis) -> str:
    facts = [
        ("recording", escape(diagnosis.source)),
        ("nominal model", escape(diagnosis.drive)),
        ("held out", typeset(_held_out(diagnosis))),
        ("effort", typeset(f"{diagnosis.replays} replays, {q.number(diagnosis.seconds)} s")),
        ("made by", f"ecyl {escape(__version__)}, schema ecyl.diagnosis/1"),
    ]
    items = "".join(f"<dt>{name}</dt><dd>{text}</dd>" for name, text in facts)
    return f"<footer><h2>How this was made</h2><dl>{items}</dl></footer>"


def _held_out(diagnosis: Diagnosis) -> str:
    series = diagnosis.series
    runs = stretch.stretches(series.held_out)
    if not runs:
        return "nothing"
    lengths = [float(series.time_s[one.stop - 1] - series.time_s[one.start]) for one in runs]
    share = float(np.mean(series.held_out))
    count = "1 stretch" if len(runs) == 1 else f"{len(runs)} stretches"
    return (
        f"{count} of {q.number(float(np.median(lengths)), 2)} s, spread over the recording, "
        f"{q.whole_percent(share)} of its samples; no parameter was fitted to them, and the "
        "gap and its shrink are measured there"
    )
