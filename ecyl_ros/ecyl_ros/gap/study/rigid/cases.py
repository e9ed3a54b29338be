"""Draw rigid drives with a hidden fault: what a diagnosis is given, and what stays sealed."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....recording.signals import Recording
from ...diagnosis import FloatArray
from ...effort.machine import Machine
from .equations import STEP_S, Truth, run

DURATION_S = 16.0
_RATE_HZ = 1000.0
KINDS = ("single", "none", "withheld")
_SHARES = (0.6, 0.25, 0.15)


@dataclass(frozen=True)
class Case:
    """A drawn drive. `effect` is None on a healthy one; `withheld`: it is barred from the answer.

    loop: whether the drive file holds the controller. actuation: what is recorded as effort.
    """

    index: int
    kind: str
    linear: bool
    actuation: str
    loop: bool
    effect: str | None
    size: float
    seed: int

    def label(self) -> dict[str, Any]:
        """What is sealed."""
        return dataclasses.asdict(self)


def seal(cases: list[Case]) -> str:
    """SHA-256 of the labels."""
    text = json.dumps([one.label() for one in cases], sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def draw(count: int, seed: int) -> list[Case]:
    """`count` cases; the same for the same seed."""
    rng = np.random.default_rng(seed)
    queue: dict[bool, list[str]] = {True: [], False: []}
    cases = []
    for index in range(count):
        linear = bool(rng.random() < 0.5)
        kind = str(rng.choice(KINDS, p=_SHARES))
        effect = None
        if kind != "none":
            if not queue[linear]:
                queue[linear] = rng.permutation(sorted(faults(linear))).tolist()
            effect = queue[linear].pop()
        own = "force" if linear else "torque"
        actuation = str(rng.choice([own, "current", "loop"]))
        cases.append(
            Case(
                index,
                kind,
                linear,
                actuation,
                actuation == "loop" or bool(rng.random() < 0.5),
                effect,
                float(np.exp(rng.uniform(math.log(0.06), math.log(0.25)))),
                int(rng.integers(2**31)),
            )
        )
    return cases


# A fault: changes the truth by `level` of effort, on travel `reach` at top speed `speed`.
Fault = Callable[[Truth, float, float, float, np.random.Generator], Truth]


def faults(linear: bool) -> dict[str, Fault]:
    """The faults that act on effort, by the name that a diagnosis should give them."""
    side = "load" if linear else "rotor"
    periods = (20.0, 45.0) if linear else (4.0, 13.0)  # over the travel; per turn

    def wave(reach: float, rng: np.random.Generator) -> float:
        number = rng.uniform(*periods)
        return math.tau * number / reach if linear else float(round(number))

    def by_direction(t: Truth, level: float, reach: float, speed: float, rng: Any) -> Truth:
        way = 1 if rng.random() < 0.5 else -1
        most, least = (level, 0.25 * level)[::way]
        steep, flat = (0.8 * level / speed, 0.2 * level / speed)[::way]
        return t._replace(
            coulomb=(t.coulomb[0] + most, t.coulomb[1] + least),
            viscous=(t.viscous[0] + steep, t.viscous[1] + flat),
        )

    def jam(t: Truth, level: float, reach: float, speed: float, rng: Any) -> Truth:
        place = rng.uniform(-0.2, 0.2) * reach
        return t._replace(jam=(1.5 * level, place, rng.uniform(0.12, 0.25) * reach))

    def more(t: Truth, level: float, share: float) -> Truth:
        return t._replace(coulomb=(t.coulomb[0] + share * level, t.coulomb[1] + share * level))

    found: dict[str, Fault] = {
        f"{side}_coulomb_friction": lambda t, level, reach, speed, rng: more(t, level, 1.0),
        f"{side}_viscous_friction": lambda t, level, reach, speed, rng: t._replace(
            viscous=(t.viscous[0] + 1.5 * level / speed, t.viscous[1] + 1.5 * level / speed)
        ),
        f"{side}_inertia_error": lambda t, level, reach, speed, rng: t._replace(
            inertia=t.inertia * rng.uniform(1.15, 1.6)
        ),
        "direction_dependent_friction": by_direction,
        "stribeck_friction": lambda t, level, reach, speed, rng: more(t, level, 0.7)._replace(
            static=1.5 * level, stribeck=speed * rng.uniform(0.06, 0.2)
        ),
        "friction_drift": lambda t, level, reach, speed, rng: more(t, level, 1.0)._replace(
            drift_per_s=float(rng.choice([-1.0, 1.0])) * rng.uniform(0.02, 0.05)
        ),
        "constant_load": lambda t, level, reach, speed, rng: t._replace(
            constant=t.constant + float(rng.choice([-1.0, 1.0])) * level
        ),
        "spring_load": lambda t, level, reach, speed, rng: t._replace(
            stiffness=t.stiffness + 3.0 * level / reach
        ),
        "cogging_torque": lambda t, level, reach, speed, rng: t._replace(
            cogging=(level, wave(reach, rng), rng.uniform(0.0, math.tau))
        ),
        "torque_ripple": lambda t, level, reach, speed, rng: t._replace(
            ripple=(rng.uniform(0.1, 0.25), wave(reach, rng), rng.uniform(0.0, math.tau))
        ),
        "periodic_disturbance": lambda t, level, reach, speed, rng: t._replace(
            sine=(level, math.tau * rng.uniform(3.0, 9.0), rng.uniform(0.0, math.tau))
        ),
        "local_jam": jam,
        "load_dependent_friction": lambda t, level, reach, speed, rng: t._replace(
            carried=rng.uniform(0.1, 0.3)
        ),
        "actuation_delay": lambda t, level, reach, speed, rng: t._replace(
            delay_steps=round(rng.uniform(4e-3, 9e-3) / STEP_S)
        ),
    }
    return found


def play(case: Case) -> tuple[Recording, Machine]:
    """The recording of a case, and the drive file of the healthy drive, as far as it is known."""
    rng = np.random.default_rng(case.seed)
    linear = case.linear
    reach = float(rng.uniform(0.1, 0.4)) if linear else float(rng.uniform(8.0, 30.0))
    inertia = float(np.exp(rng.uniform(*np.log([5.0, 60.0] if linear else [1e-3, 5e-2]))))
    ticks = int(DURATION_S * _RATE_HZ)
    reference = _reference(rng, ticks, reach)
    speed, acceleration = (
        float(np.quantile(np.abs(np.gradient(one, 1.0 / _RATE_HZ)), 0.99))
        for one in (reference, np.gradient(reference, 1.0 / _RATE_HZ))
    )
    effort = inertia * acceleration
    bandwidth = math.tau * float(rng.uniform(15.0, 30.0))
    if case.effect == "actuation_delay":  # in a faster loop it would be a drive that runs away
        bandwidth *= 0.4
    gain = float(rng.uniform(2.0, 30.0)) if linear else float(rng.uniform(0.05, 0.5))
    friction = float(rng.uniform(0.02, 0.08)) * effort
    nominal = Truth(
        inertia=inertia,
        viscous=(0.04 * effort / speed,) * 2,
        coulomb=(friction, friction),
        presliding=float(rng.uniform(2e-6, 1e-5)) * reach,
        position_kp=0.25 * bandwidth,
        speed_kp=inertia * bandwidth,
        speed_ki=float(rng.choice([0.0, 0.1])) * inertia * bandwidth**2,
        limit=1e12,
        control_steps=round(1.0 / (_RATE_HZ * STEP_S)),
    )
    truth = nominal
    if case.effect is not None:
        change = faults(linear)[case.effect]
        truth = change(nominal, 2.0 * case.size * effort, reach, speed, rng)
    resolution = reach * 2.0 ** -float(rng.integers(19, 23))
    noise = 0.3 * resolution * rng.normal(size=ticks)
    rows = run(truth, reference, np.zeros(ticks), noise, resolution)
    effort_noise = float(rng.uniform(5e-4, 3e-3)) * effort
    sensed = rows[:, 2] + effort_noise * rng.normal(size=ticks)
    signals: dict[str, Any] = {
        "rod_position_m" if linear else "rotor_position_rad": rows[:, 0],
        f"reference_position_{'m' if linear else 'rad'}": reference,
    }
    factor = 1.0
    if case.actuation == "current":
        factor = gain
        signals["current_q_a"] = sensed / gain
    elif case.actuation != "loop":
        signals["rod_force_n" if linear else "rotor_torque_nm"] = sensed
    stamps = np.round(np.arange(ticks) * 1e9 / _RATE_HZ).astype(np.int64)
    machine = Machine(
        kind="rigid",
        output="linear" if linear else "rotary",
        actuation=case.actuation,
        gain=factor,
        inertia=inertia,
        viscous=nominal.viscous[0],
        coulomb=friction,
        rate_hz=_RATE_HZ if case.loop else None,
        position_kp=nominal.position_kp if case.loop else None,
        speed_kp=nominal.speed_kp / factor if case.loop else None,
        speed_ki=nominal.speed_ki / factor if case.loop else 0.0,
    )
    return Recording(stamp_ns=stamps, **signals), machine


def _reference(rng: np.random.Generator, ticks: int, reach: float) -> FloatArray:
    """Sines from 0.1 to 2 Hz that begin at rest, over `reach` in all."""
    t = np.arange(ticks) / _RATE_HZ
    frequencies = rng.uniform([0.1, 0.25, 0.5, 0.9, 1.4], [0.2, 0.45, 0.8, 1.3, 2.0])
    shares = np.array([1.0, 0.7, 0.35, 0.15, 0.08]) * rng.uniform(0.7, 1.3, 5)
    phases = rng.uniform(0.0, math.tau, 5)
    waves = shares[:, None] * np.sin(math.tau * frequencies[:, None] * t + phases[:, None])
    made = waves.sum(axis=0)
    made = (made - made[0]) * np.minimum(t / 0.5, 1.0) ** 2
    scaled: FloatArray = made * (reach / float(np.ptp(made)))
    return scaled
