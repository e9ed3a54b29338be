"""`ecyl new-effect`: a learned law as an effect of the catalogue."""

from __future__ import annotations

import dataclasses
import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from rigid_machines import LINEAR, ROTARY, motion, recorded

from ecyl_ros.cli.main import main
from ecyl_ros.drive.drive_file import drive_to_flat, load_drive
from ecyl_ros.drive.law import Law
from ecyl_ros.drive.packed import pack
from ecyl_ros.drive.rigid.law import asked, law_of
from ecyl_ros.effects.learned import law_value
from ecyl_ros.gap.describe.effect_file import effect_text
from ecyl_ros.gap.describe.rigid_effect_file import rigid_effect_text
from ecyl_ros.gap.rigid.motion import motion_of
from ecyl_ros.gap.rigid.terms import Catalogue

DRIVE = load_drive("bench")


def test_a_learned_law_becomes_an_effect_that_plays_it(tmp_path: Path, capsys):
    """`ecyl new-effect`: the file it writes gives, as an effect, what the law gives."""
    at = ((-0.01, -0.004, 0.0, 0.01), (-1.0, 1.0))
    values = (0.1, 0.2, 0.4, 0.1, 0.0, 0.3, 0.2, 0.25)
    law = Law("load_friction", ("position", "speed"), at, values)
    flat = drive_to_flat(dataclasses.replace(DRIVE, learned=law))
    drive = tmp_path / "drive.yaml"
    flat = {key: one for key, one in flat.items() if one != []}
    drive.write_text(yaml.safe_dump({"/**": {"ros__parameters": flat}}))
    out, test = tmp_path / "tired_rail.py", tmp_path / "test_tired_rail.py"
    asked = ["new-effect", str(drive), "--name", "tired_rail", "--out", str(out)]
    assert main([*asked, "--test", str(test)]) == 0
    compile(test.read_text(), str(test), "exec")
    assert main(asked) == 2  # it is there
    module = _loaded(out, "tired_rail")
    assert module.EFFECT.parameters[0].name == "peak_nm"
    record = pack(dataclasses.replace(DRIVE, learned=law))[0]

    class Given:
        tired_rail_peak_nm = 0.4
        rod_per_rotor = DRIVE.transmission.rod_per_rotor

    for place, speed in ((-0.02, 0.3), (-0.003, -0.7), (0.004, 2.0), (0.009, 0.0)):
        angle = place / DRIVE.transmission.rod_per_rotor
        played = law_value(record, angle, speed, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        named = module.load_friction.py_func(Given, speed, 0.0, angle, 0.0)
        assert named == pytest.approx(max(played, 0.0), rel=1e-6, abs=1e-9)
    capsys.readouterr()


@pytest.mark.parametrize(
    ("machine", "port", "of", "table"),
    [
        (
            LINEAR,
            "load_friction",
            ["position"],
            {"at": [-0.1, 0.0, 0.1], "values": [4.0, 9.0, 3.0]},
        ),
        (LINEAR, "load_torque", ["position"], {"at": [-0.1, 0.0, 0.1], "values": [-4.0, 9.0, 3.0]}),
        (
            ROTARY,
            "rotor_friction",
            ["direction", "rotor_angle"],
            {"at": [-1.0, 1.0], "at_2": [-2.0, 0.0, 2.0], "values": [0.4, 0.9, 0.3, 0.1, 0.2, 0.5]},
        ),
    ],
    ids=["drag", "load", "drag of two variables"],
)
def test_a_rigid_drives_law_becomes_an_effect_that_asks_for_it(
    tmp_path: Path, machine, port: str, of: list[str], table, capsys
) -> None:
    """Along a motion, and in the kernel of a replay, the written effect gives what the law gives;
    its test compiles."""
    output = "linear" if machine.linear else "rotary"
    inertia = {"mass": 20.0} if machine.linear else {"inertia": 0.02}
    learned = {"port": port, "of": of, "table": table}
    keys = {"drive": {"kind": "rigid", "output": output}, "load": inertia}
    drive, out = tmp_path / "drive.yaml", tmp_path / "tired_rail.py"
    tree = {"/**": {"ros__parameters": {**keys, "effects": {"learned": learned}}}}
    drive.write_text(yaml.safe_dump(tree))
    test = tmp_path / "test_tired_rail.py"
    asks = ["new-effect", str(drive), "--name", "tired_rail", "--out", str(out)]
    assert main([*asks, "--test", str(test)]) == 0
    compile(test.read_text(), str(test), "exec")
    module = _loaded(out, "tired_rail")

    flat = {f"effects.learned.table.{key}": value for key, value in table.items()}
    flat |= {"effects.learned.port": port, "effects.learned.of": of}
    law = law_of(flat, machine.linear, "test")
    assert law is not None
    m = motion(0.1 if machine.linear else 2.0, duration_s=4.0)
    moved = motion_of(recorded(m, m.a, machine, 0.0, 1e-7), machine, "r")
    along = Catalogue(moved, machine).along
    peak = max(map(abs, law.values))
    wanted = asked(law, moved, along.sign, moved.effort)
    assert np.ptp(wanted) > peak
    given = module.RIGID.asked(along, {"peak": peak}, moved.effort)
    np.testing.assert_allclose(given, wanted, atol=1e-6 * peak)
    row = int(np.argmax(np.abs(wanted)))
    place, speed = moved.position[row], moved.velocity[row]
    if law.of_friction:
        level = module.rigid_level(np.array([peak]), 0.0, place, speed, 0.0)
        assert along.sign[row] * level == pytest.approx(wanted[row], rel=1e-6)
    else:
        assert module.rigid_load(np.array([peak]), 0.0, place) == pytest.approx(
            wanted[row], rel=1e-6
        )
    capsys.readouterr()


def test_a_rigid_drives_load_that_depends_on_speed_is_refused() -> None:
    """A kernel for loads is given time and place alone."""
    law = Law("load_torque", ("speed",), ((0.0, 1.0),), (0.0, 1.0))
    with pytest.raises(Exception, match=r"= speed: an effect at load_torque is not given it"):
        rigid_effect_text(law, "windy", linear=True)


def _loaded(path: Path, name: str):
    spec = importlib.util.spec_from_file_location(f"ecyl_ros.effects.{name}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    try:
        spec.loader.exec_module(module)
    finally:
        del sys.modules[spec.name]
    return module


def test_an_effect_that_cannot_play_a_law_is_refused(tmp_path: Path, capsys):
    """A law of heat, a name that is taken, a drive file without a law: one line, exit 2."""
    law = Law("rotor_friction", ("heat",), ((0.0, 1.0),), (0.0, 1.0), (), 1.0)
    with pytest.raises(Exception, match=r"effects.learned.of = heat: an effect at rotor_friction"):
        effect_text(law, "warm")
    with pytest.raises(Exception, match=r"--name local_jam: there is such an effect"):
        effect_text(Law("load_torque", (), (), (1.0,)), "local_jam")
    out = tmp_path / "some.py"
    assert main(["new-effect", "bench", "--name", "some", "--out", str(out)]) == 2
    assert "no effects.learned; expected a learned law" in capsys.readouterr().err
    assert not out.exists()
