"""The study around a diagnosis: what it sees, what becomes of failures, how answers are scored."""

from __future__ import annotations

import dataclasses
import json
import math
import time

import numpy as np
import pytest

from ecyl_ros.cli.main import main
from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.errors import InputError
from ecyl_ros.gap.study import subject as subject_module
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.cylinder.baselines import best_swap, fit_all
from ecyl_ros.gap.study.cylinder.cases import complete_case, record_case
from ecyl_ros.gap.study.drives import BenchDrives
from ecyl_ros.gap.study.examine import Outcome, examine, run_study, time_limit
from ecyl_ros.gap.study.journal import Journal
from ecyl_ros.gap.study.score.figures import figures
from ecyl_ros.gap.study.score.parameters import parameter_errors, sheet_coverage
from ecyl_ros.gap.study.score.plots import write_plots
from ecyl_ros.gap.study.score.report import calibration, confusion, report
from ecyl_ros.gap.study.seal import seal

DRIVE = load_drive("bench")
DRIVES = BenchDrives(DRIVE)

SINGLE = Case(0, 1, "single", {"backlash_error": {"backlash_rad": 0.01}})
PAIR = Case(
    1,
    2,
    "pair",
    {"spring_load": {"stiffness_n_per_m": 5e4}, "resistance_error": {"resistance_ohm": 1.0}},
)
NONE = Case(2, 3, "none")
OUTSIDE = Case(3, 4, "outside", {"x_local_jam": {"coulomb_nm": 0.5}}, ("local_jam",))
WITHHELD = Case(4, 5, "withheld", {"lead_error": {"lead_m": 0.0201}}, ("lead_error",))
CASES = [SINGLE, PAIR, NONE, OUTSIDE, WITHHELD]
BLOCKS = {
    "backlash_error": "transmission",
    "spring_load": "load",
    "resistance_error": "motor_electrical",
    "x_local_jam": "load",
    "lead_error": "transmission",
}


def _said(effects, *, block=None, verdict="explained", confidence=0.95, shrink=0.99, factor=1.0):
    """A diagnosis that names effects with their parameters times `factor`."""
    return {
        "schema": "ecyl.diagnosis/1",
        "verdict": verdict,
        "location": {"block": block},
        "causes": [
            {
                "effect": name,
                "confidence": confidence,
                "parameters": {
                    key: {"value": factor * value, "ci95": [0.9 * value, 1.1 * value]}
                    for key, value in values.items()
                },
                "shrink": shrink,
                "alternatives": [],
            }
            for name, values in effects.items()
        ],
        "gap": {"before": 1.0, "after": 0.1, "floor": 0.1, "shrink": shrink, "held_out": True},
    }


def _perfect(case):
    if case.kind == "none":
        return _said({}, verdict="no_gap", shrink=0.0)
    block = BLOCKS[next(iter(case.effects))]
    if case.nameable:
        return _said(case.effects, block=block, factor=1.01)
    return _said({}, block=block, verdict="unexplained", shrink=0.0)


def _outcome(case, said, error=None):
    return Outcome(case.index, said, error, 2.0)


def _figures(pairs):
    return {figure.name: figure for figure in figures(pairs)}


def test_a_perfect_diagnosis_meets_every_figure() -> None:
    """Every figure that is wanted is met, and the error is the 1 % it was given."""
    found = _figures([(case, _outcome(case, _perfect(case))) for case in CASES])
    assert all(figure.met for figure in found.values() if figure.wanted is not None)
    assert found["parameter error, median"].value == pytest.approx(0.01)
    assert found["single: named first"].count == 1
    assert found["not in catalogue: no wrong cause"].count == 2


def test_a_diagnosis_that_always_names_one_cause_is_found_out() -> None:
    """Naming backlash everywhere is right once, a false alarm once, wrong twice, uncalibrated."""
    said = _said({"backlash_error": {"backlash_rad": 0.01}}, block="transmission")
    pairs = [(case, _outcome(case, said)) for case in CASES]
    found = _figures(pairs)
    assert found["single: named first"].right == 1
    assert found["pair: both named"].right == 0
    assert found["no gap: no false alarm"].right == 0
    assert found["not in catalogue: no wrong cause"].right == 0
    assert found["right of those at 0.9 or surer"].right == 1
    assert found["right of those at 0.9 or surer"].count == 5
    bins = [part for part in calibration(pairs) if part["count"]]
    assert len(bins) == 1
    assert bins[0]["right"] == pytest.approx(0.2)
    assert confusion(pairs) == {
        "backlash_error": {"backlash_error": 1},
        "x_local_jam": {"backlash_error": 1},
        "lead_error (withheld)": {"backlash_error": 1},
    }


def test_abstaining_is_never_wrong_and_never_right() -> None:
    """Saying `unexplained` throughout names no wrong cause, finds none, and alarms where no gap
    is."""
    pairs = [(case, _outcome(case, _said({}, verdict="unexplained"))) for case in CASES]
    found = _figures(pairs)
    assert found["not in catalogue: no wrong cause"].value == 1.0
    assert found["single: named first"].value == 0.0
    assert found["no gap: no false alarm"].value == 0.0


def test_saying_that_noise_hides_a_healthy_machine_is_no_alarm_and_no_judgement() -> None:
    """`not_judgeable` on a machine without a fault counts as not judged, and as an alarm only where
    a gap above the noise stands, whose causes look alike."""
    healthy = next(case for case in CASES if case.kind == "none")
    for before, quiet in ((0.1, 1), (0.5, 0)):  # the floor is 0.1
        said = _said({}, verdict="not_judgeable")
        said["gap"]["before"] = before
        found = _figures([(healthy, _outcome(healthy, said))])
        assert found["no gap: no false alarm"].right == quiet
        assert found["   and it was judged"].right == 0


def test_an_effect_beyond_the_contract_is_right_under_the_diagnosis_own_name() -> None:
    """A jam that the diagnosis may know is `local_jam`; any other name for it is wrong."""
    case = Case(0, 4, "beyond", OUTSIDE.effects)
    for name, right in (("local_jam", 1), ("load_coulomb_friction", 0)):
        found = _figures([(case, _outcome(case, _said({name: {"coulomb_nm": 0.5}})))])
        assert found["beyond the contract: named first"].right == right
        assert found["right of those at 0.9 or surer"].right == right


def test_half_a_pair_is_not_a_pair() -> None:
    """One of two named counts as neither; both with a third beside them as both, not as exact."""
    half = _said({"spring_load": PAIR.effects["spring_load"]})
    assert _figures([(PAIR, _outcome(PAIR, half))])["pair: both named"].right == 0
    more = _said({**PAIR.effects, "lead_error": {"lead_m": 0.02}})
    found = _figures([(PAIR, _outcome(PAIR, more))])
    assert found["pair: both named"].right == 1
    assert found["pair: both and no other"].right == 0


def test_a_failed_diagnosis_counts_as_wrong_everywhere() -> None:
    """No answer is neither quiet, nor right, nor an abstention."""
    pairs = [(case, _outcome(case, None, "ValueError: x")) for case in CASES]
    found = _figures(pairs)
    for name in (
        "single: named first",
        "pair: both named",
        "no gap: no false alarm",
        "no wrong cause named",
        "no gap: no cause named",
        "not in catalogue: no wrong cause",
        "block right",
        "diagnoses that ended",
    ):
        assert found[name].right == 0, name
    json.dumps(report(CASES, [out for _, out in pairs]), allow_nan=False)


def test_parameter_errors_are_relative_and_counts_are_exact() -> None:
    """|said - true| / |true|; of the change where the model holds the quantity; periods apart."""
    case = Case(
        0,
        1,
        "pair",
        {
            "lead_error": {"lead_m": 0.0202},
            "cogging_torque": {"amplitude_nm": 0.1, "periods_per_rev": 24.0},
        },
        nominal={"lead_error": {"lead_m": 0.02}},
    )
    said = _said({"lead_error": {"lead_m": 0.0201}, "cogging_torque": {"amplitude_nm": 0.11}})
    said["causes"][1]["parameters"]["periods_per_rev"] = {"value": 23.0, "ci95": [23.0, 23.0]}
    lead, amplitude, periods = parameter_errors(case, _outcome(case, said))
    assert lead["relative"] == pytest.approx(1e-4 / 0.0202)
    assert lead["of_change"] == pytest.approx(0.5)
    assert amplitude["relative"] == amplitude["of_change"] == pytest.approx(0.1)
    assert periods["exact"] is False


def test_sheet_constants_count_where_they_were_seen() -> None:
    """Seen and inside counts as right, seen and outside as wrong, unseen not at all."""
    case = Case(
        0, 1, "none", sheet=0.02, constants={"motor.resistance": 0.75, "load.inertia": 2e-3}
    )
    said = _said({}, verdict="within_sheet")
    said["sheet"] = [
        {"parameter": "motor.resistance", "ci95": [0.74, 0.76], "seen": True},
        {"parameter": "load.inertia", "ci95": [1.7e-3, 1.9e-3], "seen": True},
        {"parameter": "motor.inductance", "ci95": [1.0, 2.0], "seen": False},
    ]
    assert sheet_coverage(case, _outcome(case, said)) == [True, False]
    found = _figures([(case, _outcome(case, said))])
    assert found["no gap: no false alarm"].right == 1
    assert found["sheet: constants within interval"].value == 0.5


def test_an_effect_that_cannot_be_seen_is_no_miss() -> None:
    """A single whose effect the recording hides does not count as unnamed; a wrong name does."""
    case = dataclasses.replace(SINGLE, unseen=("backlash_error",))
    quiet = _figures([(case, _outcome(case, _said({}, verdict="no_gap")))])
    assert quiet["single: named first"].count == 0
    assert quiet["   where it cannot be seen"].right == 1
    wrong = _said({"lead_error": {"lead_m": 0.0201}})
    assert _figures([(case, _outcome(case, wrong))])["no wrong cause named"].right == 0


@pytest.mark.parametrize(
    ("drives", "sheet", "single"),
    [
        ("bench", 0.0, 0.98),
        ("bench", 0.02, 0.95),
        ("bench", 0.05, 0.9),
        ("random", 0.0, 0.97),
        ("random", 0.02, 0.93),
        ("rigid", 0.05, 0.9),
    ],
)
def test_what_is_wanted_goes_with_drives_and_sheet(drives, sheet, single) -> None:
    """Each study is held to its own bound, and to none where it holds no such case."""
    case = dataclasses.replace(NONE, drives=drives, sheet=sheet)
    found = _figures([(case, _outcome(case, _said({}, verdict="within_sheet")))])
    assert found["single: named first"].wanted == single
    assert found["single: named first"].met is None
    assert found["no gap: no cause named"].met is (True if sheet and drives != "rigid" else None)


def test_a_share_comes_with_its_interval() -> None:
    """Wilson's interval of 1 of 1 at 95 % begins at 1 / (1 + 1.96^2)."""
    found = _figures([(SINGLE, _outcome(SINGLE, _perfect(SINGLE)))])["single: named first"]
    low, high = found.interval
    assert low == pytest.approx(1.0 / (1.0 + 1.96**2))
    assert high == 1.0


def test_the_subject_sees_the_recording_and_what_to_leave_out_and_nothing_else() -> None:
    """It is called with (recording, nominal drive, names withheld)."""
    case = complete_case(Case(7, 31, "withheld", {"lead_error": {}}, ("lead_error",)), DRIVE)
    calls = []

    def subject(*arguments):
        calls.append(arguments)
        return _said({}, verdict="unexplained")

    outcome = examine(case, DRIVES, subject, False)
    ((recording, drive, without),) = calls
    assert drive == dataclasses.replace(DRIVE, tolerances={"all": "exact"})
    assert without == frozenset({"lead_error"})
    assert len(recording) == 12_000
    assert outcome.index == 7
    assert outcome.named == []


def test_no_diagnosis_can_change_what_is_sealed() -> None:
    """A subject that alters all it is given leaves the labels' hash, and the next recording."""
    cases = [complete_case(Case(0, 31, "none", sheet=0.02), DRIVE)] * 2
    cases[1] = dataclasses.replace(cases[1], index=1)
    sealed = seal(cases)
    stamps = []

    def subject(recording, drive, without):
        with pytest.raises(ValueError):
            recording.rod_position_m[0] = 1.0
        stamps.append((recording.rod_position_m.sum(), dict(drive.tolerances)))
        drive.tolerances.clear()
        return _said({}, verdict="no_gap")

    run_study(cases, DRIVES, subject, baselines=False, workers=1)
    assert stamps[0] == stamps[1]
    assert len(stamps[0][1]) == 12
    assert seal(cases).sha256 == sealed.sha256
    assert sealed.open() == cases


def test_one_failing_case_does_not_end_a_study() -> None:
    """A subject that raises, or answers with what is no diagnosis, leaves an outcome that says
    so; the others are judged."""
    cases = [Case(index, 40 + index, "none") for index in range(3)]

    def subject(recording, drive, without):
        first = int(recording.stamp_ns[0]) % 3
        answers = {0: {"verdict": "no_gap"}, 1: _said({}, verdict="no_gap")}
        return answers[first]

    outcomes = run_study(cases, DRIVES, subject, baselines=False, workers=1)
    assert [outcome.index for outcome in outcomes] == [0, 1, 2]
    for outcome, case in zip(outcomes, cases, strict=True):
        first = int(record_case(case, DRIVE).stamp_ns[0]) % 3
        if first == 1:
            assert outcome.error is None
        else:
            assert outcome.diagnosis is None
            assert ("KeyError" if first == 2 else "no 'location'") in str(outcome.error)


def test_a_diagnosis_without_end_is_ended() -> None:
    """Beyond the limit the block raises TimeoutError, and no alarm is left behind."""
    with pytest.raises(TimeoutError, match=r"within 0\.05 s"), time_limit(0.05):
        time.sleep(5.0)
    time.sleep(0.1)


def test_a_journal_carries_a_study_over_an_interruption(tmp_path) -> None:
    """What was written is read again, a line cut off is dropped, another study's is refused."""
    path = tmp_path / "study.json.partial"
    journal = Journal(path, "abc", resume=False)
    outcomes = [_outcome(case, _perfect(case)) for case in CASES[:2]]
    for outcome in outcomes:
        journal.add(outcome)
    with path.open("a", encoding="utf-8") as out:
        out.write('{"index": 2, "diagn')
    assert Journal(path, "abc", resume=True).outcomes == outcomes
    with pytest.raises(InputError, match="another study"):
        Journal(path, "abd", resume=True)
    with pytest.raises(InputError, match="nothing to resume"):
        Journal(tmp_path / "none.partial", "abc", resume=True)


@pytest.fixture
def said_nothing(monkeypatch):
    monkeypatch.setattr(
        subject_module,
        "product_diagnosis",
        lambda recording, drive, without: _said({}, verdict="no_gap", shrink=0.0),
    )


def test_the_command_prints_the_hash_first_and_writes_everything(
    said_nothing, tmp_path, capsys
) -> None:
    """Hash line, verification, figures; JSON with labels that hash to it; plots; recordings."""
    out, plots, bags = tmp_path / "blind.json", tmp_path / "plots", tmp_path / "bags"
    code = main(
        [
            *("blind", "--cases", "3", "--seed", "3", "--kinds", "none,single"),
            *("--effects", "lead_error", "--no-baselines", "--jobs", "1"),
            *("--json", str(out), "--plots", str(plots), "--write-recordings", str(bags)),
        ]
    )
    assert code == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("3 cases drawn and sealed, SHA-256 ")
    data = json.loads(out.read_text())
    assert data["schema"] == "ecyl.blind/1"
    assert data["sha256"] == lines[0].split()[-1]
    assert {case["label"]["kind"] for case in data["cases"]} == {"none", "single"}
    assert (plots / "calibration.png").stat().st_size > 1000
    assert (plots / "confusion.png").stat().st_size > 1000
    assert sorted(path.name for path in bags.iterdir()) == [
        "case_000.mcap",
        "case_001.mcap",
        "case_002.mcap",
        "labels.json",
    ]
    assert not (tmp_path / "blind.json.partial").exists()


def test_one_case_of_a_study_can_be_looked_at(said_nothing, capsys) -> None:
    """--case prints the label beside what was said."""
    arguments = ["--cases", "4", "--seed", "3", "--kinds", "single", "--effects", "lead_error"]
    assert main(["blind", *arguments, "--case", "2", "--no-baselines", "--jobs", "1"]) == 0
    text = capsys.readouterr().out
    assert "case 2 single: lead_error(lead_m=" in text
    assert "said no_gap" in text


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--cases", "0"], "--cases = 0, expected 1 or more"),
        (["--kinds", "singel"], "did you mean single?"),
        (["--effects", "backlash"], "did you mean backlash_error?"),
        (["--without", "x_local_jam"], "--without: unknown name x_local_jam"),
        (["--cases", "5", "--case", "5"], "--case = 5, expected 0 to 4"),
        (["--resume"], "--resume needs --json"),
        (["--sheet", "0.3"], "--sheet = 0.3, expected 0 to 0.1"),
        (["--drive", "nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(arguments, words, capsys) -> None:
    """The line names the flag and what was expected; nothing is drawn."""
    assert main(["blind", *arguments]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert len(error.strip().splitlines()) == 1


@pytest.mark.slow
def test_baselines_name_what_is_in_their_model_and_absorb_what_is_not() -> None:
    """A wrong resistance is found by both; rotor friction, which the nominal model lacks, is
    called another parameter's error by both."""
    wrong = complete_case(Case(0, 5, "single", {"resistance_error": {}}), DRIVE)
    recording = record_case(wrong, DRIVE)
    assert "resistance_error" in fit_all(recording, DRIVE)
    assert best_swap(recording, DRIVE) == ["resistance_error"]
    rubbing = complete_case(Case(0, 5, "single", {"rotor_coulomb_friction": {}}), DRIVE)
    recording = record_case(rubbing, DRIVE)
    named = best_swap(recording, DRIVE)
    assert named
    assert named != ["rotor_coulomb_friction"]


def test_a_healthy_machine_gives_the_best_swap_nothing_to_name() -> None:
    """At the floor no swap is worth a name."""
    recording = record_case(Case(0, 6, "none"), DRIVE)
    assert best_swap(recording, DRIVE) == []
    assert not math.isnan(float(np.sum(recording.rod_position_m)))


def test_a_share_of_all_is_drawn_though_rounding_puts_its_interval_below(tmp_path) -> None:
    """163 of 163 right: Wilson's upper bound is 1 less rounding."""
    part = {"confidence": 0.988, "count": 163, "right": 1.0, "ci95": [0.977, 1.0 - 1e-16]}
    assert part["ci95"][1] < part["right"]
    write_plots({"calibration": [part], "confusion": {}}, tmp_path)
    assert (tmp_path / "calibration.png").stat().st_size > 1000
