"""The closer twin: the user's drive file with the causes added."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
import yaml
from report_samples import backlash, coulomb, diagnosis

from ecyl_ros.drive.drive_file import config_folder, load_drive, profiles
from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnosis import SheetValue
from ecyl_ros.gap.twin.closer import write_twin
from ecyl_ros.gap.twin.drive_text import add_effects

BOTH = diagnosis("explained", (coulomb(), backlash()))
BENCH = (config_folder() / "bench.yaml").read_text()
EFFECTS = {
    "rotor_coulomb_friction": {
        "coulomb_nm": 0.38023636,
        "breakaway_rad": 1.25e-5,
        "bristle_damping_s": 2e-4,
    },
    "backlash_error": {"backlash_rad": 9.65225644e-3},
}


def twin(tmp_path: Path, text: str) -> str:
    """The twin of a drive file with this text, checked to be the drive with `EFFECTS`."""
    nominal, out = tmp_path / "nominal.yaml", tmp_path / "twin.yaml"
    nominal.write_bytes(text.encode())
    write_twin(BOTH, nominal, out)
    drive = load_drive(nominal)
    assert load_drive(out) == dataclasses.replace(drive, effects={**drive.effects, **EFFECTS})
    return out.read_bytes().decode()


@pytest.mark.parametrize("profile", [one for one in profiles() if not load_drive(one).effects])
def test_the_twin_is_the_nominal_drive_with_the_effects(profile: str, tmp_path: Path) -> None:
    """Of every profile without effects: nominal plus effects, and every line is still there."""
    text = (config_folder() / f"{profile}.yaml").read_text()
    changed = twin(tmp_path, text)
    added = [line for line in changed.splitlines() if line not in text.splitlines()]
    rest = [line for line in changed.splitlines() if line not in added]
    assert rest == text.splitlines()
    assert any("95 %: 0.379 to 0.3814" in line for line in added)


def test_numbers_are_floats_to_every_yaml(tmp_path: Path) -> None:
    """Small numbers carry a dot: YAML 1.1 would read 1e-05 as text."""
    changed = twin(tmp_path, BENCH)
    tree = yaml.safe_load(changed)["/**"]["ros__parameters"]["effects"]
    assert all(isinstance(value, float) for values in tree.values() for value in values.values())
    assert add_effects(BENCH, {"a": {"b": 1e-05}}, {}).count("b: 1.0e-05") == 1


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.rstrip("\n"),
        lambda text: text + "# the end\n\n",
        lambda text: text.replace("\n", "\r\n"),
        lambda text: "\ufeff" + text,
        lambda text: "---\n" + text + "...\n",
        lambda text: str(yaml.safe_load(text)).replace("'", '"'),
        lambda text: yaml.safe_dump(yaml.safe_load(text), default_flow_style=None),
        lambda text: yaml.safe_dump(yaml.safe_load(text), indent=7),
        lambda text: text + "/plant:\n  ros__parameters:\n    use_sim_time: true\n",
        lambda text: text + "    effects: {}\n",
        lambda text: text + "    effects: {constant_load: {force_n: 3.0}}\n",
        lambda text: text + "    effects:\n      constant_load: {force_n: 3.0}  # known\n",
        lambda text: text + "    effects: {backlash_error: {backlash_rad: 0.5}}\n",
        lambda text: (
            text + "    effects:\n      backlash_error:\n        backlash_rad: 0.5 # old\n"
            "      constant_load:\n        force_n: 3.0\n"
        ),
        lambda text: text + "    effects.constant_load.force_n: 3.0\n",
        lambda text: text.replace("/**:", "/plant:"),
    ],
    ids=[
        "no_last_newline",
        "trailing_comment",
        "crlf",
        "byte_order_mark",
        "document_marks",
        "flow",
        "mixed_flow",
        "indented_by_seven",
        "second_node",
        "effects_empty",
        "effects_in_flow",
        "effects_in_block",
        "same_effect_in_flow",
        "same_effect_in_block",
        "dotted_effect",
        "one_node",
    ],
)
def test_drive_files_of_any_layout_are_added_to(change, tmp_path: Path) -> None:
    """However the file is laid out, the twin reads as the nominal drive with the effects."""
    text = change(BENCH)
    changed = twin(tmp_path, text)
    if "\r\n" in text:
        assert changed.count("\n") == changed.count("\r\n")
    for comment in ("# known", "# the end"):
        assert (comment in text) == (comment in changed)


def test_a_constant_that_the_file_leaves_to_its_default_is_written_as_found(tmp_path: Path) -> None:
    """Contact damping and feed scale were found but are not in the file: each goes to its group."""
    text = "".join(line for line in BENCH.splitlines(True) if "contact_damping" not in line)
    nominal, out = tmp_path / "nominal.yaml", tmp_path / "twin.yaml"
    nominal.write_text(text)
    found = {"transmission.contact_damping": 0.149, "controller.feed_scale": 1.0001}
    sheet = tuple(
        SheetValue(key, "", 0.0, 1.0, value, value, value, seen=True, stated=True)
        for key, value in found.items()
    )
    write_twin(dataclasses.replace(BOTH, sheet=sheet), nominal, out)
    drive = load_drive(out)
    assert drive.transmission.contact_damping == 0.149 and drive.controller.feed_scale == 1.0001
    lines = out.read_text().splitlines()
    assert [line for line in text.splitlines() if line not in lines] == []


def test_a_file_that_cannot_be_added_to_is_refused_whole(tmp_path: Path) -> None:
    """Where the same effect stands in dotted keys, which would win, nothing is written."""
    nominal, out = tmp_path / "nominal.yaml", tmp_path / "twin.yaml"
    tail = "/plant:\n  ros__parameters:\n    effects.backlash_error.backlash_rad: 0.5\n"
    nominal.write_text(BENCH + tail)
    with pytest.raises(InputError, match=r"nominal\.yaml.*effects\.backlash_error"):
        write_twin(BOTH, nominal, out)
    assert [path.name for path in tmp_path.iterdir()] == ["nominal.yaml"]


def test_without_a_cause_there_is_no_twin(tmp_path: Path) -> None:
    """A diagnosis that names nothing writes nothing."""
    with pytest.raises(InputError, match="no cause"):
        write_twin(diagnosis("unexplained"), "bench", tmp_path / "twin.yaml")
    assert not list(tmp_path.iterdir())


def test_a_name_of_a_recording_stays_within_its_comment(tmp_path: Path) -> None:
    """A line break in the recording's name does not become YAML."""
    one = dataclasses.replace(BOTH, source="x\n    telemetry_rate: 1.0\n.mcap")
    write_twin(one, "bench", tmp_path / "twin.yaml")
    assert load_drive(tmp_path / "twin.yaml").telemetry_rate == load_drive("bench").telemetry_rate
