"""The simulated bench: a drive's own transmission and friction laws, loaded quasi-statically.

At rest the motor's torque equals what the flanks carry plus what friction holds. Flanks are
`drive.transmission`, friction is the bristle of `drive.friction`; the torque then is a rising
function of the angle as long as the shaft turns one way, and a slow ramp of torque follows it. In
the clearance, where nothing but friction resists, the shaft jumps from flank to flank.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import FloatArray
from ...drive.friction import BREAKAWAY_RAD, deflected
from ...drive.packed import pack
from ...drive.parameters import DriveParameters
from ...drive.transmission import contact_mode, mode_torque
from ...effects import ports
from ...errors import InputError
from . import table1
from .loop import Loop
from .sensors import BenchSensors, read

STEPS = 8000  # of angle from one end of the loop to the other
STEPS_PER_BREAKAWAY = 20
TURNED = 30  # breakaways after which friction has turned round to 1e-13
MARGIN = 1.05


@dataclass(frozen=True)
class BenchTest:
    """How the bench is driven.

    Attributes:
        torque_limit_nm: the loop runs to + and - this.
        readings: per edge, at even steps of torque.
        loops: whole loops after the first loading.
        friction_nm: internal friction between input shaft and flanks. The paper shows a loop but
            gives no width: 1 N m is assumed, within the 3 % of rated torque said to overcome it.
        load_friction: friction per transmitted torque; assumed.
        breakaway_rad: angle over which friction turns round.
        shaft_twist_rad_per_nm: twist between input gear and angle sensor (section 3.2).
    """

    torque_limit_nm: float = table1.RATED_TORQUE
    readings: int = 4000
    loops: int = 1
    friction_nm: float = 1.0
    load_friction: float = 0.02
    breakaway_rad: float = BREAKAWAY_RAD
    shaft_twist_rad_per_nm: float = table1.SHAFT_TWIST / table1.RATED_TORQUE


@dataclass(frozen=True)
class _Sweep:
    """One way of the shaft: angles in the order of turning, torque applied and transmitted."""

    angle: FloatArray
    applied: FloatArray
    transmitted: FloatArray
    bristle: float  # at its end, in shares of the breakaway


def simulated_loop(
    drive: DriveParameters, test: BenchTest | None = None, source: str = "simulated bench"
) -> Loop:
    """The loop as perfect sensors would read it: first loading, then down and up `loops` times.

    Effects of the drive that act in the transmission or as friction of the rotor are in it.

    Raises:
        InputError: a setting that is not possible, or friction that the torque cannot overcome.
    """
    test = test or BenchTest()
    _check(test)
    params = pack(drive)
    turning = [0.0, test.torque_limit_nm]
    turning += [-test.torque_limit_nm, test.torque_limit_nm] * test.loops
    angle, bristle = 0.0, 0.0
    torques, angles, forces = [], [], []
    for start, stop in itertools.pairwise(turning):
        sweep = _sweep(params, test, angle, bristle, stop, source)
        share = abs(stop - start) / (2.0 * test.torque_limit_nm)
        applied = np.linspace(start, stop, max(2, round(share * test.readings)))
        sign = 1.0 if stop > start else -1.0
        # Where the torque stands still (in the clearance) the shaft is at the far side at once.
        rising = np.maximum.accumulate(sign * sweep.applied)
        torques.append(applied)
        angles.append(np.interp(sign * applied, rising, sweep.angle))
        forces.append(np.interp(sign * applied, rising, sweep.transmitted))
        angle, bristle = float(sweep.angle[-1]), sweep.bristle
    torque = np.concatenate(torques)
    return Loop(
        torque_nm=torque,
        angle_rad=np.concatenate(angles) + test.shaft_twist_rad_per_nm * torque,
        force_n=np.concatenate(forces) / drive.transmission.rod_per_rotor,
        displacement_m=np.zeros_like(torque),
        source=source,
    )


def with_sensors(loop: Loop, sensors: BenchSensors, seed: int) -> Loop:
    """The loop as the bench's sensors read it; the same seed gives the same errors."""
    rng = np.random.default_rng(seed)
    force, displacement = loop.force_n, loop.displacement_m
    return replace(
        loop,
        torque_nm=read(loop.torque_nm, sensors.torque_nm, rng),
        angle_rad=read(loop.angle_rad, sensors.angle_rad, rng),
        force_n=None if force is None else read(force, sensors.force_n, rng),
        displacement_m=(
            None if displacement is None else read(displacement, sensors.displacement_m, rng)
        ),
    )


def _check(test: BenchTest) -> None:
    for name, low in (
        ("torque_limit_nm", 1e-6),
        ("friction_nm", 0.0),
        ("load_friction", 0.0),
        ("breakaway_rad", 1e-9),
        ("shaft_twist_rad_per_nm", 0.0),
    ):
        value = getattr(test, name)
        if not (np.isfinite(value) and value >= low):
            raise InputError(f"bench: {name} = {value:g}, expected {low:g} or more")
    if test.friction_nm + test.load_friction * test.torque_limit_nm >= test.torque_limit_nm:
        raise InputError(
            f"bench: friction of {test.friction_nm:g} N m and {test.load_friction:g} of the load, "
            f"expected less than the torque limit of {test.torque_limit_nm:g} N m"
        )
    if test.readings < 100 or test.loops < 1:
        raise InputError(
            f"bench: {test.readings} readings in {test.loops} loops, expected 100 and 1 or more"
        )


def _angle_at(p: np.record, torque_nm: float) -> float:
    """Twist, rad, at which the flanks carry a torque > 0."""
    starts = p["torque_start"][: p["segments"]]
    segment = int(np.searchsorted(starts, torque_nm, side="right")) - 1
    beyond = (torque_nm - starts[segment]) / p["stiffness"][segment]
    return float(p["half_backlash"] + p["deflection_start"][segment] + beyond)


def _sweep(
    params: np.ndarray, test: BenchTest, start: float, bristle: float, goal_nm: float, source: str
) -> _Sweep:
    p = params[0]
    sign = 1.0 if goal_nm > 0.0 else -1.0
    reach = MARGIN * _angle_at(p, abs(goal_nm))  # friction only takes off from what is transmitted
    breakaway = float(p["rotor_breakaway"]) if p["acts_at_rotor_friction"] else test.breakaway_rad
    span = reach + sign * -start
    # Fine where friction turns round, and on every corner of the law; straight in between.
    turning = np.linspace(0.0, min(span, TURNED * breakaway), TURNED * STEPS_PER_BREAKAWAY)
    corners = float(p["half_backlash"]) + p["deflection_start"][: p["segments"]]
    met = sign * (np.concatenate((corners, -corners)) - start)
    met = met[(met > 0.0) & (met < span)]
    way = np.unique(np.concatenate((np.linspace(0.0, span, STEPS), turning, met)))
    angle = start + sign * way
    transmitted = np.array([mode_torque(x, 0.0, contact_mode(x, 0.0, p), p) for x in angle])
    level = test.friction_nm + test.load_friction * np.abs(transmitted)
    if p["acts_at_rotor_friction"]:
        creep = sign * 1e-9  # rad/s: quasi-static, but one way
        level = level + np.array([ports.rotor_friction(p, creep, t, 0.0) for t in transmitted])
    bend = np.array([deflected(bristle, sign, x, breakaway) for x in way])
    applied = transmitted + level * bend
    beyond = np.flatnonzero(sign * applied >= abs(goal_nm))
    if not beyond.size:
        raise InputError(
            f"{source}: the loop does not reach {goal_nm:g} N m, expected less friction"
        )
    last = int(beyond[0]) + 1
    return _Sweep(angle[:last], applied[:last], transmitted[:last], float(bend[last - 1]))
