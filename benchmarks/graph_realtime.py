"""The graph in real time: ticks met, late and stale, and its jitter beside bare sleeping.

It runs at the rate that the machine holds by its round trips, 1 kHz at most. Jitter is the time
from a tick's instant to the wake-up that serves it. What the machine itself does is shown beside
it: five processes that sleep to absolute deadlines of that rate and do nothing else, for as long,
right after.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from graph import held_rate, run_graph, use_private_domain
from report import ROOT, Report, parser
from sleepers import EDGES_S, five_at_once

BAR = 30  # characters of the longest bar
QUANTILES = ("p50", "p99", "p999", "max")


def _microseconds(seconds: float) -> str:
    return f"{1e6 * seconds:.0f}"


def _counts(figures: dict) -> np.ndarray:
    return np.array(figures["jitter_histogram"]["counts"])


def histogram(report: Report, graph: dict, sleepers: list[dict]) -> None:
    """Both histograms side by side, on a logarithmic axis, as shares of all wake-ups."""
    shares = [_counts(graph), np.sum([one["counts"] for one in sleepers], axis=0)]
    shares = [counts / max(counts.sum(), 1) for counts in shares]
    top = max(share.max() for share in shares)
    used = np.flatnonzero(shares[0] + shares[1])
    rows = []
    for bin_ in range(used[0], used[-1] + 1):
        cells = [f"below {1e6 * EDGES_S[bin_ + 1]:8.0f} us"]
        if np.isinf(EDGES_S[bin_ + 1]):
            cells = ["longer"]
        for share in shares:
            bar = "#" * round(BAR * share[bin_] / top) or ("." if share[bin_] else "")
            cells.append(f"{100 * share[bin_]:7.3f} % {bar:<{BAR}}")
        rows.append(cells)
    empty = "".ljust(BAR)
    report.table(["jitter", f"graph{empty}", f"five bare loops{empty[10:]}"], rows)


def picture(path: Path, graph: dict, sleepers: list[dict], rate: float) -> None:
    """The same as a PNG; without the bare loops where there are none. rate: Hz."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    edges = 1e6 * np.append(EDGES_S[1:-1], 2 * EDGES_S[-2])
    drawn = [(_counts(graph), "graph")]
    if sleepers:
        drawn.append((np.sum([one["counts"] for one in sleepers], axis=0), "five bare loops"))
    for counts, label in drawn:
        merged = np.append(counts[0] + counts[1], counts[2:])  # the first bin begins at 0
        axes.stairs(merged / counts.sum(), edges, label=label, fill=True, alpha=0.5)
    axes.axvline(1e6 / rate, color="black", linewidth=0.8, linestyle="--", label="one period")
    axes.set(xscale="log", yscale="log", xlabel="jitter / us", ylabel="share of wake-ups")
    axes.set_title(f"{rate:g} Hz real time")
    axes.legend()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=120)
    plt.close(figure)


def main() -> None:
    """Run both, one after the other, and show them beside each other."""
    made = parser(__doc__)
    made.add_argument("--seconds", type=float, default=60.0, help="of each part (default 60)")
    made.add_argument(
        "--png",
        type=Path,
        default=ROOT / "out/jitter.png",
        help="histogram to draw (default out/jitter.png)",
    )
    made.add_argument("--rate", type=float, help="Hz (default: what holds, 1000 at most)")
    options = made.parse_args()
    use_private_domain()
    report = Report(f"graph in real time, {options.seconds:g} s")
    rate, _ = held_rate(report, options.rate)
    graph = run_graph("servo_1khz", options.seconds, realtime=True, rate=rate)
    sleepers = five_at_once(options.seconds, rate)

    report.target("met_percent", 100 * graph["met_share"], ".3f", "99.5 or more", "ticks met, %")
    report.say(
        f"  of {graph['ticks']} ticks {graph['late_ticks']} late (woken a period or more behind), "
        f"{graph['stale_ticks']} stale (command not there)"
    )
    bare_late = float(np.mean([one["late_share"] for one in sleepers]))
    report.say(f"  bare loops on time: {100 * (1 - bare_late):.3f} %\n")
    rows = [["graph", *(_microseconds(graph[f"jitter_{name}_s"]) for name in QUANTILES)]]
    rows += [
        [f"bare loop {i}", *(_microseconds(one[f"jitter_{name}_s"]) for name in QUANTILES)]
        for i, one in enumerate(sleepers, start=1)
    ]
    report.table(["jitter, us", *QUANTILES], rows)
    histogram(report, graph, sleepers)
    picture(options.png, graph, sleepers, rate)
    report.say(f"picture in {options.png}")
    report.figures |= {"graph": graph, "bare_loops": sleepers, "bare_late_share": bare_late}
    report.finish(options.json)


if __name__ == "__main__":
    main()
