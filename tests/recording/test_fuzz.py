"""Readers on files changed at random; `scripts/bench fuzz_readers` does the same at length."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from fuzz_mutations import mutated
from fuzz_seeds import KINDS, METADATA, seeds
from fuzzing import tried

from ecyl_ros.recording import map_file
from ecyl_ros.recording.map_file import parse_map

FILES = 120


def test_every_key_of_a_map_is_among_what_is_changed(tmp_path: Path) -> None:
    """A key that maps gain has to be in a file that the fuzzing begins with."""
    found: set[str] = set()

    def gather(tree: object) -> None:
        if isinstance(tree, dict):
            found.update(tree)
            for value in tree.values():
                gather(value)

    for text in seeds(tmp_path)["map"]:
        gather(yaml.safe_load(text))
        assert parse_map(yaml.safe_load(text), "seed").signals
    assert {*map_file._TOP, *map_file._ENTRY, *map_file._TIME} <= found


@pytest.mark.parametrize("kind", KINDS)
def test_changed_files_are_read_or_refused(kind: str, tmp_path: Path) -> None:
    """120 changed files of a kind: a result or an error of one line, never anything else."""
    good = seeds(tmp_path)[kind]
    if kind == "metadata":
        (tmp_path / kind).mkdir()
        (tmp_path / kind / "a.mcap").write_bytes((tmp_path / "own.mcap").read_bytes())
        assert METADATA.encode() in good
    came = {"read": 0, "refused": 0}
    assert tried(kind, good[0], tmp_path) == "read"
    for number in range(FILES):
        random = np.random.default_rng([11, number])
        data = mutated(kind, good[int(random.integers(0, len(good)))], good, random)
        came[tried(kind, data, tmp_path)] += 1
    # Both ways out are taken: else the changes were too gentle, or all alike.
    assert min(came.values()) > 0, came
