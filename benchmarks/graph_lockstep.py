"""Ticks a second of the lockstep graph, across processes and in one, beside what it stands on.

A tick across processes is a round trip: a measurement from the plant, a voltage back. Measured by
turns in the same run: a bare Float64 ping-pong of two ordinary rclpy nodes, on whichever rclpy
there is, and, where the `cyclonedds` package is installed, the transport's own round trips: as the
kernel places the two processes, and on one processor, as the launcher places plant and controller.
"""

from __future__ import annotations

import os
import statistics

from graph import run_graph, use_private_domain
from ping_pong import measured
from report import Report, parser

try:
    from transport import trips_per_s
except ModuleNotFoundError:  # genuine ROS 2 alone
    trips_per_s = None


def ping_pong(report: Report, turns: int, duration_s: float) -> None:
    """The graph in five processes and in one beside the ping-pong, by turns."""
    rows, ratios = [], []
    for turn in range(1, turns + 1):
        bare = measured(3.0)
        five = run_graph("bench", duration_s)["ticks_per_s"]
        one = run_graph("bench", duration_s, in_process=True)["ticks_per_s"]
        trips = bare["trips_per_s"]
        ratios.append((five / trips, one / trips))
        p99 = f"{1e6 * bare['p99_s']:.0f}"
        rows.append([str(turn), f"{trips:.0f}", p99, f"{five:.0f}", f"{one:.0f}"])
    report.say("Bare Float64 ping-pong of two rclpy nodes; the graph of profile bench.")
    report.table(["turn", "trips/s", "p99 us", "five processes ticks/s", "one process"], rows)
    for name, target, column in (("five_processes", "0.6", 0), ("one_process", "0.9", 1)):
        report.target(
            f"{name}_over_ping_pong",
            statistics.median(ratio[column] for ratio in ratios),
            ".2f",
            f"{target} or more",
            f"ticks per bare round trip, {name.replace('_', ' ')}",
        )


def trips_per_s_on_one_processor(seconds: float, domain: int) -> float:
    """Round trips a second where both processes have to share a processor."""
    usable = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(usable)})
    try:
        return trips_per_s(seconds, domain)
    finally:
        os.sched_setaffinity(0, usable)


def across_processes(report: Report, domain: int, turns: int, duration_s: float) -> None:
    """The transport and the graph over it, by turns."""
    rows, trips, trips_of_three, trips_on_one, ticks = [], [], [], [], []
    for turn in range(1, turns + 1):
        trips.append(trips_per_s(3.0, domain))
        trips_of_three.append(trips_per_s(3.0, domain, outward=2))
        trips_on_one.append(trips_per_s_on_one_processor(3.0, domain))
        ticks.append(run_graph("bench", duration_s)["ticks_per_s"])
        columns = (trips, trips_of_three, trips_on_one, ticks)
        rows.append([str(turn), *(f"{x[-1]:.0f}" for x in columns)])
    medians = [statistics.median(x) for x in columns]
    report.say(
        "Two processes, JointState as ready CDR bytes, blocking in a wait set; and the graph of "
        "profile bench as\nfive processes (plant, controller, reference, analyser, recorder)."
    )
    report.table(
        ["turn", "transport trips/s", "same, 2 out 1 back", "same, one processor", "graph ticks/s"],
        [*rows, ["median", *(f"{value:.0f}" for value in medians)]],
    )
    ratios = [tick / trip for tick, trip in zip(ticks, trips, strict=True)]
    report.target(
        "graph_over_transport", statistics.median(ratios), ".2f", "0.7 or more", "ticks per trip"
    )
    shares = [tick / trip for tick, trip in zip(ticks, trips_on_one, strict=True)]
    report.say(f"  beside the transport on one processor: {statistics.median(shares):.2f}")
    report.figures |= {
        "transport_trips_per_s": trips,
        "transport_trips_two_out_per_s": trips_of_three,
        "transport_trips_on_one_processor_per_s": trips_on_one,
        "graph_ticks_per_s": ticks,
    }


def in_one_process(report: Report, turns: int, duration_s: float) -> None:
    """All nodes on one executor."""
    report.say("\nOne process, one executor:")
    for recorder in (True, False):
        rates = [
            run_graph("bench", duration_s, in_process=True, recorder=recorder)["ticks_per_s"]
            for _ in range(turns)
        ]
        name = "with recorder" if recorder else "without recorder"
        report.figures[f"in_process_{name.replace(' ', '_')}_ticks_per_s"] = rates
        report.target(
            f"in_process_{name.replace(' ', '_')}",
            statistics.median(rates),
            ".0f",
            "25 000 or more",
            f"ticks/s {name}, median of {turns}",
        )


def main() -> None:
    """Print all parts."""
    made = parser(__doc__)
    made.add_argument("--turns", type=int, default=3, help="the median counts (default 3)")
    made.add_argument(
        "--seconds", type=float, default=2.0, help="simulated, of each run at 10 kHz (default 2)"
    )
    options = made.parse_args()
    domain = use_private_domain()
    report = Report("lockstep graph")
    ping_pong(report, options.turns, options.seconds)
    if trips_per_s is not None:
        across_processes(report, domain, options.turns, options.seconds)
        in_one_process(report, options.turns, options.seconds)
    report.finish(options.json)


if __name__ == "__main__":
    main()
