"""The summary for the terminal."""

from __future__ import annotations

import dataclasses

import pytest
from report_samples import coulomb, diagnosis, of_each_verdict

from ecyl_ros.api.notebook import html
from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.gap.diagnosis import (
    Candidate,
    FittedParameter,
    Measured,
    SheetValue,
    SignalGap,
)
from ecyl_ros.gap.report.page import report_html
from ecyl_ros.gap.report.rivals import runner_up
from ecyl_ros.gap.report.terminal import summary
from ecyl_ros.gap.report.verdict import sentence

VERDICTS = of_each_verdict()


@pytest.mark.parametrize("verdict", list(VERDICTS))
def test_the_summary_fits_a_screen_and_a_pipe(verdict: str) -> None:
    """At most 25 lines of at most 100 plain ASCII characters, the verdict first."""
    text = summary(VERDICTS[verdict], ["out.json", "out.html", "out.yaml"])
    lines = text.splitlines()
    assert len(lines) <= 25
    assert max(map(len, lines)) <= 100
    assert text.isascii() and "\x1b" not in text
    assert " ".join(text.split("\n\n")[0].split()) == sentence(VERDICTS[verdict])
    assert lines[-1].split() == ["written", "out.yaml"]


@pytest.mark.parametrize(("found", "told"), [(0.75, True), (0.85, False)])
def test_a_constant_far_off_its_sheet_is_told_where_nothing_is_named(found, told) -> None:
    """2.5 tolerances below its nominal value no sound machine is; 1.5 one may be."""
    inertia = SheetValue("load.inertia", "kg m^2", 1.0, 0.1, found, found, found, seen=True)
    said = sentence(dataclasses.replace(VERDICTS["unexplained"], sheet=(inertia,)))
    words = "The load inertia fits best 2.5 tolerances below its nominal value: it is wrong, or"
    assert (words in said) is told
    assert ("tolerances" in said) is told


def test_constants_beside_an_unexplained_gap_are_no_measurement() -> None:
    """Below the table of the sheet, in the terminal and on the page; not where a cause is named."""
    inertia = SheetValue("load.inertia", "kg m^2", 1.0, 0.1, 0.95, 0.94, 0.96, seen=True)
    for name, said in (("unexplained", True), ("explained", False)):
        one = dataclasses.replace(VERDICTS[name], sheet=(inertia,))
        assert ("may have moved these values" in summary(one)) is said
        assert ("may have moved these values" in report_html(one)) is said


def test_causes_come_with_interval_and_confidence() -> None:
    """The table gives value, interval, confidence and what each cause removes."""
    text = summary(VERDICTS["partly_explained"])
    row = next(line for line in text.splitlines() if line.startswith("wrong backlash"))
    words = " ".join(row.split())
    assert words == "wrong backlash backlash 9.652 mrad 9.640 to 9.660 0.91 29.0 %"


def test_without_a_cause_there_is_no_column_after() -> None:
    """Where nothing was added, nothing is said of afterwards."""
    assert "after" not in summary(VERDICTS["unexplained"])
    assert "next best" not in summary(VERDICTS["unexplained"])


def test_less_friction_than_the_sheet_has_is_told_by_how_much() -> None:
    """A friction of -2.57 N m on top of the sheet's is one below it, in the sentence."""
    less = FittedParameter("coulomb_nm", "N m", -2.57, -2.73, -2.42)
    cause = dataclasses.replace(coulomb(), parameters=(less,))
    text = sentence(dataclasses.replace(VERDICTS["explained"], causes=(cause,)))
    assert "Coulomb friction on the rotor, below the sheet's by 2.57 N m (2.42 to 2.73)" in text


def test_a_model_of_one_inertia_may_leave_its_part() -> None:
    """Above the floor and without a gap: the sentence says how much of the effort is left."""
    torque = SignalGap("torque", "N m", 17.6e-3, 17.6e-3, 11.1e-3)
    share = Measured("relative_torque_error", "1", 0.005, 0.005, 0.005, "")
    rigid = dataclasses.replace(VERDICTS["no_gap"], signals=(torque,), measured=(share,))
    assert "the nominal model leaves 0.5 % of the torque" in sentence(rigid)
    near = dataclasses.replace(torque, gap=11.5e-3)
    text = sentence(dataclasses.replace(rigid, signals=(near,)))
    assert "already reaches" in text and "0.5 %" not in text


def test_the_runner_up_is_a_rival() -> None:
    """A set that holds what is named, or a finer form of it, is no runner-up."""
    finer = [name for name, one in CATALOGUE.items() if "rotor_coulomb_friction" in one.refines]
    assert "stribeck_friction" in finer
    ranks = [(finer[0],), ("rotor_coulomb_friction", "torque_ripple"), ("torque_ripple",)]
    sets = tuple(Candidate(names, 1.0 + n, 1.0 + n) for n, names in enumerate(ranks))
    best = runner_up(dataclasses.replace(VERDICTS["explained"], candidates=sets))
    assert best is not None and best.effects == ("torque_ripple",)
    assert runner_up(VERDICTS["unexplained"]) is None


def test_many_notes_do_not_push_the_verdict_off_the_screen() -> None:
    """Beyond five notes the summary, and a notebook, say how many more there are."""
    one = diagnosis("unexplained", notes=tuple(f"note {n}" for n in range(9)))
    text = summary(one)
    assert "note 4" in text and "note 5" not in text
    assert "4 more in the report" in text
    page = html(one)
    assert "note 4" in page and "note 5" not in page and "more in the notes" in page


def test_control_characters_of_files_do_not_reach_the_terminal() -> None:
    """Escape sequences in notes and paths are shown as question marks."""
    one = dataclasses.replace(VERDICTS["unexplained"], notes=("\x1b[31mred",))
    assert "\x1b" not in summary(one, ["\x1b]0;title\x07"])
