"""Recordings of real machines, diagnosed with the files and commands that the docs print."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from ecyl_ros.cli.main import main
from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.drive.rigid.machine_file import key_table, load_machine
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.recording.map_file import load_map
from ecyl_ros.recording.reader import read_recording
from ecyl_ros.recording.signals import Recording

ROOT = Path(__file__).parents[2]
SHARED = ROOT.parent / "shared"
DOCS = ROOT / "docs" / "field"


def test_the_drive_file_page_holds_the_keys_of_rigid_drives() -> None:
    """docs/drive-file.md has the table that the code prints; the pages' files can be read."""
    assert key_table() in (ROOT / "docs" / "drive-file.md").read_text(encoding="utf-8")
    for path in DOCS.glob("*.yaml"):
        if path.name.endswith(".map.yaml"):
            assert load_map(path).signals
        else:
            assert load_machine(path).kind in ("rigid", "follower")


def test_the_worked_examples_link_and_command_files_that_exist() -> None:
    """Every link and every docs/ file of a printed command on the pages exists."""
    for page in DOCS.glob("*.md"):
        text = page.read_text(encoding="utf-8")
        for target in re.findall(r"\]\(([^)#]+)\)", text):
            assert (DOCS / target).exists(), (page, target)
        for target in re.findall(r"docs/field/[\w.]+\w", text):
            assert (ROOT / target).exists(), (page, target)


needs_field = pytest.mark.skipif(
    not (SHARED / "field").is_dir(), reason="no field recordings beside the repository"
)


def _diagnosed(tmp_path: Path, recording: str, name: str, drive: str, *more: str) -> dict:
    out = tmp_path / "out.json"
    arguments = [
        "diagnose",
        str(SHARED / "field" / recording),
        "--map",
        str(DOCS / f"{name}.map.yaml"),
        "--drive",
        str(DOCS / f"{drive}.yaml"),
        "--json",
        str(out),
        "--report",
        str(tmp_path / "out.html"),
        "--overwrite",
        *more,
    ]
    assert main(arguments) == 0
    assert (tmp_path / "out.html").stat().st_size > 10_000
    return json.loads(out.read_text(encoding="utf-8"))


def _causes(result: dict) -> dict[str, dict[str, float]]:
    return {
        one["effect"]: {name: p["value"] for name, p in one["parameters"].items()}
        for one in result["causes"]
    }


def _measured(result: dict) -> dict[str, dict]:
    return {one["name"]: one for one in result["measured"]}


# Janot, Gautier, Brunot (2019): mass, and friction by direction.
PUBLISHED = {
    "mass_kg": 95.109,
    "coulomb_positive_n": 20.14,
    "coulomb_negative_n": 20.63,
    "viscous_positive_n_s_per_m": 166.7,
    "viscous_negative_n_s_per_m": 240.4,
}


@needs_field
@pytest.mark.parametrize(("drive", "sure"), [("emps", 0.9), ("emps_published", 0.6)])
def test_emps_has_friction_that_depends_on_direction(tmp_path, drive, sure) -> None:
    """From nothing and from the published model: named; published values within 3 %, and error.

    Of the published model it removes no more than is left: surer than that nobody can be.
    """
    result = _diagnosed(tmp_path, "emps/DATA_EMPS.mat", "emps", drive)
    assert list(_causes(result)) == ["direction_dependent_friction"]
    assert result["causes"][0]["confidence"] > sure
    assert result["location"]["block"] == "load"
    measured = _measured(result)
    for name, value in PUBLISHED.items():
        assert measured[name]["value"] == pytest.approx(value, rel=0.03), name
    assert measured["relative_force_error"]["value"] <= 0.0311
    assert result["gap"]["after"] <= 0.0311
    ports = {one["block"]: one for one in result["location"]["ports"]}
    assert ports["controller"]["rms"] < 0.05  # N: the loop of the file is the loop that ran


@needs_field
def test_the_published_emps_model_leaves_a_gap_of_its_published_size(tmp_path) -> None:
    """With one friction for both ways the error is near the published 4.08 % (3.81 % elsewhere)."""
    result = _diagnosed(tmp_path, "emps/DATA_EMPS.mat", "emps", "emps_published")
    signal = result["location"]["signals"][0]
    before, after = signal["gap"], signal["after"]
    ratio = result["gap"]["before"]
    assert 0.03 < ratio < 0.045 and after < 0.75 * before


@needs_field
@pytest.mark.parametrize(("file", "cogged"), [("speed_test", 1), ("speed_test1", 0)])
def test_laas_cogging_is_named_where_it_is_not_compensated(tmp_path, file, cogged) -> None:
    """Order 72 of 5 mN m in one state of the flag; in the other a quarter of it at the most."""
    recording = f"laas_pmsm_cogging/{file}.txt"
    span = ("--to", "20")
    bare = _diagnosed(tmp_path, recording, "laas", "laas_loop", "--mode", str(cogged), *span)
    cogging = _causes(bare)["cogging_torque"]
    assert cogging["periods_per_rev"] == 72.0
    assert cogging["amplitude_nm"] == pytest.approx(5.1e-3, rel=0.1)
    (cause,) = [one for one in bare["causes"] if one["effect"] == "cogging_torque"]
    assert cause["confidence"] > 0.9 and cause["shrink"] > 0.3
    calm = _diagnosed(tmp_path, recording, "laas", "laas_loop", "--mode", str(1 - cogged), *span)
    left = _causes(calm).get("cogging_torque", {})
    at_72 = [
        left[name.replace("periods", "amplitude").replace("_per_rev", "_nm")]
        for name, value in left.items()
        if name.startswith("periods") and value == 72.0
    ]
    assert sum(at_72) < 0.25 * cogging["amplitude_nm"]  # plain least squares: 1.2 of 5.3 mN m
    assert max([one for name, one in left.items() if "amplitude" in name], default=0.0) < (
        0.25 * cogging["amplitude_nm"]
    )
    # The compensation is a current that the speed loop does not ask for.
    above = [
        next(one for one in result["location"]["ports"] if one["block"] == "controller")["rms"]
        for result in (bare, calm)
    ]
    assert above[1] > 3.0 * above[0]


@needs_field
def test_laas_current_shows_the_same_cogging_in_both_states(tmp_path) -> None:
    """By the measured current the machine itself cogs alike, compensated or not; inertia found."""
    found = []
    for mode in ("0", "1"):
        result = _diagnosed(
            tmp_path, "laas_pmsm_cogging/speed_test.txt", "laas", "laas", "--mode", mode
        )
        cogging = _causes(result)["cogging_torque"]
        assert cogging["periods_per_rev"] == 72.0
        found.append(cogging["amplitude_nm"])
        inertia = _measured(result)["inertia_kg_m2"]
        if mode == "1":  # swinging, the rotor shows its inertia; at even speed it hardly does
            assert inertia["value"] == pytest.approx(5e-6, rel=0.12)
    assert found[0] == pytest.approx(found[1], rel=0.15)


@needs_field
def test_laas_cogging_without_its_name_is_a_law_of_the_angle(tmp_path) -> None:
    """72 waves a turn of 5 mN m, not a law of the speed that the loop answers them with."""
    without = (
        "cogging_torque,torque_ripple,periodic_disturbance,constant_load,load_dependent_friction,"
        "stribeck_friction,rotor_coulomb_friction,friction_drift,rotor_viscous_friction,"
        "direction_dependent_friction"
    )
    result = _diagnosed(
        tmp_path,
        "laas_pmsm_cogging/speed_test1.txt",
        "laas",
        "laas_loop",
        "--mode",
        "0",
        "--without",
        without,
    )
    law = result["law"]
    assert (law["port"], law["of"]) == ("rotor_torque", ["rotor_angle"])
    values = np.array(law["table"]["values"])
    waves = 2.0 * np.abs(np.fft.rfft(values)) / values.size
    order = np.argmax(waves[1:]) + 1
    assert order * round(2.0 * np.pi / law["period"][0]) == 72
    assert waves[order] == pytest.approx(5.1e-3, rel=0.2)


@needs_field
@pytest.mark.parametrize("folder", ["backlash_detection", "friction_gravity"])
def test_sage_is_told_what_it_allows_and_no_more(tmp_path, folder) -> None:
    """Two runs of a joint agree on lag and dead band; no cause is named, the limits are."""
    result = _diagnosed(tmp_path, f"sage_so101/{folder}", "sage", "sage")
    assert result["causes"] == [] and result["verdict"] == "unexplained"
    assert result["location"]["block"] is None
    measured = _measured(result)
    assert measured["resolution_rad"]["value"] == pytest.approx(2.0 * np.pi / 4096.0, rel=1e-3)
    assert measured["highest_frequency_hz"]["value"] == pytest.approx(25.0, rel=0.02)
    assert measured["lag_s"]["value"] == pytest.approx(0.065, abs=0.005)
    # 0.8 to 0.9 degrees of play on a bench; with stiction and dead band it can only be more.
    assert np.radians(0.8) < measured["dead_band_rad"]["value"] < np.radians(1.6)
    text = " ".join(result["notes"])
    assert "no cause is named" in text and "backlash between motor and encoder" in text


@pytest.mark.skipif(
    not (SHARED / "recordings" / "labels.json").is_file(), reason="no foreign recordings"
)
def test_an_electric_cylinder_without_electrical_signals_is_judged_as_rigid() -> None:
    """Rotor angle and torque alone: what a rigid model knows is named and sized, no more."""
    folder = SHARED / "recordings"
    labels = json.loads((folder / "labels.json").read_text(encoding="utf-8"))
    drive = load_drive(SHARED / "drives" / "bench.yaml")
    inertia = drive.motor.rotor_inertia + drive.load.inertia
    ratio = drive.transmission.rod_per_rotor
    machine = Machine(
        kind="rigid",
        output="rotary",
        actuation="torque",
        gain=1.0,
        inertia=inertia,
        viscous=drive.motor.viscous_friction + drive.load.viscous_friction,
    )
    seen = 0
    for name, label in labels.items():
        whole = read_recording(folder / f"{name}.mcap")
        bare = Recording(
            stamp_ns=whole.stamp_ns,
            rotor_position_rad=whole.rotor_position_rad,
            rotor_torque_nm=whole.rotor_torque_nm,
        )
        result = diagnose(bare, machine)
        named = {one.effect: {p.name: p.value for p in one.parameters} for one in result.causes}
        truth = label["truth"]
        expected = {re.sub("^load_(inertia|coulomb|viscous)", r"rotor_\1", one) for one in truth}
        expected = {one.removeprefix("x_") for one in expected}
        # Clearance, electrical faults and kinematic errors do not act on a rigid rotor.
        assert set(named) <= expected, name
        for effect, values in truth.items():
            here = named.get(re.sub("^load_(inertia|coulomb|viscous)", r"rotor_\1", effect), {})
            for parameter, value in values.items():
                if effect == "constant_load" and here:
                    assert here["torque_nm"] == pytest.approx(value * ratio, rel=0.02)
                elif effect == "load_inertia_error" and here:
                    value += drive.motor.rotor_inertia
                    assert here[parameter] == pytest.approx(value, rel=0.02)
                elif parameter in here:
                    assert here[parameter] == pytest.approx(value, rel=0.05)
            seen += bool(here)
    assert seen >= 5
