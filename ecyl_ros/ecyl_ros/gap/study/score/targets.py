"""What is wanted of a study's figures, by the drives it is drawn of and how sure their sheet is."""

from __future__ import annotations

from types import MappingProxyType

Wanted = float | None

_TIMES = {"seconds per case: 90 % below": 45.0, "seconds per case: all below": 120.0}
_ANY = {"diagnoses that ended": 1.0, **_TIMES}

_UNCERTAIN = _ANY | {
    "single: named first": 0.95,
    "pair: both named": 0.85,
    "no gap: no cause named": 0.97,
    "not in catalogue: no wrong cause": 0.95,
    "right of those at 0.9 or surer": 0.97,
    "   within the 95 % interval": 0.9,
    "seconds per case, median": 25.0,
}
_EXACT = _ANY | {
    "single: named first": 0.98,
    "pair: both named": 0.93,
    "no gap: no false alarm": 1.0,
    "   where all can be named": 1.0,
    "not in catalogue: no wrong cause": 0.95,
    "block right": 0.98,
    "parameter error, median": 0.03,
    "shrink held out, median": 0.95,
    "right of those at 0.9 or surer": 0.95,
    "seconds per case, median": 12.0,
}
_RIGID = _ANY | {
    "single: named first": 0.9,
    "no wrong cause named": 0.97,
    "no gap: no false alarm": 0.97,
    "right of those at 0.9 or surer": 0.97,
}

_NAME, _MODERATE = "single: named first", 0.02  # the largest standard deviation of a moderate sheet


def targets(drives: str, sheet: float) -> MappingProxyType[str, float]:
    """Bounds by the figure's name. drives: bench, random, rigid. sheet: standard deviation."""
    if drives == "rigid":
        wanted = _RIGID
    elif sheet == 0.0:
        wanted = _EXACT | ({_NAME: 0.97} if drives == "random" else {})
    else:
        least = 0.93 if drives == "random" else 0.95
        wanted = _UNCERTAIN | {_NAME: least if sheet <= _MODERATE else 0.9}
    return MappingProxyType(wanted)
