"""One rigid drive: the machine, what its file says of it, how it is moved and recorded."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from ....arrays import FloatArray
from ....drive.rigid.machine import EFFORTS, Machine
from .equations import STEP_S, Truth
from .faults import Size
from .logger import Logger, draw_logger
from .motion import DURATION_S, LOOP_HZ, draw_reference

ACTUATIONS = ("own", "current", "voltage", "loop")
_ACTUATION_SHARES = (0.35, 0.3, 0.2, 0.15)
_RAMP_S = 0.05


@dataclass(frozen=True, eq=False)
class Drawn:
    """A healthy drive.

    Attributes:
        truth: the machine. machine: what its drive file says. tolerances: of that, relative.
        constants: true values of what the file states, by its keys.
        size: what a fault is drawn to.
        reference, coupling, noise: position asked for, another axis' effort and the encoder's noise
            at each tick of the loop. resolution: of the encoder as the loop sees it.
        logger: how it is recorded.
        facts: of all this, for the label.
    """

    truth: Truth
    machine: Machine
    tolerances: dict[str, float | str]
    constants: dict[str, float]
    size: Size
    reference: FloatArray
    coupling: FloatArray
    noise: FloatArray
    resolution: float
    logger: Logger
    facts: dict[str, float | str | bool | None]

    @property
    def effort_signal(self) -> str | None:
        """Field of a recording that effort goes to; None for a drive known by its loop alone."""
        known = EFFORTS.get(self.machine.actuation or "")
        return known[0] if known else None


def draw_drive(
    seed: int, linear: bool, effects: Collection[str], sheet: float, *, silent: bool = False
) -> Drawn:
    """The healthy drive of a seed.

    effects: that it is to show: it is moved and recorded so that they may be seen at all.
    sheet: relative standard deviation of its constants off the file's. silent: the file states no
    tolerances, so that the documented ones hold.
    """
    rng = np.random.default_rng([seed, 6])

    def within(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    def log(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(math.log(low), math.log(high))))

    reach = within(0.1, 0.4) if linear else within(8.0, 30.0)
    inertia = log(5.0, 60.0) if linear else log(1e-3, 5e-2)
    moves, one_way, rests = rng.random() < 0.5, rng.random() < 0.2, rng.random() < 0.3
    reference = draw_reference(
        rng, reach, moves=bool(moves), one_way=bool(one_way), rests=bool(rests)
    )
    speeds = np.gradient(reference, 1.0 / LOOP_HZ)
    speed, acceleration = (
        float(np.quantile(np.abs(one), 0.99))
        for one in (speeds, np.gradient(speeds, 1.0 / LOOP_HZ))
    )
    effort = inertia * acceleration
    level = 2.0 * log(0.06, 0.25) * effort
    bandwidth = math.tau * within(15.0, 30.0)
    late = "actuation_delay" in effects
    heavier = any(one.endswith("inertia_error") for one in effects)
    if late:  # in a faster loop it would be a drive that runs away
        bandwidth *= 0.4
    kind = str(rng.choice(ACTUATIONS, p=_ACTUATION_SHARES))
    own = "force" if linear else "torque"
    actuation = own if kind == "own" else kind
    unit, gain, winding = ("n" if linear else "nm"), 1.0, (0.0, 0.0, 0.0)
    if actuation == "current":
        gain = log(2.0, 30.0) if linear else log(0.05, 0.5)
    if actuation == "voltage":
        gain = log(1.0, 15.0) if linear else log(0.02, 0.3)
        ohm, back_emf = log(0.3, 3.0), effort / gain * log(0.2, 2.0) / speed
        winding = (ohm, back_emf, log(0.5e-3, 3e-3))

    # What the file says, and how far the machine is off it.
    viscous, coulomb = within(0.02, 0.08) * effort / speed, within(0.02, 0.08) * effort
    hangs = linear and rng.random() < 0.3
    constant = within(0.2, 1.0) * effort if hangs else 0.0
    off = 1.0 + sheet * rng.normal(size=4)
    true_gain = gain * (float(off[1]) if actuation in ("current", "voltage") else 1.0)
    drag = gain * winding[1]
    truth = Truth(
        inertia=inertia * float(off[0]),
        viscous=(viscous * float(off[2]),) * 2,
        coulomb=(coulomb * float(off[3]),) * 2,
        presliding=log(2e-6, 1e-4) * reach,
        position_kp=0.25 * bandwidth,
        speed_kp=inertia * bandwidth / gain,
        speed_ki=float(rng.choice([0.0, 0.1])) * inertia * bandwidth**2 / gain,
        limit=1e12,
        control_steps=round(1.0 / (LOOP_HZ * STEP_S)),
        constant=constant,
        gain=true_gain * (winding[0] or 1.0),
        winding=winding,
        bristle_ratio=within(0.1, 0.6),
        bristle_fade=2e-3 * speed,
    )
    coupled = rng.random() < 0.3
    coupling = _coupling(rng, reference.size, effort * log(3e-3, 3e-2)) if coupled else None
    knows_loop = actuation == "loop" or bool(rng.random() < 0.5)
    left_out = None
    if rng.random() < 0.25 and actuation in ("current", "voltage"):
        left_out = "gain"
    elif rng.random() < 0.15 and not heavier:
        left_out = "inertia"
    if left_out == "gain" and not heavier:
        unit, ratio = {"current": "a", "voltage": "v"}[actuation], true_gain
    else:
        left_out = None if left_out == "gain" else left_out
        ratio = 1.0
    logger = draw_logger(rng, linear, actuation, level / gain, DURATION_S, late)
    mass = "load.mass" if linear else "load.inertia"
    resolution = reach * 2.0 ** -float(rng.integers(19, 23))
    states_sensors = rng.random() < 0.5
    machine = Machine(
        kind="rigid",
        output="linear" if linear else "rotary",
        actuation=actuation,
        gain=None if left_out == "gain" else gain,
        inertia=None if left_out == "inertia" else inertia,
        viscous=viscous + drag,
        coulomb=coulomb,
        constant=constant,
        rate_hz=LOOP_HZ if knows_loop else None,
        position_kp=truth.position_kp if knows_loop else None,
        speed_kp=truth.speed_kp if knows_loop else None,
        speed_ki=truth.speed_ki if knows_loop else 0.0,
        position_resolution=logger.resolution if states_sensors else None,
    )
    constants = {
        mass: truth.inertia,
        "load.viscous_friction": truth.viscous[0] + true_gain * winding[1],
        "load.coulomb_friction": truth.coulomb[0],
    }
    if actuation in ("current", "voltage"):
        constants["actuation.gain"] = true_gain
    gone = {"gain": "actuation.gain", "inertia": mass}.get(left_out or "")
    tolerances: dict[str, float | str] = {}
    if not silent:
        stated = {key: 2.0 * sheet for key in constants if key != gone}
        tolerances = dict(stated) if sheet else {"all": "exact"}
    within_sheet = replace(machine, tolerances=tolerances).half_widths()
    return Drawn(
        truth=truth,
        machine=machine,
        tolerances=tolerances,
        constants={key: value for key, value in constants.items() if key != gone},
        size=Size(
            level=level,
            reach=reach,
            middle=float(0.5 * (reference.min() + reference.max())),
            speed=speed,
            rubs=truth.coulomb[0] - coulomb,
            drags=constants["load.viscous_friction"] - viscous - drag,
            rubs_within=within_sheet["load.coulomb_friction"],
            drags_within=within_sheet["load.viscous_friction"],
            loads_within=within_sheet.get("load.constant_load", 0.0),
            inertia=inertia,
            inertia_within=math.hypot(
                within_sheet.get(mass, 0.0),
                inertia * within_sheet.get("actuation.gain", 0.0) / gain,
            ),
            unit=unit,
            ratio=ratio,
            linear=linear,
        ),
        reference=reference,
        coupling=np.zeros(reference.size) if coupling is None else coupling,
        noise=0.3 * resolution * rng.normal(size=reference.size),
        resolution=resolution,
        logger=logger,
        facts={
            "output": machine.output,
            "actuation": actuation,
            "loop_known": knows_loop,
            "left_out": left_out,
            "moves": bool(moves),
            "one_way": bool(one_way),
            "rests": bool(rests),
            "hangs": bool(hangs),
            "coupled": bool(coupled),
            "logged_hz": logger.rate_hz,
            "resolution": logger.resolution,
            "speed": logger.speed,
            "noise_over_fault": logger.effort_noise * gain / level,
            "lag_samples": logger.lag_samples,
            "frozen": float(sum(length for _, length in logger.frozen)),
        },
    )


def moved_anew(drawn: Drawn, seed: int, number: int, seconds: float) -> Drawn:
    """The same drive in another, shorter recording: moved and disturbed otherwise.

    number: of the recording, from 0. seconds: that it lasts. At the same speeds, so that forwards
    alone it gets less far; about the same middle.
    """
    rng = np.random.default_rng([seed, 8, number])
    moves, one_way, rests = rng.random() < 0.5, rng.random() < 0.2, rng.random() < 0.3
    share = seconds / DURATION_S
    reach = drawn.size.reach * (share if one_way else 1.0)
    reference = draw_reference(
        rng, reach, moves=bool(moves), one_way=bool(one_way), rests=bool(rests), seconds=seconds
    )
    reference = reference + drawn.size.middle - 0.5 * (reference.min() + reference.max())
    coupled = float(np.sqrt(np.mean(drawn.coupling**2)))
    frozen = tuple((begin * share, length * share) for begin, length in drawn.logger.frozen)
    return replace(
        drawn,
        reference=reference,
        coupling=_coupling(rng, reference.size, coupled) if coupled else np.zeros(reference.size),
        noise=0.3 * drawn.resolution * rng.normal(size=reference.size),
        logger=replace(drawn.logger, frozen=frozen),
    )


def _coupling(rng: np.random.Generator, ticks: int, size: float) -> FloatArray:
    """Effort that another axis' motion asks for: sines that come and go, `size` RMS in all."""
    time = np.arange(ticks) / LOOP_HZ
    made = np.zeros(ticks)
    for _ in range(int(rng.integers(2, 5))):
        start, stop = np.sort(rng.uniform(0.0, time[-1], 2))
        inside = np.clip(np.minimum(time - start, stop - time) / _RAMP_S, 0.0, 1.0)
        rate, phase = math.tau * rng.uniform(0.2, 2.5), rng.uniform(0.0, math.tau)
        made += inside * np.sin(rate * time + phase)
    scaled: FloatArray = made * (size / max(float(np.sqrt(np.mean(made**2))), 1e-12))
    return scaled
