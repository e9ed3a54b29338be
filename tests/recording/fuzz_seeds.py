"""Good files of every kind that a user hands over: what the fuzzer changes."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import zstandard
from foreign_bags import as_sqlite, foreign_mcap
from mcap.writer import CompressionType
from recording_samples import made
from scipy.io import savemat

from ecyl_ros.drive.drive_file import config_folder, load_drive
from ecyl_ros.drive.reference.leg import Leg
from ecyl_ros.drive.reference.planned import Planned
from ecyl_ros.drive.reference.swing import Swing
from ecyl_ros.recording.csvfile import write_csv
from ecyl_ros.recording.writer import write_recording

KINDS = (
    *("mcap", "sqlite3", "packed", "csv", "tables", "mat", "map", "metadata"),
    *("drive", "motion", "joint", "diagnosis"),
)
_FIELD = Path(__file__).parents[2] / "docs" / "field"

MAP = """schema: ecyl.map/1
stamp: header
joint: cylinder
signals:
  reference_position: {topic: /controller/state, field: reference.positions, unit: mm, scale: 1e3}
  rod_position: {topic: /joint_states, field: position, sign: -1}
  effort: "/joint_states.effort[1]"
"""
COUNTED = """stamp: header
time: {field: t, unit: ms, wrap: 16bit}
signals:
  rotor_position: {field: enc, unit: counts, counts_per_rev: 4096, wrap: 12bit, resolution: 1}
  rod_position: {field: x, unit: counts, counts_per_m: 1e6, wrap: signed 16bit, sign: -1}
  reference_position: {field: q, unit: deg, wrap: rev}
  injected_force: {field: f, unit: N}
"""
# Every key that a map may have and neither of the others has.
REST = """topic: /machine/state
stamp: bag
gap: 0.1
rate: 1000
signals:
  rotor_position: {field: "position[0]", unit: deg, offset: 3, wrap: 360, stamp: header}
  rod_position: {topic: /axis, field: x, joint: rod, unit: mm, resolution: 0.01}
  rod_velocity: {field: v, unit: counts/s, counts_per_m: 1e6}
"""
TIMED = """time: {field: t, unit: ms, scale: 0.5, wrap: 16bit}
signals:
  rotor_velocity: {field: w, unit: rpm, scale: -0.1}
  mode: m
"""
LEARNED = """/**:
  ros__parameters:
    drive: {kind: rigid, output: linear}
    actuation: {signal: voltage, gain: 35.1507}
    load: {mass: 95.109, viscous_friction: 203.50, coulomb_friction: 20.39, constant_load: -3.165}
    controller:
      rate: 1000.0
      position: {kp: 160.18}
      speed: {kp: 243.45}
      command_limit: 10.0
    tolerances: {default: 0.05, load: {mass: exact}}
    effects:
      learned:
        port: load_friction
        of: [position, speed]
        table: {at: [-0.01, 0.0, 0.01], at_2: [0.0, 1e-2], values: [3, 1.5, 3, 0.1, 0.2, -4]}
"""
JOINTS = (
    """<mujoco><compiler angle="degree"/><default><joint damping="1"/></default><worldbody>
<body name="a"><joint name="rod" type="slide" stiffness="9" frictionloss="0.5" axis="0 0 2"/>
<inertial pos="0 0 0.1" mass="4" diaginertia="1 1 1"/>
<body name="c" pos="0 0 1" quat="1 0 0 0"><inertial pos="0 0 0" mass="5" diaginertia="1 2 3"/>
</body></body></worldbody><actuator>
<position name="p" joint="rod" kp="100" kv="10" gear="2" forcerange="-7 7"/></actuator></mujoco>
""",
    """<robot name="r"><link name="base"/><link name="rod"><inertial>
<origin xyz="0 0 0.1" rpy="0 1 0"/>
<mass value="2.5"/><inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0.1" izz="3"/></inertial></link>
<joint name="rod" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
<dynamics damping="0.7" friction="0.2"/><limit effort="9" velocity="3" lower="-1" upper="1"/>
</joint></robot>
""",
)
METADATA = """rosbag2_bagfile_information:
  version: 9
  storage_identifier: mcap
  duration: {nanoseconds: 59000000}
  message_count: 180
  compression_format: ""
  compression_mode: ""
  relative_file_paths:
    - a.mcap
"""


def seeds(folder: Path) -> dict[str, list[bytes]]:
    """Good files of each kind."""
    recording = made(60)
    out: dict[str, list[bytes]] = {kind: [] for kind in KINDS}
    write_recording(recording, folder / "own.mcap")
    out["mcap"].append((folder / "own.mcap").read_bytes())
    variants: list[dict[str, object]] = [
        {"compression": CompressionType.NONE, "use_chunking": False},
        {"compression": CompressionType.NONE, "chunk_size": 4000, "enable_crcs": False},
        {"compression": CompressionType.LZ4, "chunk_size": 4000},
        {"compression": CompressionType.ZSTD, "enable_crcs": False},
    ]
    for i, options in enumerate(variants):
        foreign_mcap(folder / f"{i}.mcap", **options)
        out["mcap"].append((folder / f"{i}.mcap").read_bytes())
    for i, source in enumerate(("own.mcap", "0.mcap")):
        as_sqlite(folder / source, folder / f"{i}.db3")
        out["sqlite3"].append((folder / f"{i}.db3").read_bytes())
    out["packed"] = [zstandard.compress(one) for one in (out["mcap"][0], out["mcap"][1])]
    write_csv(recording, folder / "a.csv")
    out["csv"].append((folder / "a.csv").read_bytes())
    rows = "\n".join(f"{i};{0.001 * i:.4f};{i % 7}".replace(".", ",") for i in range(60))
    out["csv"].append(f"time;pos [mm];note\nms;mm;\n{rows}\n".encode("latin-1"))
    listed = "\n".join(f'S,{20000 * i},"[{i}.0, 0.5]"' for i in range(60))
    out["csv"].append(f"# made\ntype,timestamp,positions\n{listed}\n".encode())
    out["csv"].append(b"\n".join(b"%d %g %g" % (i, 0.1 * i, 2.0) for i in range(60)))
    out["csv"] += [text.encode() for text in _machines()]
    out["tables"] = list(out["csv"])
    time = np.arange(60) * 1e-3
    for options in ({}, {"do_compression": True}, {"format": "4"}):
        tree: dict[str, object] = {"t": time, "q": np.sin(time)[:, None], "kp": 3.0}
        if "format" not in options:
            tree["out"] = {"x": time, "signals": [{"values": np.ones((60, 2))}, {"values": time}]}
            tree["name"] = "drive"
        stream = io.BytesIO()
        savemat(stream, tree, **options)
        out["mat"].append(stream.getvalue())
    profiles = sorted(config_folder().glob("*.yaml"))
    worked = [path for path in sorted(_FIELD.glob("*.yaml")) if not path.name.endswith(".map.yaml")]
    out["drive"] = [*(path.read_bytes() for path in (*profiles, *worked)), LEARNED.encode()]
    legs = (
        Leg(0.004, 0.05, 1.0, 50.0, 0.1),
        Swing(1e-4, 1.0, 8.0, 0.5, 1.0, 0.2),
        Leg(0, 0.05, 1, 50),
    )
    out["motion"] = [Planned(legs, 2.0).as_file({"drive": "bench.yaml"}).encode()]
    out["joint"] = [one.encode() for one in JOINTS]
    out["diagnosis"] = [json.dumps(one, indent=1).encode() for one in _diagnoses()]
    out["map"] = [
        MAP.encode(),
        COUNTED.encode(),
        REST.encode(),
        TIMED.encode(),
        b"time: {field: t, unit: ms}\nsignals: {rod_position: q}\n",
    ]
    out["metadata"] = [METADATA.encode(), METADATA.replace("mcap", "sqlite3").encode()]
    return out


def _diagnoses() -> list[dict[str, object]]:
    """What `ecyl plan --from` goes by, of a diagnosis of profile bench: causes, and none."""
    signals = [{"name": "current_q", "unit": "A"}, {"name": "rod_position", "unit": "m"}]
    cause = {
        "effect": "load_coulomb_friction",
        "confidence": 0.61,
        "parameters": {"coulomb_nm": {"value": 0.02, "ci95": [0.01, 0.03]}},
        "alternatives": ["rotor_coulomb_friction"],
    }
    candidates = [{"effects": [one], "held_out": 2.0} for one in ("backlash_error", "lead_error")]
    common = {"schema": "ecyl.diagnosis/1", "location": {"signals": signals}}
    resistance = load_drive("bench").motor.resistance
    return [
        {
            **common,
            "verdict": "explained",
            "causes": [cause],
            "sheet": [{"parameter": "motor.resistance", "nominal": resistance, "pull": 0.1}],
        },
        {**common, "verdict": "unexplained", "causes": [], "candidates": candidates},
        {
            **common,
            "verdict": "no_gap",
            "causes": [],
            "limits": [{"effect": "lead_error", "smallest_seen": None}],
            "alike": [{"effects": ["backlash_error", "lead_error"], "separation": 0.1}],
        },
    ]


def _machines() -> list[str]:
    """Tables as drives write them: dates, clocks and encoders that wrap, ends that lack."""
    turns = [(37 * i) % 4096 for i in range(60)]
    return [
        "time;motor angle [deg];\n"
        + "".join(f"2024-05-01T12:00:00,{i:03d}Z;{6 * i % 360},5;\n" for i in range(60)),
        "t_ms,encoder_counts,target_rad,iq [mA]\n"
        + "".join(f"{(65500 + i) % 65536},{turns[i]},{0.1 * i:.3f},{i % 7}.5\n" for i in range(60)),
        "# rig 7\n# timestamp, rod_position, i\n# ms, mm, A\n"
        + "".join(f"{1714564800000 + i},{0.01 * i:.4f},{i % 5}\n" for i in range(50))
        + "0,0,0\n" * 10,
        "time,pos [foo]\n" + "".join(f"{1e-3 * i:.3f},{i}.25\n" for i in range(60))[:-4],
    ]
