"""Files of every kind that is read, changed at random, and what a reader may make of them."""

from __future__ import annotations

import io
import json
import re
import signal
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import numpy as np
import zstandard
from foreign_bags import as_sqlite, foreign_mcap, write_sqlite
from mcap.writer import CompressionType, Writer
from recording_samples import made
from scipy.io import savemat

from ecyl_ros.drive.drive_file import config_folder, load_drive
from ecyl_ros.drive.model_file import load_model
from ecyl_ros.drive.reference.planned import Leg, Planned
from ecyl_ros.drive.reference.spec import make_reference
from ecyl_ros.drive.rigid.machine_file import machine_from_flat
from ecyl_ros.errors import InputError
from ecyl_ros.export.joint_values import parameters, read_joint, rigid_file
from ecyl_ros.investigate.question import question
from ecyl_ros.plan.diagnosis_file import read_diagnosis
from ecyl_ros.plan.hypotheses import given, open_or_alike
from ecyl_ros.recording.bag import read_bag
from ecyl_ros.recording.bag_contents import in_time_order
from ecyl_ros.recording.check import check_map
from ecyl_ros.recording.csvfile import write_csv
from ecyl_ros.recording.load import load_recording
from ecyl_ros.recording.map import SignalMap
from ecyl_ros.recording.map_file import load_map, parse_map
from ecyl_ros.recording.mapped import read_mapped
from ecyl_ros.recording.propose import propose
from ecyl_ros.recording.survey import survey
from ecyl_ros.recording.writer import write_recording

KINDS = (
    *("mcap", "sqlite3", "packed", "csv", "tables", "mat", "map", "metadata"),
    *("drive", "motion", "joint", "diagnosis"),
)
_TEXTS = ("csv", "tables", "drive", "map", "metadata", "motion", "joint", "diagnosis")
_FIELD = Path(__file__).parents[2] / "docs" / "field"
SLOWEST_S = 10.0


class Hang(BaseException):
    """A reader took longer than `SLOWEST_S`; no `except Exception` may swallow it."""


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
    legs = (Leg(0.004, 0.05, 1.0, 50.0, 0.1), Leg(-0.002, 0.02, 0.5, 50.0), Leg(0.0, 0.05, 1, 50))
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


WORDS = (
    *(b"counts", b"16bit", b"signed 16bit", b"rev", b"4096", b"counts_per_rev", b"wrap", b"[foo]"),
    *(b"2024-05-01T12:00:00Z", b"9999-12-31 00:00", b"iso8601", b"//", b"#", b"[deg]", b"(s)"),
    *(b"nan", b"1e999", b"-1", b"0", b'"', b"[", b"]", b"{", b"}", b"*a", b"&a ", b"\n", b","),
    *(b";", b"9999999999999999999", b"!!python/object:x", b"0x1", b": ", b"\t", b"~", b"true"),
    *(b"", b" ", b"mm", b"rad", b"header", b"bag", b"'", b"\xc2\xb5", b"|", b"- ", b"?", b"%"),
)


def mutated(kind: str, data: bytes, others: list[bytes], random: np.random.Generator) -> bytes:
    """A good file of a kind, changed at random.

    Text is changed by words as often as by bytes. Of bags every other one is changed in a message,
    a definition or a name and put together again, so that no checksum gives it away.
    """
    if kind == "packed" and random.random() < 0.5:  # what is in the frame, not the frame
        return zstandard.compress(mutated("mcap", zstandard.decompress(data), [data], random))
    if kind in _TEXTS and random.random() < 0.7:
        return _reworded(data, random)
    if kind in ("mcap", "sqlite3") and random.random() < 0.5:
        return _remade(kind, data, random)
    out = data
    for _ in range(int(random.integers(1, 4))):
        out = _changed(out, others, random)
    return out


def _changed(data: bytes, others: list[bytes], random: np.random.Generator) -> bytes:
    """One change: bytes, extremes, cuts, repeats, pieces of other files."""
    out = bytearray(data)
    size = max(len(out), 1)
    at = int(random.integers(0, size))
    run = max(int(min(random.geometric(0.1), size - at)), 1)
    how = int(random.integers(0, 8))
    if how == 0:
        out[at : at + 1] = bytes([int(random.integers(0, 256))])
    elif how == 1:
        extreme = (b"\xff" * 8, b"\0" * 8, b"\x7f" + b"\xff" * 7, b"\xff\xff\xff\x7f")
        chosen = extreme[int(random.integers(0, len(extreme)))]
        out[at : at + len(chosen)] = chosen
    elif how == 2:
        del out[at : at + run]
    elif how == 3:
        out[at:at] = random.integers(0, 256, run, dtype=np.uint8).tobytes()
    elif how == 4:
        out[at:at] = bytes(out[at : at + 10 * run])
    elif how == 5:
        other = others[int(random.integers(0, len(others)))]
        place = int(random.integers(0, max(len(other), 1)))
        out[at : at + run] = other[place : place + run]
    elif how == 6 and random.random() < 0.2:
        del out[at:]
    elif out:
        out[at] ^= 1 << int(random.integers(0, 8))
    return bytes(out)


def _reworded(data: bytes, random: np.random.Generator) -> bytes:
    """One or two words, lines or cells of a text changed."""
    parts = re.split(rb"([\s,;:\[\]{}<>=/]+)", data)
    for _ in range(int(random.integers(1, 3))):
        at = int(random.integers(0, len(parts)))
        how = int(random.integers(0, 5))
        if how == 0:
            parts[at] = WORDS[int(random.integers(0, len(WORDS)))]
        elif how == 1:
            parts[at] = parts[int(random.integers(0, len(parts)))]
        elif how == 2:
            parts[at] += WORDS[int(random.integers(0, len(WORDS)))]
        elif how == 3:
            parts[at] = b""
        else:
            digits = bytes(48 + int(one) for one in random.integers(0, 10, random.integers(1, 25)))
            parts[at] = digits
    return b"".join(parts)


def _remade(kind: str, data: bytes, random: np.random.Generator) -> bytes:
    """A bag whose messages, definitions or names were changed before it was written."""
    with tempfile.TemporaryDirectory() as name:
        suffix = ".mcap" if kind == "mcap" else ".db3"
        source, target = Path(name, f"source{suffix}"), Path(name, f"target{suffix}")
        source.write_bytes(data)
        bag = read_bag(source)
        topics = list(bag.topics.values())
        victim = topics[int(random.integers(0, len(topics)))]
        what = random.random()
        if what < 0.6:
            for _ in range(int(random.integers(1, 4))):
                i = int(random.integers(0, len(victim.data)))
                victim.data[i] = _changed(victim.data[i], victim.data, random)
        elif what < 0.75:
            # The same change in every message: another, valid structure, or none.
            place, value = int(random.integers(0, 40)), int(random.integers(0, 256))
            victim.data = [one[:place] + bytes([value]) + one[place + 1 :] for one in victim.data]
        elif what < 0.9:
            text = victim.definition.encode()
            text = (
                _reworded(text, random) if random.random() < 0.7 else _changed(text, [text], random)
            )
            victim.definition = text.decode("utf-8", "replace")
        else:
            places = random.integers(0, len(victim.log_time_ns), 5)
            for i in places.tolist():
                victim.log_time_ns[i] = int(random.integers(0, 2**62))
        if kind == "sqlite3":
            write_sqlite(bag, target)
        else:
            with target.open("wb") as file:
                writer = Writer(file, compression=CompressionType.NONE)
                writer.start("ros2", "test")
                ids = {}
                for topic in topics:
                    schema = writer.register_schema(
                        topic.type, topic.definition_encoding, topic.definition.encode()
                    )
                    ids[topic.name] = writer.register_channel(topic.name, "cdr", schema)
                for stamp, topic_name, message in in_time_order(bag):
                    writer.add_message(ids[topic_name], stamp, message, stamp)
                writer.finish()
        return target.read_bytes()


def _read_bag(path: Path) -> None:
    proposal = propose(survey(path))
    if proposal.map is not None:
        read_mapped(path, proposal.map)
    if proposal.map is None or proposal.remarks == OWN:
        load_recording(path)


def _read_tables(path: Path) -> None:
    """A folder of tables, of which the second is whole."""
    (path.parent / "b.csv").write_text("t,enc\n" + "".join(f"{i},{i}\n" for i in range(60)))
    _read_bag(path.parent)


def _read_map(path: Path) -> None:
    """Check it against a table first, entry by entry; then read it, which may refuse it."""
    table = path.parent / "table.csv"
    if not table.exists():
        table.write_text("t,enc,x,q,f\n" + "".join(f"{i},{i},{i},{i},0\n" for i in range(60)))
    checked = check_map(table, path)
    assert not any("\n" in line or len(line) > 2000 for line in checked.lines())
    found = load_map(path)
    assert isinstance(found, SignalMap)


OWN = ("the topics are those of this project",)
_RATED = parse_map({"signals": {"rod_position": "q"}, "rate": 1000}, "rated")


def _read_mat(path: Path) -> None:
    proposal = propose(survey(path))
    read_mapped(path, proposal.map or _RATED)


def _read_metadata(path: Path) -> None:
    survey(path.parent)


def _read_motion(path: Path) -> None:
    """Read it, and ask the bench drive for it, which may refuse what is beyond its limits."""
    played = make_reference(str(path), load_drive("bench"), 2.0)
    assert np.isfinite([played.sample(time) for time in np.linspace(0.0, 2.0, 9)]).all()


def _read_joint(path: Path) -> None:
    found = read_joint(path, "rod")
    machine_from_flat(parameters(found), "joint")
    rigid_file(found, path.name)


def _read_diagnosis(path: Path) -> None:
    """All that `ecyl plan` and `ecyl investigate` ask of it."""
    data = read_diagnosis(path, load_drive("bench"), "bench")
    left = open_or_alike(data)
    for effect, values in left.values.items():
        given(effect, values)
    question(data)


READERS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "mcap": ("a.mcap", _read_bag),
    "sqlite3": ("a.db3", _read_bag),
    "packed": ("a.mcap.zstd", _read_bag),
    "csv": ("a.csv", _read_bag),
    "tables": ("a.csv", _read_tables),
    "mat": ("a.mat", _read_mat),
    "drive": ("drive.yaml", lambda path: load_model(path) and None),
    "map": ("map.yaml", _read_map),
    "metadata": ("metadata.yaml", _read_metadata),
    "motion": ("motion.yaml", _read_motion),
    "joint": ("joint.xml", _read_joint),
    "diagnosis": ("diagnosis.json", _read_diagnosis),
}


def tried(kind: str, data: bytes, folder: Path) -> str:
    """`read` or `refused`; raises whatever else comes out of a reader, and `Hang`."""
    own = folder / kind
    own.mkdir(exist_ok=True)
    name, read = READERS[kind]
    path = own / name
    path.write_bytes(data)

    def late(number: int, frame: FrameType | None) -> None:
        raise Hang(f"{kind}: more than {SLOWEST_S:g} s of the processor")

    # By the processor's time: on a busy machine a good file can take long.
    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, SLOWEST_S)
    try:
        read(path)
    except InputError as error:
        text = str(error)
        assert "\n" not in text and len(text) < 2000, json.dumps(text[:3000])
        return "refused"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    return "read"
