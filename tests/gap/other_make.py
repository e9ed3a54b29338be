"""What the sealed study's machine records of the bench drive, and its nominal replay."""

from __future__ import annotations

from collections.abc import Mapping

from sheets import exact

from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.study.cylinder.cases import Case, record_case
from ecyl_ros.recording.signals import Recording

DRIVE = exact("bench")


def recorded(
    effects: Mapping[str, Mapping[str, float]], seed: int = 9, end_s: float | None = 6.0
) -> Recording:
    """What a machine with `effects` recorded; end_s: None for all 12 s."""
    true = {name: dict(given) for name, given in effects.items()}
    recording = record_case(Case(0, seed, "pair" if len(true) > 1 else "single", true), DRIVE)
    return recording if end_s is None else recording.slice(0.0, end_s)


def replayed(
    effects: Mapping[str, Mapping[str, float]], seed: int = 9, end_s: float | None = 6.0
) -> Replay:
    """The nominal replay of what is `recorded`."""
    return Replay(recorded(effects, seed, end_s), DRIVE, "recording")
