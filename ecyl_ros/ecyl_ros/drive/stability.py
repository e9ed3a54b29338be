"""Is the sampled closed loop stable at its control rate, and if not, at which would it be?

The loop is linearised in every mode the transmission can be in (free rotor, each stiffness
segment), the plant discretised exactly for held voltages, and the cascade added as it is sampled.
Limits, backlash and the d axis do not enter a linearisation.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import scipy

from ..errors import InputError
from .packed import pack
from .parameters import DriveParameters

# A mode may grow by this rate, 1/s, and still pass: an undamped load on its spring is neutrally
# stable, and a sampled loop moves such a mode by a little either way.
GROWTH_ALLOWED = 1.0

_HIGHEST_RATE = 1e7  # Hz; a loop unstable here is unstable in continuous time too


def _plant_matrices(p: np.record, stiffness: float) -> tuple[np.ndarray, np.ndarray]:
    """Continuous plant for one mode: states theta_r, w_r, (theta_l, w_l,) i_q; input u_q."""
    electrical = [
        -p["back_emf_constant"] * p["per_inductance"],
        -p["resistance"] * p["per_inductance"],
    ]
    drag, torque = -p["rotor_viscous"], p["torque_constant"]
    if stiffness == 0.0:  # the load is adrift; the loop only holds the rotor
        a = np.zeros((3, 3))
        a[0, 1] = 1.0
        a[1] = [0.0, drag, torque]
        a[1] *= p["per_rotor_inertia"]
        a[2, 1:] = electrical
        return a, np.array([0.0, 0.0, p["per_inductance"]])
    damping = p["contact_damping"]
    a = np.zeros((5, 5))
    a[0, 1] = a[2, 3] = 1.0
    a[1] = [-stiffness, drag - damping, stiffness, damping, torque]
    a[1] *= p["per_rotor_inertia"]
    a[3] = [stiffness, damping, -stiffness, -damping - p["load_viscous"], 0.0]
    a[3] *= p["per_load_inertia"]
    a[4, [1, 4]] = electrical
    return a, np.array([0.0, 0.0, 0.0, 0.0, p["per_inductance"]])


def closed_loop_matrix(drive: DriveParameters, stiffness: float) -> np.ndarray:
    """One-tick map of the closed loop with the transmission at `stiffness` N m/rad (0: free).

    States: plant, then integrals of position, speed and current loop, then the delayed voltages,
    then what the cascade remembers of the last tick as far as it is used: the encoder's angle, the
    filtered speed, the filtered current asked for.
    """
    p = pack(drive)[0]
    a, b = _plant_matrices(p, stiffness)
    order = len(b)
    held = np.zeros((order + 1, order + 1))
    held[:order, :order], held[:order, order] = a, b
    step = scipy.linalg.expm(held * p["tick"])
    delay = drive.controller.delay_ticks
    used = (p["speed_by_differences"] != 0, p["speed_kept"] > 0.0, p["current_command_kept"] > 0.0)
    size = order + 3 + delay + sum(used)
    pick = np.eye(size)  # row k picks state k
    position, speed, current = pick[order : order + 3]
    angle, rate, amperes = pick[[0, 1, order - 1]]
    last_angle, last_speed, last_current = _remembered(pick, order + 3 + delay, used)
    loop = np.zeros((size, size))
    if used[0]:
        rate = (angle - last_angle) / p["tick"]
        loop += np.outer(last_angle, angle)
    if used[1]:
        rate = p["speed_kept"] * last_speed + (1.0 - p["speed_kept"]) * rate
        loop += np.outer(last_speed, rate)
    if p["feedback_rod"] and stiffness > 0.0:
        angle = pick[2]
    wanted = -p["position_kp"] * angle + p["position_ki"] * position - p["position_kd"] * rate
    speed_error = np.zeros(size)
    if not p["position_to_current"]:
        speed_error = wanted - rate
        wanted = p["speed_kp"] * speed_error + p["speed_ki"] * speed
    if used[2]:
        kept = p["current_command_kept"]
        wanted = kept * last_current + (1.0 - kept) * wanted
        loop += np.outer(last_current, wanted)
    current_error = wanted - amperes
    voltage = p["current_kp"] * current_error + p["current_ki"] * current
    applied = pick[order + 3] if delay else voltage
    loop[:order, :order] = step[:order, :order]
    loop[:order] += np.outer(step[:order, order], applied)
    for row, (integral, error) in enumerate(
        [(position, -angle), (speed, speed_error), (current, current_error)], start=order
    ):
        loop[row] = integral + p["tick"] * error
    for slot in range(delay):  # the queue of voltages on their way
        loop[order + 3 + slot] = pick[order + 4 + slot] if slot + 1 < delay else voltage
    return loop


def _remembered(pick: np.ndarray, first: int, used: tuple[bool, ...]) -> list[np.ndarray]:
    """Rows that pick the remembered values from state `first` on; zeros for one not used."""
    rows, place = [], first
    for one in used:
        rows.append(pick[place] if one else np.zeros(len(pick)))
        place += bool(one)
    return rows


def growth_rate(drive: DriveParameters) -> float:
    """Fastest growth of the sampled closed loop over all modes, 1/s; negative is decay.

    Poles at one that belong to an integrator the gains do not use (ki = 0) do not count, nor does
    the free load.
    """
    stiffnesses = (0.0, *drive.transmission.stiffness)
    fastest = -math.inf
    for stiffness in stiffnesses:
        if stiffness == 0.0 and drive.transmission.backlash == 0.0:
            continue  # never free
        if stiffness == 0.0 and drive.controller.feedback == "rod":
            continue  # the position loop is open there, by construction
        radius = np.abs(np.linalg.eigvals(closed_loop_matrix(drive, stiffness)))
        fastest = max(fastest, math.log(max(radius.max(), 1e-300)) * drive.controller.rate)
    return fastest


def is_stable(drive: DriveParameters) -> bool:
    """Whether no mode of the sampled closed loop grows faster than `GROWTH_ALLOWED`."""
    return growth_rate(drive) <= GROWTH_ALLOWED


def at_rate(drive: DriveParameters, rate: float) -> DriveParameters:
    """The same drive sampled at `rate` Hz."""
    return dataclasses.replace(drive, controller=dataclasses.replace(drive.controller, rate=rate))


def smallest_stable_rate(drive: DriveParameters) -> float | None:
    """Smallest control rate, Hz, from which on the loop stays stable; None if there is none.

    Found by walking down from a high rate on a grid of 5 % and refining the edge to 0.1 %.
    """
    rate = _HIGHEST_RATE
    if not is_stable(at_rate(drive, rate)):
        return None
    while rate > 1.0 and is_stable(at_rate(drive, rate / 1.05)):
        rate /= 1.05
    low, high = rate / 1.05, rate
    while high / low > 1.001:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if is_stable(at_rate(drive, middle)) else (middle, high)
    return high


def _filtered(drive: DriveParameters) -> bool:
    """Whether a filter stands in the loop."""
    p = pack(drive)[0]
    return bool(p["speed_kept"] > 0.0 or p["current_command_kept"] > 0.0)


def check_stability(drive: DriveParameters, source: str) -> None:
    """Raise InputError naming the smallest stable rate if the sampled loop is unstable."""
    if is_stable(drive):
        return
    controller = drive.controller
    least = smallest_stable_rate(drive)
    start = f"{source}: controller.rate = {controller.rate:g} Hz: the sampled loop is unstable"
    if least is None:
        filters = "shorter filters, " if _filtered(drive) else ""
        raise InputError(
            f"{start} and no rate makes it stable; expected {filters}other gains or "
            f"another controller.feedback than {controller.feedback}"
        )
    delay = f" with delay_ticks = {controller.delay_ticks}" if controller.delay_ticks else ""
    raise InputError(f"{start}; expected at least {math.ceil(least)} Hz for these gains{delay}")
