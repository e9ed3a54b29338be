"""Diagnoses every recording of a folder, on all cores or on a cluster, and keeps what is done."""

from __future__ import annotations

import hashlib
import json
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ...analysis.parallel import over
from ...errors import InputError
from ...recording.atomic import write_text
from ..diagnosis import Diagnosis
from ..plain import finite
from ..report.page import report_html
from .entry import Entry
from .find import Found

Judge = Callable[[Path], Diagnosis]
_PAGES = "recordings"


@dataclass(frozen=True)
class Job:
    """One recording to diagnose. judge: reads and diagnoses; can be pickled."""

    found: Found
    judge: Judge


@dataclass(frozen=True)
class Done:
    """What came of a job. page, data: report and JSON; empty where there is no diagnosis."""

    found: Found
    entry: Entry
    page: str = ""
    data: str = ""


def diagnosed(job: Job) -> Done:
    """Diagnose one recording; whatever goes wrong is a line of the index, no end of the others."""
    found = job.found
    try:
        diagnosis = job.judge(found.path)
        data = json.dumps(finite(diagnosis.as_json()), indent=2, allow_nan=False) + "\n"
        return Done(found, Entry.of(found, diagnosis), report_html(diagnosis), data)
    except InputError as error:
        why = str(error).removeprefix(f"{found.path}: ")
    except Exception as error:  # one broken file must cost one line
        last = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{last.filename.rsplit('/', 1)[-1]}:{last.lineno}"
        why = f"{type(error).__name__} at {place}: {error}"
    return Done(found, Entry(found.name, found.machine, error=" ".join(why.split())))


@dataclass(frozen=True)
class Fleet:
    """A folder of pages.

    out: where they go. asked: what every diagnosis rests on beside its recording (drive file, map,
    flags), of which a page that is kept must hold the same.
    """

    out: Path
    asked: bytes

    def page(self, found: Found, suffix: str = ".html") -> Path:
        """File of a recording."""
        return self.out / _PAGES / f"{found.name}{suffix}"

    def key(self, found: Found) -> str:
        """What an entry that is kept was made from."""
        state = found.path.stat()
        text = f"{found.name} {state.st_size} {state.st_mtime_ns} ".encode()
        return hashlib.sha256(text + self.asked).hexdigest()

    def kept(self, found: Found) -> Entry | None:
        """The entry of an earlier run, where nothing that it rests on has changed."""
        try:
            held = json.loads(self.page(found, ".entry").read_text(encoding="utf-8"))
            if held["key"] != self.key(found):
                return None
            entry = Entry.from_json(held["entry"])
        except (OSError, ValueError, KeyError, TypeError):
            return None
        whole = entry.error or (self.page(found).exists() and self.page(found, ".json").exists())
        return entry if whole else None

    def keep(self, done: Done) -> None:
        """Write page, data and, last, the entry that says that they are whole."""
        found = done.found
        self.page(found).parent.mkdir(parents=True, exist_ok=True)
        for suffix, text in ((".html", done.page), (".json", done.data)):
            if text:
                write_text(self.page(found, suffix), text)
            else:
                self.page(found, suffix).unlink(missing_ok=True)
        held = {"key": self.key(found), "entry": finite(done.entry.as_json())}
        write_text(self.page(found, ".entry"), json.dumps(held) + "\n")


def run_fleet(
    fleet: Fleet,
    recordings: Sequence[Found],
    judge: Judge,
    *,
    resume: bool = False,
    jobs: int | None = None,
    dask: str | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> list[Entry]:
    """Diagnose all, write a page for each as it comes; entries in the order of `recordings`.

    resume: keep what an earlier run has made of the same recordings with the same drive.
    """
    entries: dict[str, Entry] = {}
    open_ = []
    for found in recordings:
        held = fleet.kept(found) if resume else None
        if held is None:
            open_.append(found)
        else:
            entries[found.name] = held

    def take(done: Done) -> None:
        fleet.keep(done)
        entries[done.found.name] = done.entry
        progress(len(entries) / len(recordings))

    over(diagnosed, [Job(one, judge) for one in open_], jobs=jobs, dask=dask, each=take)
    return [entries[one.name] for one in recordings]
