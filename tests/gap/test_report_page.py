"""The report: what it says for each verdict, and that the file stands on its own."""

from __future__ import annotations

import dataclasses
import re
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from report_samples import backlash, coulomb, diagnosis, of_each_verdict

from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnosis import Candidate
from ecyl_ros.gap.report import residual, stretch
from ecyl_ros.gap.report.page import report_html, write_report
from ecyl_ros.gap.report.style import CSS
from ecyl_ros.gap.report.verdict import sentence

VERDICTS = of_each_verdict()
VOID = {"meta", "br"}


class Reader(HTMLParser):
    """Checks that tags close in the order they open; keeps text, attributes and pictures."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Remember."""
        self.seen.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Remember."""
        self.seen.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        """Compare."""
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        """Remember."""
        self.text.append(data)


def read(page: str) -> Reader:
    """The page taken apart."""
    reader = Reader()
    reader.feed(page)
    reader.close()
    assert not reader.open
    return reader


def test_one_plain_sentence_says_what_came_out() -> None:
    """The verdict reads as a drive engineer would say it."""
    assert sentence(VERDICTS["explained"]) == (
        "The gap is explained by Coulomb friction on the rotor: 0.3802 N m (0.3790 to 0.3814). "
        "Adding it removes all of the gap on held-out data; the residual is measurement noise. "
        "Confidence 0.97."
    )
    own = VERDICTS["explained"]
    half = own.floor + 0.5 * (own.before - own.floor)
    assert (
        "gap on held-out data (50.0 % by constants within the data sheet alone); the"
        in sentence(dataclasses.replace(own, within_sheet=half))
    )
    partly = dataclasses.replace(
        VERDICTS["partly_explained"], misfit_after=2.0, misfit_best=2.0, misfit_perfect=1.0
    )
    assert sentence(partly).startswith(
        "The gap is partly explained by Coulomb friction on the rotor of 0.3802 N m (0.3790 to "
        "0.3814) and a wrong backlash of 9.652 mrad (9.640 to 9.660). Adding them removes 77.8 %"
        " of the gap on held-out data; structure that nothing in the catalogue explains remains"
    )
    closed = dataclasses.replace(partly, misfit_after=1.0, misfit_perfect=1.0)
    assert "what remains is about what a perfect model would leave, most clearly" in sentence(
        closed
    )
    unsure = dataclasses.replace(partly, misfit_best=1.0)
    assert "what remains is explained by effects that are too unsure to be named" in sentence(
        unsure
    )
    assert sentence(VERDICTS["no_gap"]).startswith(
        "There is no gap to explain: the nominal model already reaches the measurement noise."
    )
    said = sentence(VERDICTS["unexplained"])
    assert said.startswith("The gap is not explained by anything in the catalogue.")
    assert "74 % of the gap lies at reversals, 20 % of the time" in said
    assert "Effects in the rotor come closest" in said
    assert said.endswith("but not surely enough to be named.")
    far = dataclasses.replace(
        VERDICTS["unexplained"], candidates=(Candidate(("local_jam",), 3, 3),)
    )
    assert sentence(far).endswith("too much to be named.")


def test_a_signal_that_is_left_above_its_noise_is_told() -> None:
    """Noise in all signals together hides none that is left at three times its own; where a perfect
    model leaves no less, as with noise that goes round the loop, that is said."""
    some = dataclasses.replace(VERDICTS["explained"], misfit_after=1.5, misfit_perfect=1.0)
    first, *others = some.signals
    first = dataclasses.replace(first, after=3.0 * first.floor)
    left = dataclasses.replace(some, signals=(first, *others))
    assert "noise but for the rotor velocity, at 3.00 times its own. Confidence" in sentence(left)
    as_sound = sentence(dataclasses.replace(left, misfit_after=1.1))
    assert "perfect model would leave it, with the rotor velocity at 3.00 times its" in as_sound
    near = sentence(dataclasses.replace(left, verdict="within_sheet", causes=()))
    assert "The rotor velocity is left at 3.00 times its noise by few and large differ" in near
    assert "is left at" not in sentence(dataclasses.replace(some, verdict="within_sheet"))


def test_a_sheet_that_removes_nothing_is_not_praised_for_it() -> None:
    """Within the sheet with every constant as it was: how near the floor is, not a share of 0."""
    some = VERDICTS["unexplained"]
    within = dataclasses.replace(some, verdict="within_sheet", shrink=0.0, after=1.75 * some.floor)
    assert "no more than 1.75 times the measurement noise" in sentence(within)
    assert "0.0 %" not in sentence(within)


def test_the_verdict_admits_what_cannot_be_told_apart() -> None:
    """Alternatives stand in the verdict itself, not further down alone."""
    said = sentence(diagnosis("explained", (coulomb(0.6, ("stribeck_friction",)),)))
    assert said.endswith("This recording cannot tell it from Stribeck friction on the rotor.")
    assert "Confidence 0.60" in said


def test_a_set_is_no_surer_than_its_least_sure_cause() -> None:
    """Of several causes the verdict gives the lowest confidence."""
    assert "Confidence 0.91." in sentence(diagnosis("explained", (coulomb(), backlash())))


@pytest.mark.parametrize("verdict", list(VERDICTS))
def test_the_page_is_whole_and_needs_nothing_else(verdict: str) -> None:
    """Each verdict makes well-formed HTML without a link to anywhere, below 2 MB."""
    page = report_html(VERDICTS[verdict])
    reader = read(page)
    assert len(page.encode()) < 2_000_000
    assert not re.search(r"https?://|src=|href=|url\(|@import|<script", page)
    assert "nan" not in re.findall(r' (?:d|x|y|width|height)="[^"]*nan', page)
    assert "None" not in "".join(reader.text)


@pytest.mark.parametrize("verdict", list(VERDICTS))
def test_every_picture_is_valid_and_has_a_text(verdict: str) -> None:
    """Pictures are valid XML, and those that are not decoration say what they show."""
    page = report_html(VERDICTS[verdict])
    charts = re.findall(r'<svg class="chart".*?</svg>(?=</?fig)', page)
    assert len(charts) >= 4
    for chart in charts:
        assert ElementTree.fromstring(chart).get("aria-label")


@pytest.mark.parametrize("verdict", list(VERDICTS))
def test_the_page_goes_from_verdict_to_smallprint(verdict: str) -> None:
    """Sections come in the order a reader needs them, and only those with something to say."""
    headings = re.findall(r"<h2>(.*?)</h2>", report_html(VERDICTS[verdict]))
    causes = {"explained": ["Cause"], "partly_explained": ["Causes"]}.get(verdict, [])
    gap = verdict != "no_gap"
    assert headings == [
        "How the gap closes" if causes else "How large the gap is",
        "Recorded against simulated",
        *causes,
        "Where the gap lies" if gap else "Signal by signal",
        *(["Other candidates"] if gap else []),
        *(["Notes"] if VERDICTS[verdict].notes else []),
        "How this was made",
    ]


def test_what_comes_from_files_cannot_become_markup() -> None:
    """Names and notes from files are escaped wherever they stand."""
    evil = '<script>alert("1")</script>&amp;'
    one = diagnosis("unexplained", source=f"a/{evil}", drive=evil, notes=(evil,))
    ports = (dataclasses.replace(one.ports[0], block=evil, what=evil),)
    when = (dataclasses.replace(one.when[0], condition=evil),)
    signals = (dataclasses.replace(one.signals[0], name=evil, unit=evil), *one.signals[1:])
    page = report_html(dataclasses.replace(one, ports=ports, when=when, signals=signals))
    assert "<script" not in page
    tags = {tag for tag, _ in read(page).seen}
    assert "script" not in tags


def _contrast(one: str, other: str) -> float:
    def luminance(colour: str) -> float:
        parts = [int(colour[place : place + 2], 16) / 255.0 for place in (1, 3, 5)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_text_and_curves_stand_out_in_light_and_dark() -> None:
    """Contrast to the paper is at least 4.5 for text and 3 for curves (WCAG 2.1, AA)."""
    themes = [dict(re.findall(r"--(\w+): (#\w{6})", part)) for part in CSS.split("@media")[:2]]
    assert len(themes) == 2
    for theme in themes:
        for name, least in (
            ("ink", 4.5),
            ("quiet", 4.5),
            ("recorded", 3.0),
            ("before", 3.0),
            ("after", 3.0),
        ):
            assert _contrast(theme[name], theme["paper"]) >= least, name


def test_the_stretch_shown_is_the_worst_that_was_held_out() -> None:
    """Of the held-out stretches the one with the largest gap is shown, and no other."""
    one = VERDICTS["explained"]
    chosen = stretch.worst(one)
    assert chosen is not None
    time = one.series.time_s[chosen.rows]
    assert time[0] == pytest.approx(3.5) and time[-1] == pytest.approx(3.999)
    assert one.series.held_out[chosen.rows].all()


def test_signals_shown_are_those_that_show_the_gap() -> None:
    """Signals at their noise are left out where others are not."""
    one = VERDICTS["explained"]
    quiet = one.series.before.copy()
    quiet[1] = one.series.recorded[1]
    series = dataclasses.replace(one.series, before=quiet)
    chosen = stretch.worst(dataclasses.replace(one, series=series))
    assert chosen is not None
    shown = stretch.telling_signals(dataclasses.replace(one, series=series), chosen)
    assert sorted(shown) == [0, 2]


def test_the_spectrum_of_white_noise_lies_on_the_floor() -> None:
    """Noise of standard deviation s has the density s sqrt(2 / rate), where the floor is drawn."""
    random = np.random.default_rng(3)
    time = np.arange(40_000) / 1000.0
    rate, frequency, height = residual.amplitude_density(time, random.normal(0.0, 0.02, 40_000))
    assert rate == pytest.approx(1000.0)
    assert np.sqrt(np.mean(height[3:-3] ** 2)) == pytest.approx(
        0.02 * np.sqrt(2.0 / rate), rel=0.05
    )
    assert frequency[-1] == pytest.approx(500.0)


def test_a_poor_recording_still_makes_a_page() -> None:
    """Unknown samples, a simulation that ran away and stretches not usable do no harm."""
    one = VERDICTS["unexplained"]
    recorded, before = one.series.recorded.copy(), one.series.before.copy()
    recorded[:, 1000:2500] = np.nan
    recorded[2] = np.nan
    before[0, 3000:] = np.inf
    before[1, 3500:] = 1e300
    usable = one.series.usable.copy()
    usable[:400] = False
    series = dataclasses.replace(
        one.series, recorded=recorded, before=before, after=before, usable=usable
    )
    page = report_html(dataclasses.replace(one, series=series))
    read(page)
    assert not re.search(r'(?:d|y|height)="[^"]*(?:nan|inf)', page)
    nothing = dataclasses.replace(series, held_out=np.zeros_like(usable))
    assert "Recorded against" not in report_html(dataclasses.replace(one, series=nothing))


def test_a_page_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    """A folder in the page's place is an error that names it, and leaves nothing behind."""
    write_report(VERDICTS["explained"], tmp_path / "new" / "page.html")
    assert (tmp_path / "new" / "page.html").read_text(encoding="utf-8").endswith("</html>\n")
    (tmp_path / "taken").mkdir()
    with pytest.raises(InputError, match="taken"):
        write_report(VERDICTS["explained"], tmp_path / "taken")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["new", "taken"]
