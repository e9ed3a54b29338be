"""Emulate an electric-cylinder servo drive as a ROS 2 graph and diagnose its sim-to-real gap.

::

    import ecyl_ros as ec

    r = ec.read("bags/worn_drive.mcap")
    d = ec.diagnose(r, "bench")
    print(d)

What `__all__` lists is the public interface: it only grows within a major version. The modules
behind it may move. Each name is imported when it is first used, so that nodes start fast.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .analysis.tracking import TrackingAnalysis, analyse
    from .api.diagnosing import diagnose
    from .api.drives import changed, load_drive
    from .api.reading import propose_map, read, write
    from .api.result import DiagnosisResult
    from .api.simulating import simulate
    from .drive.drive_file import profiles
    from .drive.parameters import DriveParameters
    from .drive.rigid.machine import Machine
    from .errors import InputError
    from .recording.map import SignalMap
    from .recording.propose import Proposal
    from .recording.signals import Recording

__version__ = "0.2.0"

__all__ = [
    "DiagnosisResult",
    "DriveParameters",
    "InputError",
    "Machine",
    "Proposal",
    "Recording",
    "SignalMap",
    "TrackingAnalysis",
    "analyse",
    "changed",
    "diagnose",
    "load_drive",
    "profiles",
    "propose_map",
    "read",
    "simulate",
    "write",
]

_WHERE = {
    "DiagnosisResult": "api.result",
    "DriveParameters": "drive.parameters",
    "InputError": "errors",
    "Machine": "drive.rigid.machine",
    "Proposal": "recording.propose",
    "Recording": "recording.signals",
    "SignalMap": "recording.map",
    "TrackingAnalysis": "analysis.tracking",
    "analyse": "analysis.tracking",
    "changed": "api.drives",
    "diagnose": "api.diagnosing",
    "load_drive": "api.drives",
    "profiles": "drive.drive_file",
    "propose_map": "api.reading",
    "read": "api.reading",
    "simulate": "api.simulating",
    "write": "api.reading",
}


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(importlib.import_module(f"{__name__}.{_WHERE[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
