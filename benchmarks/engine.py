"""The engine's speed: against scipy's Radau on the same closed loop, and beside other simulators.

Profile `paper` on the paper's sine, 10 s at 100 kHz. The accuracy of both is measured against a
Radau solution with tolerances four decades finer.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from continuous_loop import LOAD_ANGLE, STATES, closed_loop
from report import ROOT, Report, parser, wall_time_s
from scipy.integrate import solve_ivp

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import Simulation, simulate
from ecyl_ros.drive.packed import choose_substeps
from ecyl_ros.drive.reference.sine import Sine

DURATION_S = 10.0
RTOL, ATOL = 1e-6, 1e-11  # rad, rad/s, A: a looser ATOL leaves Radau behind the engine's accuracy
FINE_RTOL, FINE_ATOL = 1e-10, 1e-12
PEER_SECONDS = {"motulator": 0.05, "gym-electric-motor": 0.25}
PEER_DIFFERENCES = {
    "motulator": "two masses on a spring, no backlash; RK45 between steps; its own current-vector "
    "control with a speed loop",
    "gym-electric-motor": "one rigid inertia; dopri5 between steps; speed and dq current PI loops "
    "in Python",
}

DRIVE = load_drive("paper")
SINE = Sine(amplitude=2e-5, frequency=1.0)


class PeerError(Exception):
    """Another simulator did not run; the message says why."""


def engine_run(substeps: int | None = None, duration_s: float = DURATION_S) -> Simulation:
    """The engine on the paper's sine."""
    return simulate(
        DRIVE, lambda i: SINE.sample(i / DRIVE.sample_rate), duration_s, substeps=substeps
    )


def radau_run(slopes: Callable, times_s: np.ndarray, rtol: float, atol: float) -> np.ndarray:
    """Rod position m at `times_s`, by scipy's Radau."""
    solution = solve_ivp(
        slopes,
        (0.0, DURATION_S),
        np.zeros(STATES),
        method="Radau",
        t_eval=times_s,
        rtol=rtol,
        atol=atol,
    )
    return solution.y[LOAD_ANGLE] * DRIVE.transmission.rod_per_rotor


def against_radau(report: Report, runs: int) -> float:
    """Print both errors and the ratio of wall times; returns the engine's wall time, s."""
    slopes = closed_loop(DRIVE, SINE)
    engine_run(duration_s=0.01)  # compile, or load from cache
    times_s = engine_run().time_s
    fine = radau_run(slopes, times_s, FINE_RTOL, FINE_ATOL)
    radau = radau_run(slopes, times_s, RTOL, ATOL)
    engine = engine_run().signal("rod_position_m")
    finer_steps = engine_run(8 * choose_substeps(DRIVE)).signal("rod_position_m")
    error = {
        "radau_error_m": float(np.abs(radau - fine).max()),
        "engine_error_m": float(np.abs(engine - fine).max()),
        "engine_integration_error_m": float(np.abs(engine - finer_steps).max()),
    }
    engine_s, radau_s = [], []
    for _ in range(runs):  # by turns, so that other work on the machine meets both
        engine_s += [wall_time_s(engine_run) for _ in range(3)]
        radau_s.append(wall_time_s(lambda: radau_run(slopes, times_s, RTOL, ATOL)))
    wall_engine, wall_radau = statistics.median(engine_s), statistics.median(radau_s)
    report.say(
        f"{DURATION_S:g} s of profile paper, median of {runs} runs (engine: {3 * runs}); error: "
        f"largest of the rod position against\nRadau with rtol {FINE_RTOL:g}, atol {FINE_ATOL:g}."
    )
    report.table(
        ["", "wall s", "error m"],
        [
            ["engine, 100 kHz", f"{wall_engine:.3f}", f"{error['engine_error_m']:.1e}"],
            [
                f"Radau, rtol {RTOL:g}, atol {ATOL:g}",
                f"{wall_radau:.3f}",
                f"{error['radau_error_m']:.1e}",
            ],
        ],
    )
    report.say(
        "  The engine's error is that of sampling the cascade, which a drive does too; its "
        "integration alone\n  (against eight times finer steps) errs by "
        f"{error['engine_integration_error_m']:.1e} m. atol is chosen so that Radau comes near the "
        "engine."
    )
    report.target(
        "engine_over_radau", wall_engine / wall_radau, ".4f", "1/20 = 0.05 or less", "engine/Radau"
    )
    report.figures |= error | {"engine_wall_s": wall_engine, "radau_wall_s": wall_radau}
    return wall_engine


def peer_wall_s(python: Path, name: str) -> float:
    """Wall time of one peer's run, s; raises PeerError saying why there was none."""
    motor, transmission = DRIVE.motor, DRIVE.transmission
    parameters = {
        "pole_pairs": motor.pole_pairs,
        "resistance": motor.resistance,
        "inductance": motor.inductance,
        "torque_constant": motor.torque_constant,
        "rotor_inertia": motor.rotor_inertia,
        "load_inertia": DRIVE.load.inertia,
        "stiffness": transmission.stiffness[0],
        "step_s": 1.0 / DRIVE.controller.rate,
    }
    command = [str(python), str(Path(__file__).with_name("peers.py")), name]
    command += [str(PEER_SECONDS[name]), json.dumps(parameters)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise PeerError((done.stderr.strip().splitlines() or ["no output"])[-1])
    return json.loads(done.stdout.splitlines()[-1])["wall_s"]


def beside_peers(report: Report, python: Path, engine_wall_s: float, runs: int) -> None:
    """Simulated seconds per wall second of the engine and of other simulators, the same step."""
    engine_rate = DURATION_S / engine_wall_s
    report.say("")
    report.say(f"Beside other simulators at the same step, {1e6 / DRIVE.controller.rate:g} us:")
    rows = [["ecyl engine", f"{engine_rate:.3g}", f"{engine_rate * DRIVE.controller.rate:.3g}", ""]]
    missing, peers = {}, {}
    for name, seconds in PEER_SECONDS.items():
        try:
            rate = seconds / statistics.median(peer_wall_s(python, name) for _ in range(runs))
        except PeerError as error:
            missing[name] = str(error)
            continue
        steps = rate * DRIVE.controller.rate
        rows.append([name, f"{rate:.3g}", f"{steps:.3g}", f"{engine_rate / rate:.0f}"])
        peers[name] = {"simulated_s_per_s": rate, "engine_times_faster": engine_rate / rate}
    report.table(["", "simulated s per s", "steps per s", "engine is faster by"], rows)
    for name in PEER_SECONDS:
        reason = missing.get(name)
        report.say(f"  {name}: {f'not run: {reason}' if reason else PEER_DIFFERENCES[name]}")
    report.figures["peers"] = peers


def _options() -> argparse.Namespace:
    made = parser(__doc__)
    made.add_argument("--runs", type=int, default=5, help="of each, the median counts (default 5)")
    made.add_argument(
        "--peers-python",
        type=Path,
        default=ROOT / ".venv-bench/bin/python",
        metavar="PYTHON",
        help="interpreter that has benchmarks/requirements.txt (default .venv-bench's)",
    )
    return made.parse_args()


def main() -> None:
    """Print both comparisons."""
    options = _options()
    report = Report("speed of the engine")
    engine_wall_s = against_radau(report, options.runs)
    if options.peers_python.exists():
        beside_peers(report, options.peers_python, engine_wall_s, min(options.runs, 3))
    else:
        print(f"no other simulators: {options.peers_python} is missing", file=sys.stderr)
    report.finish(options.json)


if __name__ == "__main__":
    main()
