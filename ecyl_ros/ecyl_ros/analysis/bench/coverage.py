"""How often the intervals hold the truth, over many draws of the sensors' errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...drive.parameters import DriveParameters
from ...effects.catalogue import CATALOGUE
from ...errors import InputError
from ..parallel import over
from .fit import Estimate
from .identify import identify
from .loop import Loop
from .sensors import BenchSensors
from .simulated import BenchTest, simulated_loop, with_sensors

MIN_DRAWS = 2


@dataclass(frozen=True)
class Coverage:
    """One parameter over all draws.

    Attributes:
        name: of the estimate, with its unit.
        truth: the drive's own value.
        inside: share of draws whose 95 % interval holds it.
        shown: share of draws in which the loop showed the parameter at all.
        bias, scatter: mean and standard deviation of value / truth - 1.
    """

    name: str
    truth: float
    inside: float
    shown: float
    bias: float
    scatter: float


def true_values(drive: DriveParameters) -> dict[str, float]:
    """What a perfect identification of the drive's transmission would give.

    Raises:
        InputError: more segments than three lines can have, or an effect in the transmission.
    """
    for name in drive.effects:
        if CATALOGUE[name].block == "transmission":
            raise InputError(
                f"bench: the drive has effects.{name}, which is not in its nominal transmission; "
                "draws need a drive without it"
            )
    transmission = drive.transmission
    compliance = [1.0 / one for one in transmission.stiffness]
    breaks = transmission.stiffness_breaks
    if transmission.backlash > 0.0 and len(compliance) <= 2:
        found = {"clearance_rad": transmission.backlash, "k2_rad_per_nm": compliance[0]}
        if breaks:
            found |= {"k3_rad_per_nm": compliance[1], "t2_nm": breaks[0]}
        return found
    if transmission.backlash == 0.0 and len(compliance) == 3:
        names = ("k1_rad_per_nm", "k2_rad_per_nm", "k3_rad_per_nm")
        return dict(zip(names, compliance, strict=True)) | {"t1_nm": breaks[0], "t2_nm": breaks[1]}
    raise InputError(
        "bench: the drive's transmission is no three lines; expected a backlash and one or two "
        "stiffnesses, or no backlash and three"
    )


def coverage(
    drive: DriveParameters,
    draws: int,
    *,
    test: BenchTest | None = None,
    sensors: BenchSensors | None = None,
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Coverage]:
    """Identify the drive's simulated loop `draws` times, with seeds 0, 1, 2, ...

    Raises:
        InputError: see `true_values`, `simulated_loop`; fewer than 2 draws.
    """
    if draws < MIN_DRAWS:
        raise InputError(f"bench: {draws} draws, expected {MIN_DRAWS} or more")
    truth = true_values(drive)
    test = test or BenchTest()
    loop = simulated_loop(drive, test)
    tasks = [
        (loop, sensors or BenchSensors(), seed, test.shaft_twist_rad_per_nm, tuple(truth))
        for seed in range(draws)
    ]
    found = over(_drawn, tasks, jobs=jobs, progress=progress)
    return [_judged(name, value, [one[name] for one in found]) for name, value in truth.items()]


def _drawn(
    task: tuple[Loop, BenchSensors, int, float, tuple[str, ...]],
) -> dict[str, Estimate | None]:
    loop, sensors, seed, twist, names = task
    fit = identify(with_sensors(loop, sensors, seed), shaft_twist_rad_per_nm=twist).fit
    return {name: getattr(fit, name) for name in names}


def _judged(name: str, truth: float, found: list[Estimate | None]) -> Coverage:
    shown = [one for one in found if one is not None]
    errors = np.array([one.value / truth - 1.0 for one in shown])
    nan = float("nan")
    return Coverage(
        name=name,
        truth=truth,
        inside=sum(one.low <= truth <= one.high for one in shown) / len(found),
        shown=len(shown) / len(found),
        bias=float(errors.mean()) if shown else nan,
        scatter=float(errors.std(ddof=1)) if len(shown) > 1 else nan,
    )
