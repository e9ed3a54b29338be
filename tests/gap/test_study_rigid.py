"""Rigid drives of other equations with hidden faults: how they are drawn and how they move."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from ecyl_ros.gap.study.rigid.cases import draw, faults, play, seal
from ecyl_ros.gap.study.rigid.equations import STEP_S, Truth, run


def test_draws_hold_every_kind_and_repeat() -> None:
    """One seed, one hash; both outputs, every actuation, loops known and not; faults in turn."""
    cases = draw(60, 5)
    assert seal(cases) == seal(draw(60, 5)) != seal(draw(60, 6))
    assert {one.linear for one in cases} == {one.loop for one in cases} == {True, False}
    assert {one.actuation for one in cases} == {"force", "torque", "current", "loop"}
    assert {one.effect for one in cases if one.linear} >= set(faults(True))
    recording, machine = play(cases[0])
    again, _ = play(cases[0])
    assert machine.kind == "rigid"
    name = "rod_position_m" if cases[0].linear else "rotor_position_rad"
    assert np.array_equal(recording.signal(name), again.signal(name))


def test_the_drawn_machines_obey_their_equations() -> None:
    """Cogging, spring, disturbance and friction of a bristle: scipy's RK45 goes the same way."""
    truth = Truth(
        inertia=20.0,
        viscous=(30.0, 50.0),
        coulomb=(6.0, 9.0),
        cogging=(4.0, 500.0, 0.7),
        sine=(3.0, 25.0, 0.2),
        constant=2.0,
        stiffness=300.0,
        presliding=2e-4,
        position_kp=0.0,
        speed_kp=400.0,
        speed_ki=0.0,
        limit=1e9,
        control_steps=round(1e-3 / STEP_S),
    )
    ticks = 300
    wanted = 0.2 * np.sin(9.0 * np.arange(ticks) * 1e-3)
    rows = run(truth, np.zeros(ticks), wanted, np.zeros(ticks), 0.0)
    state = np.zeros(3)
    off = 0.0
    for tick in range(ticks):
        off = max(off, abs(state[0] - rows[tick, 3]))
        command = rows[tick, 2]

        def slope(t: float, s: np.ndarray, u: float = command) -> list[float]:
            q, v, z = s
            way = 0 if v >= 0.0 else 1
            load = 2.0 + 300.0 * q + 4.0 * np.sin(500.0 * q + 0.7) + 3.0 * np.sin(25.0 * t + 0.2)
            friction = (30.0, 50.0)[way] * v + (6.0, 9.0)[way] * z
            return [v, (u - load - friction) / 20.0, (v - abs(v) * z) / 2e-4]

        span = (tick * 1e-3, (tick + 1) * 1e-3)
        state = solve_ivp(slope, span, state, "RK45", rtol=1e-6, atol=1e-9).y[:, -1]
    assert np.ptp(rows[:, 3]) > 0.005
    assert off < 2e-3 * np.ptp(rows[:, 3])
