"""Order of the plant's integrator, and what the automatic sub-steps leave on the table.

(a) Error against the exact solution of the piecewise-linear plant (matrix exponentials between
contacts, from the tests), over the step. (b) What halving the step changes in each profile.
"""

from __future__ import annotations

import dataclasses
import sys

import numpy as np
from report import ROOT, Report, parser

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import Simulation, simulate
from ecyl_ros.drive.packed import choose_substeps, pack
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.plant import initial_state, plant_step
from ecyl_ros.drive.reference.sine import Sine

sys.path.insert(0, str(ROOT))  # the exact solution is part of the tests
from tests.drive.exact_solution import ExactPlant

DURATION_S = 0.02
VOLTAGE_V = 5.0
SCALE = np.array([1.0, 100.0, 1.0, 100.0, 10.0])  # rad, rad/s, rad, rad/s, A
CONTACT_START = np.array([0.0, 12.0, 0.002, -9.0, 3.0])  # the flanks meet at speed, many times
FREE_START = np.array([0.0, 2.0, 0.002, -1.0, 3.0])

SINES = {
    "paper": Sine(amplitude=2e-5, frequency=1.0),
    "si": Sine(amplitude=2e-5, frequency=1.0),
    "bench": Sine(amplitude=5e-3, frequency=1.0),
    "servo_1khz": Sine(amplitude=5e-3, frequency=1.0),
}
CHAOTIC = "si"


@dataclasses.dataclass(frozen=True)
class Case:
    """A plant, where it starts, and how many steps the table walks through."""

    backlash: float | None = None  # the bench drive's unless given
    damping: float = 0.0
    stiffness: tuple[float, ...] = (6498.0,)
    breaks: tuple[float, ...] = ()
    start: np.ndarray = dataclasses.field(default_factory=lambda: CONTACT_START)
    steps: tuple[int, ...] = (500, 1000, 2000, 4000, 8000)

    def drive(self) -> DriveParameters:
        """The bench drive with this transmission, one control tick as long as the run."""
        bench = load_drive("bench")
        transmission = dataclasses.replace(
            bench.transmission,
            backlash=bench.transmission.backlash if self.backlash is None else self.backlash,
            contact_damping=self.damping,
            stiffness=self.stiffness,
            stiffness_breaks=self.breaks,
        )
        controller = dataclasses.replace(bench.controller, rate=1.0 / DURATION_S)
        return dataclasses.replace(bench, transmission=transmission, controller=controller)


CASES = {
    "no contact": Case(backlash=10.0, start=FREE_START, steps=(10, 20, 40, 80, 160)),
    "contacts, damped": Case(damping=0.15),
    "contacts, undamped": Case(),
    "contacts, two segments": Case(damping=0.05, stiffness=(3000.0, 9000.0), breaks=(4.0,)),
}


def stepped(case: Case, steps: int) -> np.ndarray:
    """The compiled plant's state at the end, in `steps` steps."""
    params = pack(case.drive(), substeps=steps)
    params["pole_pairs"] = 0.0  # no cross-coupling: the exact solution needs a linear plant
    state = initial_state()
    state[[0, 1, 2, 3, 5]] = case.start
    plant_step(state, 0.0, VOLTAGE_V, params)
    return state[[0, 1, 2, 3, 5]]


def order(report: Report) -> None:
    """Part (a): error over step, and the slope of a line through it."""
    report.say(
        f"Plant step against the exact solution after {1e3 * DURATION_S:g} ms with "
        f"{VOLTAGE_V:g} V held: largest error of the\nstate over "
        "(1 rad, 100 rad/s, 1 rad, 100 rad/s, 10 A)."
    )
    rows, slopes = [], {}
    for name, case in CASES.items():
        exact, changes = ExactPlant(case.drive()).advance(case.start, VOLTAGE_V, DURATION_S)
        steps = np.array(case.steps)
        errors = [float(np.abs((stepped(case, n) - exact) / SCALE).max()) for n in steps]
        slopes[name] = float(np.polyfit(np.log(1.0 / steps), np.log(errors), 1)[0])
        pairs = zip(steps, errors, strict=True)
        cells = [f"{1e6 * DURATION_S / n:g} us: {error:.1e}" for n, error in pairs]
        rows.append([name, str(changes), *cells, f"{slopes[name]:.2f}"])
    header = ["case", "mode changes", *["step: error"] * len(CASES["no contact"].steps), "slope"]
    report.table(header, rows)
    report.figures["slopes"] = slopes


def quiet(drive: DriveParameters) -> DriveParameters:
    """The drive with perfect sensors, so that only the step differs between two runs."""
    return dataclasses.replace(drive, sensors=type(drive.sensors)())


def run(name: str, substeps: int, duration_s: float) -> Simulation:
    """Profile `name` on its sine, with perfect sensors."""
    drive = quiet(load_drive(name))
    reference = SINES[name]
    return simulate(
        drive, lambda i: reference.sample(i / drive.sample_rate), duration_s, substeps=substeps
    )


def error_std_m(simulation: Simulation, skip_s: float) -> float:
    """Standard deviation of the tracking error at the rod after `skip_s`, m."""
    error = simulation.samples[:, 0] - simulation.signal("rod_position_m")
    return float(np.std(error[simulation.time_s >= skip_s]))


def _noise(std: float) -> str:
    return f"{std:.1e}" if std else "none"


def halving(report: Report) -> None:
    """Part (b): traces of a 2 s run; for the chaotic profile the statistics of a long one."""
    report.say("Automatic sub-steps against twice as many, 2 s of sine, perfect sensors.")
    rows, figures = [], {}
    for name in SINES:
        drive = load_drive(name)
        count = choose_substeps(drive)
        cells = [name, f"{drive.controller.rate:g} Hz x {count}"]
        if name == CHAOTIC:
            rows.append([*cells, "chaotic: below", "", "", ""])
            continue
        one, two = (run(name, n, 2.0) for n in (count, 2 * count))
        for signal, std in (
            ("rod_position_m", drive.sensors.rod_position_noise),
            ("current_q_a", drive.sensors.current_noise),
        ):
            difference = float(np.abs(one.signal(signal) - two.signal(signal)).max())
            figures[f"{name}.{signal}"] = difference
            cells += [f"{difference:.1e}", _noise(std)]
        rows.append(cells)
    header = ["profile", "steps", "rod, largest m", "its noise m", "i_q, largest A", "its noise A"]
    report.table(header, rows)

    report.say(
        f"Profile {CHAOTIC} is chaotic without contact damping: neighbouring traces part, so the "
        "standard deviation\nof the tracking error is compared (20 s run, last 10 s)."
    )
    count = choose_substeps(load_drive(CHAOTIC))
    deviations = {
        n: error_std_m(run(CHAOTIC, n, 20.0), 10.0) for n in (count, 2 * count, 4 * count)
    }
    report.table(
        ["sub-steps", "error std mm"],
        [[str(n), f"{1e3 * std:.5f}"] for n, std in deviations.items()],
    )
    report.figures["halving"] = figures
    report.figures["chaotic_error_std_m"] = {str(n): std for n, std in deviations.items()}


def main() -> None:
    """Print both parts."""
    options = parser(__doc__).parse_args()
    report = Report("convergence of the plant's integrator")
    order(report)
    halving(report)
    report.finish(options.json)


if __name__ == "__main__":
    main()
