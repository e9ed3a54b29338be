"""The diagnosis against drives whose fault is known: foreign recordings, the study's machines."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from sheets import exact

from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.study.cylinder.cases import Case, record_case
from ecyl_ros.recording.reader import read_recording

SHARED = Path(__file__).parents[3] / "shared"
LABELS = SHARED / "recordings" / "labels.json"


def _labels() -> dict[str, dict]:
    return json.loads(LABELS.read_text(encoding="utf-8")) if LABELS.is_file() else {}


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(_labels()) or [None])
def test_every_foreign_recording_is_diagnosed_right(name) -> None:
    """Recordings of another simulator: cause, block, verdict, parameters within 1 %, intervals."""
    if name is None:
        pytest.skip("no foreign recordings beside the repository (../shared/recordings)")
    label = _labels()[name]
    drive = exact(SHARED / "drives" / "bench.yaml")
    recording = read_recording(SHARED / "recordings" / f"{name}.mcap")
    result = diagnose(recording.slice(0.0, 4.0), drive)
    expected = {effect.removeprefix("x_") for effect in label["effects"]}
    assert {cause.effect for cause in result.causes} == expected
    assert result.verdict == ("explained" if expected else "no_gap")
    assert (result.block is None) == (not expected)
    assert result.shrink > 0.97 or not expected
    for cause in result.causes:
        assert cause.confidence > 0.9 and cause.alternatives == ()
        truth = label["truth"].get(cause.effect, {})
        for parameter in cause.parameters:
            if parameter.name in truth:
                assert parameter.value == pytest.approx(truth[parameter.name], rel=0.01)
                assert parameter.low <= truth[parameter.name] <= parameter.high


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "values", "block"),
    [
        ("load_coulomb_friction", {"coulomb_nm": 0.2}, "load"),
        ("resistance_error", {"resistance_ohm": 1.1}, "motor_electrical"),
        ("current_sensor_offset", {"offset_a": 0.15}, "sensor"),
    ],
)
def test_a_machine_of_another_make_is_diagnosed(effect, values, block) -> None:
    """The study's machine (LuGre, Heun, penalty contact) with one fault: named, sized, placed."""
    drive = exact("bench")
    case = Case(0, 4, "single", {effect: values})
    result = diagnose(record_case(case, drive).slice(0.0, 3.0), drive)
    assert [cause.effect for cause in result.causes] == [effect]
    assert result.block == block and result.verdict == "explained"
    (name, truth), *_ = values.items()
    found = {one.name: one.value for one in result.causes[0].parameters}
    assert found[name] == pytest.approx(truth, rel=0.03)


@pytest.mark.slow
def test_without_its_effect_a_machine_is_not_blamed_on_another() -> None:
    """Cogging with cogging and ripple taken out of the catalogue: no cause; described at most."""
    drive = exact("bench")
    case = Case(0, 5, "single", {"cogging_torque": {"amplitude_nm": 0.06, "periods_per_rev": 12.0}})
    recording = record_case(case, drive).slice(0.0, 2.0)
    result = diagnose(recording, drive, without=("cogging_torque", "torque_ripple"))
    assert result.causes == () and result.verdict in ("unexplained", "described")
    assert result.as_json()["causes"] == []
    assert any("fits too badly" in note or "catalogue" in note for note in result.notes) or (
        result.candidates
    )


def test_a_healthy_machine_has_no_gap() -> None:
    """The study's machine without a fault: no gap, no block, nothing named."""
    drive = exact("bench")
    result = diagnose(record_case(Case(0, 6, "none"), drive), drive)
    assert result.verdict == "no_gap" and result.block is None and result.causes == ()


def test_the_emulated_drive_has_no_gap_to_its_own_model() -> None:
    """A recording of the node graph, noise going round its loop: no gap to the same drive file."""
    bag = Path(__file__).parents[2] / "bags" / "bench_moves.mcap"
    result = diagnose(read_recording(bag), exact("bench"))
    assert result.verdict == "no_gap"


def test_an_effect_that_does_not_exist_cannot_be_left_out() -> None:
    """A misspelt effect is refused by name."""
    bag = Path(__file__).parents[2] / "bags" / "bench_moves.mcap"
    with pytest.raises(InputError, match="without cogging: no such effect"):
        diagnose(read_recording(bag), exact("bench"), without=("cogging",))
