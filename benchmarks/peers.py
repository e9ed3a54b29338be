"""Other simulators of motor drives on the nearest problem they can pose, one per call.

Run by `engine.py` in an environment of its own: `python peers.py NAME SECONDS PARAMETERS`, with the
drive's parameters as JSON; prints one line of JSON with wall time and steps. This file must not
import ecyl_ros, which is not there.
"""

from __future__ import annotations

import json
import math
import sys
import time
from types import SimpleNamespace

SPEED_RAD_S = 0.085  # amplitude of the rotor speed in the paper's sine, 1 Hz
VOLTAGE_V = 300.0


def motulator(seconds: float, p: SimpleNamespace) -> tuple[float, int]:
    """PMSM, two masses on a spring, speed and current control at every step."""
    from motulator.drive import model
    from motulator.drive.control import sm
    from motulator.drive.utils import SynchronousMachinePars, TwoMassMechanicalSystemPars

    machine = SynchronousMachinePars(
        n_p=p.pole_pairs,
        R_s=p.resistance,
        L_d=p.inductance,
        L_q=p.inductance,
        psi_f=p.torque_constant / (1.5 * p.pole_pairs),
    )
    shaft = TwoMassMechanicalSystemPars(
        J_M=p.rotor_inertia, J_L=p.load_inertia, K_S=p.stiffness, C_S=0.0
    )
    drive = model.Drive(
        model.VoltageSourceConverter(u_dc=VOLTAGE_V),
        model.SynchronousMachine(machine),
        model.TwoMassMechanicalSystem(shaft),
    )
    limits = sm.CurrentReferenceCfg(machine, max_i_s=60.0, nom_w_m=100.0)
    control = sm.CurrentVectorControl(
        machine, limits, T_s=p.step_s, J=p.rotor_inertia + p.load_inertia, sensorless=False
    )
    control.ref.w_m = lambda t: p.pole_pairs * SPEED_RAD_S * math.cos(2 * math.pi * t)
    simulation = model.Simulation(drive, control)
    begin = time.perf_counter()
    simulation.simulate(t_stop=seconds)
    return time.perf_counter() - begin, round(seconds / p.step_s)


def gym_electric_motor(seconds: float, p: SimpleNamespace) -> tuple[float, int]:
    """PMSM on a rigid inertia; the dq current and speed loops are ours, its toolbox has none."""
    import gym_electric_motor as gem
    import numpy as np
    from gym_electric_motor.physical_system_wrappers import DqToAbcActionProcessor
    from gym_electric_motor.reference_generators import ConstReferenceGenerator

    environment = gem.make(
        "Cont-SC-PMSM-v0",
        tau=p.step_s,
        motor={
            "motor_parameter": {
                "p": p.pole_pairs,
                "r_s": p.resistance,
                "l_d": p.inductance,
                "l_q": p.inductance,
                "psi_p": p.torque_constant / (1.5 * p.pole_pairs),
                "j_rotor": p.rotor_inertia,
            }
        },
        load={"load_parameter": {"a": 0.0, "b": 0.0, "c": 0.0, "j_load": p.load_inertia}},
        supply={"u_nominal": VOLTAGE_V},
        reference_generator=ConstReferenceGenerator(reference_state="omega", reference_value=0.0),
        physical_system_wrappers=(DqToAbcActionProcessor.make("PMSM"),),
        visualization=(),
        constraints=(),
    )
    environment = environment.unwrapped  # without gymnasium's checks of every step
    system = environment.physical_system
    names = list(system.state_names)
    omega, i_d, i_q = (names.index(name) for name in ("omega", "i_sd", "i_sq"))
    limits = system.limits
    (state, _), _ = environment.reset()
    steps = round(seconds / p.step_s)
    speed_sum = d_sum = q_sum = 0.0
    kp, ki = 7.0, 2260.0  # V/A, V/(A s)
    begin = time.perf_counter()
    for step in range(steps):
        wanted = SPEED_RAD_S * math.cos(2 * math.pi * step * p.step_s)
        speed_error = wanted - state[omega] * limits[omega]
        q_error = 0.8 * speed_error + 24.0 * speed_sum - state[i_q] * limits[i_q]
        d_error = -state[i_d] * limits[i_d]
        action = np.array([kp * d_error + ki * d_sum, kp * q_error + ki * q_sum]) * 2 / VOLTAGE_V
        speed_sum += speed_error * p.step_s
        d_sum += d_error * p.step_s
        q_sum += q_error * p.step_s
        (state, _), _, _, _, _ = environment.step(np.clip(action, -1.0, 1.0))
    return time.perf_counter() - begin, steps


PEERS = {"motulator": motulator, "gym-electric-motor": gym_electric_motor}


def main() -> None:
    """Run the peer named on the command line."""
    name, seconds, parameters = sys.argv[1], float(sys.argv[2]), json.loads(sys.argv[3])
    wall_s, steps = PEERS[name](seconds, SimpleNamespace(**parameters))
    print(json.dumps({"wall_s": wall_s, "steps": steps}))


if __name__ == "__main__":
    main()
