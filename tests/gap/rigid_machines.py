"""Rigid machines with a known fault, their effort by closed form: M a + what the fault asks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.gap.diagnosis import Cause, Diagnosis
from ecyl_ros.recording.signals import Recording

RATE_HZ = 1000.0
_FREQUENCIES = np.array([0.13, 0.31, 0.47, 0.73, 1.1, 1.7])
_SHARES = np.array([1.0, 0.6, 0.4, 0.3, 0.15, 0.1])


@dataclass(frozen=True)
class Motion:
    """Time, position, velocity, acceleration of a mixture of sines: float64[n]."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray


def motion(amplitude: float, seed: int = 3, duration_s: float = 20.0) -> Motion:
    """Smooth motion both ways at many speeds, with its exact derivatives."""
    rng = np.random.default_rng(seed)
    t = np.arange(int(duration_s * RATE_HZ)) / RATE_HZ
    w = 2.0 * np.pi * _FREQUENCIES[:, None]
    phase = w * t + rng.uniform(0.0, 6.28, 6)[:, None]
    size = amplitude * _SHARES[:, None]
    return Motion(
        t,
        (size * np.sin(phase)).sum(0),
        (size * w * np.cos(phase)).sum(0),
        (-size * w**2 * np.sin(phase)).sum(0),
    )


def along(v: np.ndarray) -> Motion:
    """The motion of a speed, float64[n], by its differences."""
    t = np.arange(v.size) / RATE_HZ
    return Motion(t, np.cumsum(v) / RATE_HZ, v, np.gradient(v, 1.0 / RATE_HZ))


def causes(result: Diagnosis) -> dict[str, Cause]:
    """What a diagnosis names, by effect."""
    return {one.effect: one for one in result.causes}


def recorded(
    m: Motion,
    effort: np.ndarray,
    machine: Machine,
    noise: float,
    step: float,
    seed: int = 7,
    mode: np.ndarray | None = None,
) -> Recording:
    """The motion by an encoder of `step`, the effort with white noise of `noise`."""
    rng = np.random.default_rng(seed)
    noisy = effort + noise * rng.normal(size=effort.size)
    names = {
        "force": "rod_force_n",
        "torque": "rotor_torque_nm",
        "current": "current_q_a",
        "voltage": "voltage_q_v",
    }
    position = "rod_position_m" if machine.linear else "rotor_position_rad"
    signals = {
        position: np.round(m.q / step) * step,
        names[machine.actuation or "force"]: noisy,
    }
    if mode is not None:
        signals["mode"] = mode
    return Recording(stamp_ns=np.round(m.t * 1e9).astype(np.int64), **signals)


LINEAR = Machine(kind="rigid", output="linear", actuation="force", gain=1.0, inertia=20.0)
ROTARY = Machine(kind="rigid", output="rotary", actuation="torque", gain=1.0, inertia=0.02)
