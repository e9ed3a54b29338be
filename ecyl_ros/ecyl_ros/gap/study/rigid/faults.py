"""The faults of rigid drives: what each changes in the truth, and the values its label holds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .equations import STEP_S, Truth

Values = dict[str, float]

LEAVES, FARTHEST = 2.5, 6.0  # tolerances that a fault in a constant lies off the sheet


@dataclass(frozen=True)
class Size:
    """What a fault is drawn to: `level` of effort, on travel `reach` about `middle` at top
    speed `speed`.

    rubs, drags: by which the machine's Coulomb and viscous friction are off the file before the
    fault: what comes on top is counted from the file. rubs_within, drags_within, loads_within:
    tolerances of Coulomb and viscous friction and constant load. inertia, inertia_within: of the
    file, and its tolerance, which that of a gain adds to: effort tells them by their ratio. unit:
    of the label's values: n, nm, a or v. ratio: output effort per that unit.
    """

    level: float
    reach: float
    middle: float
    speed: float
    rubs: float
    drags: float
    rubs_within: float
    drags_within: float
    loads_within: float
    inertia: float
    inertia_within: float
    unit: str
    ratio: float
    linear: bool

    def effort(self, stem: str, value: float) -> Values:
        """A value that is an effort, as a diagnosis names and counts it."""
        return {f"{stem}_{self.unit}": value / self.ratio}

    def slope(self, stem: str, value: float, per: str = "s_per_") -> Values:
        """An effort over speed, or over travel where `per` is `per_`."""
        return {f"{stem}_{self.unit}_{per}{'m' if self.linear else 'rad'}": value / self.ratio}


def clear(one: str, other: str) -> bool:
    """Whether two faults that act at once can be told apart, and their labels hold: they are not
    both friction of some level, or part of the other, or waves over the same place."""
    first, second = (
        {name, *AKIN.get(name, ()), *(_WAVES if name in _WAVES else ())} for name in (one, other)
    )
    return not first & second


class Faulty(NamedTuple):
    """The machine with a fault, and the values of its label."""

    truth: Truth
    values: Values


Fault = Callable[[Truth, Size, np.random.Generator], Faulty]

# What gives the same effort, or nearly: named instead, it is not wrong, but neither is it a hit.
_RUBS = ("load_coulomb_friction", "rotor_coulomb_friction")
AKIN: dict[str, tuple[str, ...]] = {
    "load_dependent_friction": _RUBS,
    "stribeck_friction": _RUBS,
    "friction_drift": _RUBS,
    "direction_dependent_friction": (
        *_RUBS,
        "load_viscous_friction",
        "rotor_viscous_friction",
        "constant_load",
    ),
}

_WAVES = ("cogging_torque", "torque_ripple")


def _side(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _more(truth: Truth, level: float) -> Truth:
    return truth._replace(coulomb=(truth.coulomb[0] + level, truth.coulomb[1] + level))


def _coulomb(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    level = max(size.level, LEAVES * size.rubs_within)
    return Faulty(_more(truth, level), size.effort("coulomb", level + size.rubs))


def _viscous(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    slope = max(1.5 * size.level / size.speed, LEAVES * size.drags_within)
    made = truth._replace(viscous=(truth.viscous[0] + slope, truth.viscous[1] + slope))
    return Faulty(made, size.slope("viscous", slope + size.drags))


def _inertia(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    value = truth.inertia * (1.0 + float(rng.uniform(0.15, 0.6)))
    if value < size.inertia + LEAVES * size.inertia_within:
        value = size.inertia + float(rng.uniform(LEAVES, FARTHEST)) * size.inertia_within
    if size.unit == "n":
        named = {"mass_kg": value}
    elif size.unit == "nm":
        named = {"inertia_kg_m2": value}
    else:
        end = "m" if size.linear else "rad"
        named = {f"inertia_{size.unit}_s2_per_{end}": value / size.ratio}
    return Faulty(truth._replace(inertia=value), named)


def _by_direction(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    way = 1 if rng.random() < 0.5 else -1
    most, least = (size.level, 0.25 * size.level)[::way]
    steep, flat = (0.8 * size.level / size.speed, 0.2 * size.level / size.speed)[::way]
    made = truth._replace(
        coulomb=(truth.coulomb[0] + most, truth.coulomb[1] + least),
        viscous=(truth.viscous[0] + steep, truth.viscous[1] + flat),
    )
    values = size.effort("coulomb_positive", most + size.rubs)
    values |= size.effort("coulomb_negative", least + size.rubs)
    values |= size.slope("viscous_positive", steep + size.drags)
    values |= size.slope("viscous_negative", flat + size.drags)
    return Faulty(made, values)


def _stribeck(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    speed = size.speed * float(rng.uniform(0.06, 0.2))
    more, static = 0.7 * size.level, 1.5 * size.level
    made = _more(truth, more)._replace(static=static, stribeck=speed)
    end = "m_s" if size.linear else "rad_s"
    level = more + size.rubs
    values = size.effort("coulomb", level) | size.effort("static", level + static)
    return Faulty(made, values | {f"stribeck_{end}": speed})


def _drift(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    rate = _side(rng) * float(rng.uniform(0.01, 0.03))
    made = _more(truth, size.level)._replace(drift_per_s=rate)
    # All of the friction drifts; a drive file has it of what comes on top.
    level = size.level + size.rubs
    on_top = rate * made.coulomb[0] / level
    return Faulty(made, size.effort("coulomb", level) | {"rate_per_s": on_top})


def _constant(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    force = _side(rng) * max(size.level, LEAVES * size.loads_within)
    made = truth._replace(constant=truth.constant + force)
    return Faulty(made, size.effort("force" if size.linear else "torque", force))


def _spring(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    stiffness = 3.0 * size.level / size.reach
    return Faulty(
        truth._replace(stiffness=truth.stiffness + stiffness),
        size.slope("stiffness", stiffness, "per_"),
    )


def _wave(size: Size, rng: np.random.Generator) -> tuple[float, Values]:
    """(rad per position, the label's value) of what repeats over the travel or the turn."""
    if size.linear:
        number = float(rng.uniform(20.0, 45.0))
        return math.tau * number / size.reach, {"period_m": size.reach / number}
    number = float(round(rng.uniform(4.0, 13.0)))
    return number, {"periods_per_rev": number}


def _cogging(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    rate, named = _wave(size, rng)
    made = truth._replace(cogging=(size.level, rate, float(rng.uniform(0.0, math.tau))))
    return Faulty(made, size.effort("amplitude", size.level) | named)


def _ripple(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    rate, named = _wave(size, rng)
    fraction = float(rng.uniform(0.1, 0.25))
    made = truth._replace(ripple=(fraction, rate, float(rng.uniform(0.0, math.tau))))
    return Faulty(made, {"fraction": fraction} | named)


def _gravity(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    amplitude = 1.5 * size.level
    made = truth._replace(gravity=(amplitude, 1.0, float(rng.uniform(0.0, math.tau))))
    return Faulty(made, size.effort("amplitude", amplitude))


def _disturbance(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    hertz = float(rng.uniform(3.0, 9.0))
    phase = float(rng.uniform(0.0, math.tau))
    made = truth._replace(sine=(size.level, math.tau * hertz, phase))
    return Faulty(made, size.effort("amplitude", size.level) | {"frequency_hz": hertz})


def _jam(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    place = size.middle + float(rng.uniform(-0.2, 0.2)) * size.reach
    width = float(rng.uniform(0.12, 0.25)) * size.reach
    if not size.linear:
        width = min(width, math.tau)  # a place is part of a turn
    level, end = 1.5 * size.level, "m" if size.linear else "rad"
    values = size.effort("coulomb", level) | {f"position_{end}": place, f"width_{end}": width}
    return Faulty(truth._replace(jam=(level, place, width)), values)


def _carried(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    share = float(rng.uniform(0.1, 0.3))
    return Faulty(truth._replace(carried=share), {"coefficient": share})


def _delay(truth: Truth, size: Size, rng: np.random.Generator) -> Faulty:
    steps = round(float(rng.uniform(4e-3, 9e-3)) / STEP_S)
    return Faulty(truth._replace(delay_steps=steps), {"delay_s": steps * STEP_S})


def faults(linear: bool) -> dict[str, Fault]:
    """The faults that act on effort, by the name that a diagnosis should give them."""
    side = "load" if linear else "rotor"
    found: dict[str, Fault] = {
        f"{side}_coulomb_friction": _coulomb,
        f"{side}_viscous_friction": _viscous,
        f"{side}_inertia_error": _inertia,
        "direction_dependent_friction": _by_direction,
        "stribeck_friction": _stribeck,
        "friction_drift": _drift,
        "constant_load": _constant,
        "spring_load": _spring,
        "cogging_torque": _cogging,
        "torque_ripple": _ripple,
        "periodic_disturbance": _disturbance,
        "local_jam": _jam,
        "load_dependent_friction": _carried,
        "actuation_delay": _delay,
    }
    return found if linear else found | {"gravity_on_arm": _gravity}


# What makes a gap without being a fault, and where.
STRANGE = {"x_other_axis": "load", "x_winding_lag": "timing"}

FAULTS: dict[str, Fault] = faults(True) | faults(False)
