"""From a setpoint to the first motion, in real time: latency beside the tick and the round trip.

Setpoints are sent at random instants to a drive at rest whose sensors have neither noise nor steps,
so that the first voltage that answers one is seen for sure. It is computed from the measurement of
a tick and acts from the next tick on: then the rod begins to move. Counted from the instant before
the setpoint is published. Runs at the rate that the machine holds, 1 kHz at most.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np
from graph import held_rate, use_private_domain
from listening import Listening
from report import Report, parser

PROFILE = "servo_1khz"
STEP_M = 0.001
SETTLE_S = 1.5  # after a move of STEP_M nothing moves any more
QUIET_S = 0.1  # what the voltage does before a setpoint is taken from so long
OVER_QUIET = 20.0  # an answer changes the voltage by so many times what it changes by at rest
PATIENCE_S = 60.0
EXACT = dict.fromkeys(
    (
        "sensors.rotor_position_noise",
        "sensors.rotor_velocity_noise",
        "sensors.current_noise",
        "sensors.rod_position_noise",
        "sensors.rotor_position_resolution",
        "sensors.rod_position_resolution",
    ),
    0.0,
)
JERK = 1e4  # m/s^3: a voltage that stands out from the first tick on


def collect(rate: float, count: int, seed: int) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Per setpoint: when it was sent (ns), and stamps (ns) and q voltages (V) around it."""
    from geometry_msgs.msg import Vector3Stamped
    from rclpy.qos import QoSProfile
    from std_msgs.msg import Float64

    from ecyl_ros.drive.drive_file import load_drive, resolve_drive
    from ecyl_ros.drive.warm_up import warm_up
    from ecyl_ros.nodes import wire
    from ecyl_ros.nodes.launcher import NodeProcesses, node_parameters, processors
    from ecyl_ros.nodes.scheduling import run_on

    run_on(processors("analyser"))  # as any node beside the drive: not in the way of the plant
    path = resolve_drive(PROFILE)
    warm_up(load_drive(path))
    heard: list[tuple[int, float]] = []
    random = np.random.default_rng(seed)
    sent: list[int] = []

    def on_voltage(message: Vector3Stamped) -> None:
        heard.append((wire.to_ns(message.header.stamp), message.vector.y))

    ears = Listening()
    ears.hear(Vector3Stamped, "/ecyl/control/voltage", on_voltage, qos=QoSProfile(depth=1000))
    setpoint = ears.node.create_publisher(Float64, "/ecyl/setpoint", 10)
    ears.begin()
    names = ("analyser", "reference", "controller", "plant")
    with tempfile.TemporaryDirectory(prefix="ecyl_bench_") as folder:
        parameters = node_parameters(
            "setpoint",
            Path(folder, "run.mcap"),
            Path(folder, "summary.json"),
            duration_s=None,
            realtime=True,
            recorder=False,
            rate=rate,
        )
        own = EXACT | {"limits.jerk": JERK}
        parameters = {name: parameters[name] | own for name in names}
        with NodeProcesses(path, parameters, nodes=names, realtime=True):
            end = time.monotonic() + PATIENCE_S
            while not (heard and setpoint.get_subscription_count()) and time.monotonic() < end:
                time.sleep(0.05)
            if not heard:
                raise SystemExit("first_motion: the graph has not begun")
            for number in range(count):
                time.sleep(SETTLE_S + random.uniform(0.0, 0.1))
                sent.append(time.time_ns())
                setpoint.publish(Float64(data=STEP_M * ((number + 1) % 2)))
            time.sleep(SETTLE_S)
    ears.close()
    stamps, volts = np.array([stamp for stamp, _ in heard]), np.array([volt for _, volt in heard])
    out = []
    for at in sent:
        around = (stamps > at - QUIET_S * 1e9) & (stamps < at + 1e9 * SETTLE_S / 2)
        out.append((at, stamps[around], volts[around]))
    return out


def latency_s(at_ns: int, stamps_ns: np.ndarray, volts: np.ndarray, rate: float) -> float | None:
    """From a setpoint until its first voltage acts, s; None where no answer stands out."""
    changes = np.abs(np.diff(volts))
    before = changes[stamps_ns[1:] <= at_ns]
    if len(before) < QUIET_S * rate / 4:
        return None
    answers = np.flatnonzero(
        (stamps_ns[1:] > at_ns - 1e9 / rate) & (changes > OVER_QUIET * before.max() + 1e-9)
    )
    if not len(answers):
        return None
    return float(stamps_ns[1:][answers[0]] - at_ns) * 1e-9 + 1.0 / rate


def main() -> None:
    """Measure the round trip, then the latency."""
    made = parser(__doc__)
    made.add_argument("--setpoints", type=int, default=60, help="(default 60)")
    made.add_argument("--rate", type=float, help="Hz (default: what holds, 1000 at most)")
    made.add_argument("--seed", type=int, default=1, help="of the instants (default 1)")
    options = made.parse_args()
    use_private_domain()
    report = Report(f"setpoint to first motion, {options.setpoints} setpoints")
    rate, p99_s = held_rate(report, options.rate)
    found = [latency_s(*one, rate) for one in collect(rate, options.setpoints, options.seed)]
    seen = np.array([one for one in found if one is not None])
    if not len(seen):
        raise SystemExit("first_motion: no setpoint was answered")
    tick_s = 1.0 / rate
    bound_s = 2.0 * tick_s + p99_s
    quantiles = [float(np.quantile(seen, q)) for q in (0.0, 0.5, 0.9, 1.0)]
    report.say(f"  two ticks and one round trip: {1e3 * bound_s:.2f} ms")
    report.table(
        ["", "least", "median", "90 %", "most"],
        [
            ["latency, ms", *(f"{1e3 * q:.2f}" for q in quantiles)],
            ["in ticks", *(f"{q / tick_s:.2f}" for q in quantiles)],
        ],
    )
    share = 100.0 * float(np.mean(seen <= bound_s))
    report.target("within_percent", share, ".1f", "100", f"within that, % of {len(seen)}")
    report.say(f"  without an answer that stands out: {len(found) - len(seen)}")
    report.figures |= {"latency_s": seen.tolist()}
    report.finish(options.json)


if __name__ == "__main__":
    main()
