"""Whether DDS stays on this machine: every frame on every interface while a graph runs.

Captured as tcpdump would (AF_PACKET, which needs root or CAP_NET_RAW): RTPS, the wire format of
DDS, is told by the first four bytes of a UDP datagram, a graph's by its ports. Without that right
the kernel's own counters of each interface are compared over a span without the graph and a span
with it, which other traffic blurs.
"""

from __future__ import annotations

import select
import socket
import struct
import threading
import time
from collections import Counter
from pathlib import Path

from graph import run_graph, use_private_domain
from report import Report, parser

ETH_P_ALL, ETH_P_IP, ETH_P_IPV6, UDP = 0x0003, 0x0800, 0x86DD, 17
RTPS = b"RTPS"
FIRST_PORT, PORTS = 7400, 250  # of domain 0, and how many each has
LOOPBACK = "lo"


def rtps(frame: bytes, domain: int) -> bool:
    """Whether an Ethernet frame holds a UDP datagram with an RTPS message of a domain."""
    if len(frame) < 14:
        return False
    (kind,) = struct.unpack_from("!H", frame, 12)
    if kind == ETH_P_IP and len(frame) > 34 and frame[23] == UDP:
        start = 14 + 4 * (frame[14] & 0x0F) + 8
    elif kind == ETH_P_IPV6 and len(frame) > 62 and frame[20] == UDP:
        start = 14 + 40 + 8
    else:
        return False
    (port,) = struct.unpack_from("!H", frame, start - 6)
    return frame[start : start + 4] == RTPS and (port - FIRST_PORT) // PORTS == domain


class Capture:
    """Counts frames, and those of DDS, by interface; use as a context manager."""

    def __init__(self, domain: int) -> None:
        self._domain = domain
        self.frames: Counter[str] = Counter()
        self.dds: Counter[str] = Counter()
        self._socket = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETH_P_ALL))
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 24)
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._take, daemon=True)

    def _take(self) -> None:
        while not self._over.is_set():
            if not select.select([self._socket], [], [], 0.1)[0]:
                continue
            frame, (interface, *_) = self._socket.recvfrom(2048)
            self.frames[interface] += 1
            self.dds[interface] += rtps(frame, self._domain)

    def __enter__(self) -> Capture:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()
        self._socket.close()


def sent_bytes() -> dict[str, int]:
    """What each interface has sent since it is up."""
    lines = Path("/proc/net/dev").read_text().splitlines()[2:]
    pairs = (line.split(":", 1) for line in lines)
    return {name.strip(): int(counts.split()[8]) for name, counts in pairs}


def captured(report: Report, duration_s: float, domain: int) -> None:
    """A run under capture."""
    with Capture(domain) as capture:
        run_graph("servo_1khz", duration_s)
    names = sorted(set(sent_bytes()) | set(capture.frames))
    rows = [[name, str(capture.frames[name]), str(capture.dds[name])] for name in names]
    report.table(["interface", "frames", "of this graph"], rows)
    away = sum(count for name, count in capture.dds.items() if name != LOOPBACK)
    report.target("dds_away", away, "d", "0", "frames of DDS on other interfaces than loopback")
    report.target("dds_loopback", capture.dds[LOOPBACK], "d", "more than 0", "on loopback")


def counted(report: Report, duration_s: float) -> None:
    """The kernel's counters without the graph and with it."""
    rows: dict[str, list[str]] = {}
    for run in (False, True):
        begin, before = time.monotonic(), sent_bytes()
        if run:
            run_graph("servo_1khz", duration_s)
        else:
            time.sleep(duration_s)
        took = time.monotonic() - begin
        for name, count in sent_bytes().items():
            rows.setdefault(name, [name]).append(f"{(count - before.get(name, 0)) / took:.0f}")
    report.table(["interface", "bytes/s sent without", "with the graph"], list(rows.values()))


def main() -> None:
    """Capture, or count where the kernel lets nobody capture."""
    made = parser(__doc__)
    made.add_argument("--seconds", type=float, default=10.0, help="simulated (default 10)")
    options = made.parse_args()
    domain = use_private_domain()
    report = Report("DDS on the network")
    try:
        captured(report, options.seconds, domain)
    except PermissionError:
        report.say("  no right to capture: the interfaces' counters instead")
        counted(report, options.seconds)
    report.finish(options.json)


if __name__ == "__main__":
    main()
