"""A diagnosis as people keep it: shown in a notebook, printed, drawn, written."""

from __future__ import annotations

import dataclasses
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..gap.diagnosis import Diagnosis
from ..gap.plain import finite
from ..gap.report.page import write_report
from ..gap.report.scrub import write_scrub
from ..gap.report.terminal import summary
from ..gap.report.verdict import sentence
from ..gap.twin.closer import write_twin
from ..recording.atomic import write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class DiagnosisResult(Diagnosis):
    """What `ecyl_ros.diagnose` returns: a `Diagnosis` that shows and writes itself.

    `print` gives the summary of the command line; the last line of a notebook's cell shows it as
    tables.

    Attributes:
        drive_file: the nominal model's file; None where it was given as an object.
    """

    drive_file: Path | None = None

    @classmethod
    def of(cls, diagnosis: Diagnosis, drive_file: Path | None) -> DiagnosisResult:
        """The same diagnosis, with the file of its nominal model."""
        own = {one.name: getattr(diagnosis, one.name) for one in dataclasses.fields(Diagnosis)}
        return cls(**own, drive_file=drive_file)

    @property
    def sentence(self) -> str:
        """What came out, in one to four sentences."""
        return sentence(self)

    def __str__(self) -> str:
        return summary(self)

    def __repr__(self) -> str:
        names = ", ".join(one.effect for one in self.causes)
        return f"<diagnosis of {self.source}: {self.verdict}{': ' if names else ''}{names}>"

    def _repr_html_(self) -> str:
        from .notebook import html

        return html(self)

    def plot(self) -> Figure:
        """Recorded and simulated signals on the held-out stretch with the largest gap.

        Raises:
            InputError: nothing was held out: a recording that could not be judged.
        """
        from .notebook import picture

        return picture(self)

    def to_dict(self) -> dict[str, Any]:
        """Plain data as `ecyl diagnose --json` writes it; None for numbers that are not finite."""
        data: dict[str, Any] = finite(self.as_json())
        return data

    def write_json(self, path: str | os.PathLike[str]) -> None:
        """Write `to_dict`; InputError where that cannot be."""
        write_text(Path(path), json.dumps(self.to_dict(), indent=2, allow_nan=False) + "\n")

    def write_report(self, path: str | os.PathLike[str]) -> None:
        """Write the report, one HTML page that needs nothing else; InputError if it cannot."""
        write_report(self, Path(path))

    def write_mcap(self, path: str | os.PathLike[str]) -> None:
        """Write recorded and simulated signals, residuals and events, to scrub through."""
        write_scrub(self, Path(path))

    def write_drive(self, path: str | os.PathLike[str]) -> None:
        """Write the drive file with the constants found and the causes added.

        Raises:
            InputError: nothing was found, or the nominal model did not come from a file.
        """
        if self.drive_file is None:
            raise InputError(
                f"{path}: not written: the nominal model came from no file; expected diagnose(..., "
                "drive) with a path or a profile's name"
            )
        write_twin(self, self.drive_file, Path(path))
