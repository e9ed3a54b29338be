"""The locked-output bench against Table 1, closed forms and drives whose transmission is known."""

import dataclasses
import json

import numpy as np
import pytest

from ecyl_ros.analysis.bench import table1
from ecyl_ros.analysis.bench.budget import error_budget
from ecyl_ros.analysis.bench.coverage import coverage, true_values
from ecyl_ros.analysis.bench.edges import split_edges
from ecyl_ros.analysis.bench.fit import fit_lines
from ecyl_ros.analysis.bench.identify import identify
from ecyl_ros.analysis.bench.lines import ThreeLines
from ecyl_ros.analysis.bench.loop import Loop
from ecyl_ros.analysis.bench.measured import read_loop, write_loop
from ecyl_ros.analysis.bench.median_curve import median_curve
from ecyl_ros.analysis.bench.sensors import BenchSensors, read
from ecyl_ros.analysis.bench.simulated import BenchTest, simulated_loop, with_sensors
from ecyl_ros.analysis.bench.units import ARCMIN, ARCSEC
from ecyl_ros.cli.main import main
from ecyl_ros.drive.drive_file import drive_to_flat, load_drive
from ecyl_ros.errors import InputError
from ecyl_ros.recording import Recording
from ecyl_ros.recording.writer import write_recording

TABLE_1 = {
    "k1_rad_per_nm": 14.725 * ARCMIN,
    "k2_rad_per_nm": 0.529 * ARCMIN,
    "k3_rad_per_nm": 0.348 * ARCMIN,
    "t1_nm": 1.491,
    "t2_nm": 17.23,
}
LINES = ThreeLines(*TABLE_1.values())
SHAFT = BenchTest().shaft_twist_rad_per_nm


@pytest.fixture(scope="module")
def truth() -> Loop:
    """The loop of Table 1's transmission, as perfect sensors read it."""
    return simulated_loop(table1.table_1_drive())


def test_table_1_comes_back_without_noise(truth):
    """k1, k2, k3, T1 and T2 within 0.1 % of Table 1."""
    fit = identify(truth, shaft_twist_rad_per_nm=SHAFT).fit
    for name, value in TABLE_1.items():
        assert getattr(fit, name).value == pytest.approx(value, rel=1e-3), name


def test_intervals_hold_the_truth_as_often_as_they_say():
    """200 draws of sensor errors: each of the five parameters lies in its own 95 % interval in
    91 to 98.5 % of them (three standard deviations of a share of 200), and none is biased."""
    found = coverage(table1.table_1_drive(), 200)
    assert {one.name: one.truth for one in found} == pytest.approx(TABLE_1)
    for one in found:
        assert one.shown == 1.0 and 0.91 <= one.inside <= 0.985, one
        assert abs(one.bias) < 4.0 * one.scatter / np.sqrt(200), one


def test_draws_are_those_of_single_runs(truth):
    """The share over draws is counted on what identify says of each, seed by seed."""
    inside = 0
    for seed in range(6):
        loop = with_sensors(truth, BenchSensors(), seed)
        one = identify(loop, shaft_twist_rad_per_nm=SHAFT).fit.k2_rad_per_nm
        inside += one.low <= TABLE_1["k2_rad_per_nm"] <= one.high
    found = {one.name: one for one in coverage(table1.table_1_drive(), 6, jobs=1)}
    assert found["k2_rad_per_nm"].inside == pytest.approx(inside / 6)


def test_draws_need_a_truth():
    """A transmission that three lines cannot be, or that an effect changes, is refused."""
    drive = load_drive("bench")
    error = {"stiffness_error": {"stiffness_nm_per_rad": 4000.0}}
    with pytest.raises(InputError, match=r"effects\.stiffness_error"):
        true_values(dataclasses.replace(drive, effects=error))
    four = dataclasses.replace(
        drive.transmission, stiffness=(1.0, 2.0, 3.0, 4.0), stiffness_breaks=(1.0, 2.0, 3.0)
    )
    with pytest.raises(InputError, match="no three lines"):
        true_values(dataclasses.replace(drive, transmission=four))
    assert true_values(drive) == {
        "clearance_rad": drive.transmission.backlash,
        "k2_rad_per_nm": 1.0 / 6498.0,
    }


def test_the_verb_counts_draws(capsys):
    """--draws prints the share for what the drive has: clearance and stiffness of `bench`."""
    assert main(["bench", "--drive", "bench", "--draws", "4", "--readings", "1000"]) == 0
    printed = capsys.readouterr().out
    assert "of 4 draws" in printed and "clearance_rad" in printed and "t2_nm" not in printed


def test_the_loop_is_the_law_shifted_by_friction(truth):
    """Away from the reversals, the edges stand at the three lines -+ 1 N m and 2 % of the load."""
    for edges, sign in (
        (split_edges(truth).rising, 1.0),
        (split_edges(truth).falling, -1.0),
    ):
        applied = truth.torque_nm[edges[0]]
        angle = truth.angle_rad[edges[0]] - SHAFT * applied
        turned = sign * applied > -35.0
        carried = (applied - sign * 1.0) / (1.0 + sign * 0.02 * np.sign(applied - sign * 1.0))
        np.testing.assert_allclose(
            angle[turned], LINES.angle_rad(carried[turned]), atol=0.02 * ARCMIN
        )


def test_force_on_the_rod_is_the_transmitted_torque_over_the_lead(truth):
    """At +50 N m, 1 N m and 2 % of friction leave 48.04 N m: 32.6 kN at 20 mm and 2.16 to 1."""
    top = int(np.argmax(truth.torque_nm))
    carried = (50.0 - 1.0) / 1.02
    assert truth.force_n[top] == pytest.approx(carried * 2.0 * np.pi * 2.16 / 0.02, rel=1e-3)


def test_equation_7_is_continuous_when_put_right_and_jumps_as_printed():
    """At T2 the corrected branches meet; the printed ones are 2.85 arcmin apart."""
    just = np.array([17.23 * (1 - 1e-9), 17.23 * (1 + 1e-9)])
    below, above = LINES.angle_rad(just)
    assert above == pytest.approx(below, abs=1e-9)
    below, above = LINES.angle_as_printed_rad(just)
    expected = (0.529 - 0.348) * (17.23 - 1.491)
    assert (below - above) / ARCMIN == pytest.approx(expected, abs=1e-6)
    assert LINES.jump_as_printed_rad / ARCMIN == pytest.approx(expected)
    np.testing.assert_allclose(LINES.angle_rad(-just), -LINES.angle_rad(just))


def test_the_tie_of_t2_is_the_least_squares_optimum(truth):
    """The tied fit leaves no more than scipy's fit of all six free parameters."""
    from scipy.optimize import curve_fit

    loop = with_sensors(truth, BenchSensors(), 3)
    curve = median_curve(loop, split_edges(loop))
    fit = fit_lines(curve)

    def torque(angle, s1, s2, s3, a1, a2, zero):
        size = np.abs(angle - zero)
        up = s1 * np.minimum(size, a1) + s2 * np.clip(size - a1, 0, a2 - a1)
        return np.sign(angle - zero) * (up + s3 * np.maximum(size - a2, 0))

    start = [1 / LINES.k1, 1 / LINES.k2, 1 / LINES.k3, LINES.k1 * LINES.t1, 8.8e-3, 0.0]
    free, _ = curve_fit(
        torque, curve.angle_rad, curve.torque_nm, start, x_scale=np.abs(start) + 1e-4, method="trf"
    )
    rest = torque(curve.angle_rad, *free) - curve.torque_nm
    assert fit.misfit_nm <= np.sqrt(np.mean(rest**2)) * 1.001
    assert fit.k2_rad_per_nm.value == pytest.approx(1 / free[1], rel=3e-4)


def test_clearance_of_table_1_is_twice_what_the_text_says(truth):
    """Between -+1.5 N m lie 2 (k1 T1 + k2 0.009) = 43.92 arcmin, 2.16 times the 20.15 printed, to
    1 %; on the fit and read off the curve alike."""
    found = identify(truth, shaft_twist_rad_per_nm=SHAFT)
    expected = 2.0 * (14.725 * 1.491 + 0.529 * (1.5 - 1.491))
    assert found.clearance_rad.value / ARCMIN == pytest.approx(expected, rel=1e-3)
    assert found.clearance_read_rad / ARCMIN == pytest.approx(expected, rel=2e-2)
    assert expected / 20.15 == pytest.approx(2.16, rel=0.01)


def test_stiffness_is_the_slope_of_the_curve(truth):
    """1/k2 = 6498.6 N m/rad up to T2, 1/k3 = 9878.6 beyond; the secant is far below both."""
    found = identify(truth, shaft_twist_rad_per_nm=SHAFT)
    first, second = found.stiffness
    assert first.nm_per_rad.value == pytest.approx(6498.58, rel=1e-3)
    assert second.nm_per_rad.value == pytest.approx(9878.58, rel=1e-3)
    assert second.from_nm == pytest.approx(17.23, rel=1e-3)
    assert found.secant_nm_per_rad < 4000.0


def test_the_shaft_left_in_shows_in_k3_by_its_share(truth):
    """0.94 arcsec at 50 N m are 0.090 % of k3: under the sensor's resolution, but not averaged."""
    fit = identify(truth, shaft_twist_rad_per_nm=0.0).fit
    share = (0.94 / 60.0 / 50.0) / 0.348
    assert share == pytest.approx(9.0e-4, rel=0.01)
    assert fit.k3_rad_per_nm.value / TABLE_1["k3_rad_per_nm"] - 1.0 == pytest.approx(
        share, abs=1.5e-4
    )


def test_error_budget():
    """Shaft twist 0.94 and 1.362 arcsec, under the 2 of the sensor; 0.4 N m are 8.35 arcsec on the
    third line; 5 um of the rod are 11.66 arcmin at the input."""
    items = {
        one.source: one.angle_rad / ARCSEC for one in error_budget(LINES, table1.table_1_drive())
    }
    assert items["input shaft, gear to angle sensor"] == pytest.approx(0.94)
    assert items["input shaft, gear to far end"] == pytest.approx(1.362)
    assert items["angle sensor"] == pytest.approx(2.0)
    assert items["torque sensor, third line"] == pytest.approx(0.4 * 0.348 * 60.0)
    mount = next(value for name, value in items.items() if "mount" in name)
    assert mount / 60.0 == pytest.approx(5e-6 / (0.02 / (2 * np.pi * 2.16)) / ARCMIN)


@pytest.mark.parametrize("profile", ["bench", "si"])
def test_a_drive_is_found_again_and_written_back(profile, tmp_path):
    """With sensor noise, what --write-drive writes is the drive's own transmission within the
    intervals printed, all other keys and comments untouched."""
    out, json_out = tmp_path / "found.yaml", tmp_path / "o.json"
    arguments = ["bench", "--drive", profile, "--write-drive", str(out), "--json", str(json_out)]
    assert main(arguments) == 0
    nominal, found = drive_to_flat(load_drive(profile)), drive_to_flat(load_drive(out))
    changed = {key for key in nominal if nominal[key] != found[key]}
    assert changed <= {
        "transmission.backlash",
        "transmission.stiffness",
        "transmission.stiffness_breaks",
    }
    assert found["transmission.backlash"] == pytest.approx(
        nominal["transmission.backlash"], rel=0.005
    )
    assert found["transmission.stiffness"] == pytest.approx(
        nominal["transmission.stiffness"], rel=0.01
    )
    assert found["transmission.stiffness_breaks"] == pytest.approx(
        nominal["transmission.stiffness_breaks"], rel=0.01
    )
    result = json.loads(json_out.read_text(), parse_constant=pytest.fail)
    assert result["schema"] == "ecyl.bench/1"
    assert result["fit"]["k1_rad_per_nm"] is None and "dead zone" in " ".join(result["notes"])
    assert "20.15 arcmin" not in out.read_text()  # the comment told of the old value
    assert "# ohm" in out.read_text()


def test_a_loop_in_arcmin_with_other_column_names_is_read(truth, tmp_path, capsys):
    """A staircase test of three loops, angle in arcmin from an arbitrary zero: Table 1 within its
    intervals widened twice."""
    drive = table1.table_1_drive()
    test = BenchTest(readings=400, loops=3, shaft_twist_rad_per_nm=0.0)
    loop = simulated_loop(drive, test)
    held = Loop(  # every step of the staircase is read five times
        torque_nm=np.repeat(loop.torque_nm, 5), angle_rad=np.repeat(loop.angle_rad, 5)
    )
    noisy = with_sensors(held, BenchSensors(), 5)
    path = tmp_path / "theirs.csv"
    rows = zip(noisy.torque_nm, noisy.angle_rad / ARCMIN + 1234.5, strict=True)
    path.write_text("Torque,Twist\n" + "".join(f"{t:.6f},{a:.6f}\n" for t, a in rows))
    out = tmp_path / "o.json"
    arguments = ["--torque-column", "Torque", "--angle-column", "Twist", "--angle-unit", "arcmin"]
    assert main(["bench", "--loop", str(path), *arguments, "--json", str(out)]) == 0
    result = json.loads(out.read_text())
    assert result["edges"] == {"rising": 3, "falling": 3}
    for name, value in TABLE_1.items():
        low, high = result["fit"][name]["ci95"]
        assert low - (high - low) / 2 < value < high + (high - low) / 2, name
    assert result["fit"]["angle_zero_rad"] / ARCMIN == pytest.approx(1234.5, abs=0.1)


def test_a_loop_out_and_in_is_the_same(truth, tmp_path):
    """CSV keeps every digit of torque, angle, force and displacement."""
    noisy = with_sensors(truth, BenchSensors(), 9)
    write_loop(noisy, tmp_path / "loop.csv")
    back, notes = read_loop(tmp_path / "loop.csv")
    assert notes == ()
    for name in ("torque_nm", "angle_rad", "force_n", "displacement_m"):
        np.testing.assert_array_equal(getattr(back, name), getattr(noisy, name))


def test_a_recording_is_a_loop_too(tmp_path, capsys):
    """Rotor torque and angle of a recording: the same figures as from CSV; a rod that moved is
    told of."""
    loop = simulated_loop(load_drive("si"), BenchTest(shaft_twist_rad_per_nm=0.0))
    recording = Recording(
        stamp_ns=np.arange(loop.torque_nm.size) * 1_000_000,
        rotor_torque_nm=loop.torque_nm,
        rotor_position_rad=loop.angle_rad,
        rod_position_m=np.linspace(0.0, 1e-4, loop.torque_nm.size),
    )
    write_recording(recording, tmp_path / "loop.mcap")
    found, notes = read_loop(tmp_path / "loop.mcap")
    assert identify(found).fit.lines == identify(loop).fit.lines
    assert any("was not locked" in note for note in notes)


def test_sensor_zeros_do_not_matter(truth):
    """2 N m and 40 arcmin added to every reading change no figure but the zeros."""
    noisy = with_sensors(truth, BenchSensors(), 1)
    moved = dataclasses.replace(
        noisy, torque_nm=noisy.torque_nm + 2.0, angle_rad=noisy.angle_rad + 40.0 * ARCMIN
    )
    # The shaft's twist is left in: subtracted from the moved torque it would move the angle.
    here, there = identify(noisy), identify(moved)
    for name in TABLE_1:
        assert getattr(there.fit, name).value == pytest.approx(
            getattr(here.fit, name).value, rel=1e-5
        )
    assert there.fit.torque_zero_nm - here.fit.torque_zero_nm == pytest.approx(2.0, abs=1e-5)
    assert there.clearance_rad.value == pytest.approx(here.clearance_rad.value, rel=1e-5)


@pytest.mark.parametrize(("friction", "load"), [(0.0, 0.0), (3.0, 0.0), (8.0, 0.1)])
def test_friction_of_any_size_cancels(friction, load):
    """Without, with 3 N m, with 8 N m and 10 % of the load: k2, k3, T2 within 0.5 % of Table 1."""
    test = BenchTest(friction_nm=friction, load_friction=load, shaft_twist_rad_per_nm=0.0)
    fit = identify(simulated_loop(table1.table_1_drive(), test)).fit
    for name in ("k2_rad_per_nm", "k3_rad_per_nm", "t2_nm"):
        assert getattr(fit, name).value == pytest.approx(TABLE_1[name], rel=5e-3), name


def test_a_loop_begun_within_an_edge_is_put_together():
    """From the middle of one rising edge to that of the next: both parts count as one edge."""
    test = BenchTest(loops=2, shaft_twist_rad_per_nm=0.0)
    loop = simulated_loop(table1.table_1_drive(), test)
    tops = np.flatnonzero(loop.torque_nm >= 50.0)
    part = slice(int(tops[2]) - 2000, int(tops[-1]) - 2000)
    cut = Loop(loop.torque_nm[part], loop.angle_rad[part])
    edges = split_edges(cut)
    assert (len(edges.rising), len(edges.falling)) == (2, 1)
    assert identify(cut).fit.k2_rad_per_nm.value == pytest.approx(
        TABLE_1["k2_rad_per_nm"], rel=1e-3
    )


@pytest.mark.parametrize("limit", [5.0, 14.0])
def test_a_short_loop_says_what_it_cannot_show(limit):
    """To 14 N m T2 is out of reach: one stiffness, said so, within 3 % of 1/k2. To 5 N m friction
    turns round over the flanks: a note says up to which torque anything is known."""
    test = BenchTest(torque_limit_nm=limit, friction_nm=0.5)
    loop = with_sensors(simulated_loop(table1.table_1_drive(), test), BenchSensors(), 1)
    found = identify(loop, shaft_twist_rad_per_nm=SHAFT)
    assert found.fit.k3_rad_per_nm is None and found.fit.t2_nm is None
    assert any("no k3" in note for note in found.notes)
    if limit == 14.0:
        expected = pytest.approx(TABLE_1["k2_rad_per_nm"], rel=0.03)
        assert found.fit.k2_rad_per_nm.value == expected
    else:
        assert any("nothing is known beyond" in note for note in found.notes)


def test_a_soft_transmission_takes_no_longer():
    """Profile `paper`, 50 N m on 1.89 N m/rad, 26 rad: simulated in the same number of steps."""
    loop = simulated_loop(load_drive("paper"), BenchTest(friction_nm=0.0, load_friction=0.0))
    expected = 0.5 * 5.861397e-3 + 17.23 / 1.890359 + (50.0 - 17.23) / 2.873563
    assert loop.angle_rad.max() == pytest.approx(expected, rel=1e-6)


def test_effects_of_the_drive_act_on_the_bench():
    """A drive with stiffness_error and rotor friction shows both in its loop."""
    drive = dataclasses.replace(
        load_drive("bench"),
        effects={
            "stiffness_error": {"stiffness_nm_per_rad": 4000.0},
            "rotor_coulomb_friction": {"coulomb_nm": 0.5},
        },
    )
    found = identify(
        simulated_loop(drive, BenchTest(load_friction=0.0)), shaft_twist_rad_per_nm=SHAFT
    )
    assert found.stiffness[0].nm_per_rad.value == pytest.approx(4000.0, rel=2e-3)
    assert found.curve.friction_nm == pytest.approx(1.5, rel=1e-2)


def test_sensor_errors_fill_their_resolution():
    """Readings are off by up to +-0.4 N m, evenly: standard deviation 0.4 / sqrt(3)."""
    error = read(np.zeros(100_000), 0.4, np.random.default_rng(0))
    assert np.abs(error).max() <= 0.4
    assert error.std() == pytest.approx(0.4 / np.sqrt(3.0), rel=0.01)


def test_bad_input_is_one_line_and_exit_2(tmp_path, capsys):
    """Wrong files, columns and flags: exit 2, one line that names what was wrong, no output."""
    half = tmp_path / "half.csv"
    torque = np.linspace(0.0, 50.0, 500)
    half.write_text(
        "torque_nm,angle_rad\n"
        + "".join(f"{t},{LINES.angle_rad(np.array([t]))[0]}\n" for t in torque)
    )
    (tmp_path / "words.csv").write_text("torque_nm,angle_rad\n" + "1,x\n" * 100)
    (tmp_path / "few.csv").write_text("torque_nm,angle_rad\n1,2\n3,4\n")
    out = tmp_path / "o.json"
    for arguments, wanted in (
        (["--loop", str(half)], "no falling edges"),
        (["--loop", str(tmp_path / "words.csv")], "line 2: angle_rad is 'x'"),
        (["--loop", str(tmp_path / "few.csv")], "2 readings"),
        (["--loop", str(tmp_path / "none.csv")], "No such file"),
        (["--loop", str(half), "--torque-column", "T"], "no column T"),
        (["--loop", str(half), "--angle-unit", "furlong"], "furlong"),
        (["--loop", str(half), "--friction", "1"], "--friction"),
        (["--loop", str(half), "--draws", "9"], "--draws"),
        (["--draws", "1"], "--draws"),
        (["--friction", "60"], "friction of 60 N m"),
        (["--torque", "-5"], "torque_limit_nm"),
        (["--readings", "5"], "5 readings"),
        (["--rated-torque", "5000"], "150 N m"),
        (["--write-drive", str(tmp_path / "d.yaml")], "--write-drive needs --drive"),
        (["--drive", "nowhere"], "nowhere"),
    ):
        assert main(["bench", *arguments, "--json", str(out)]) == 2, arguments
        err = capsys.readouterr().err
        assert wanted in err and err.count("\n") == 1, (arguments, err)
        assert not out.exists()


def test_a_loop_that_is_no_loop_is_refused(truth):
    """NaN, a shaft that never turns and one edge only are refused by name."""
    ramp = np.linspace(0.0, 1.0, 2000)
    with pytest.raises(InputError, match="angle_rad never changes"):
        Loop(torque_nm=ramp, angle_rad=np.zeros(2000))
    with pytest.raises(InputError, match="falls as the torque rises"):
        identify(dataclasses.replace(truth, angle_rad=-truth.angle_rad))
    with pytest.raises(InputError, match="torque_nm holds NaN"):
        Loop(torque_nm=np.full(2000, np.nan), angle_rad=ramp)


def test_the_verb_draws_the_loop(tmp_path):
    """--plots writes hysteresis.png, --csv the loop."""
    arguments = ["bench", "--plots", str(tmp_path), "--csv", str(tmp_path / "l.csv")]
    assert main(arguments) == 0
    assert (tmp_path / "hysteresis.png").stat().st_size > 20_000
    assert read_loop(tmp_path / "l.csv")[0].torque_nm.size > 8000
