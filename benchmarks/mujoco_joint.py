"""One joint in MuJoCo: a drive as MJCF, fitted by `mujoco.sysid`, simulated and inverted.

Run by `sysid_peer.py` in an environment of its own, as `mujoco_joint.py PROBLEM.npz ANSWER.npz`;
prints one line of JSON. This file must not import ecyl_ros, which is not there; `mujoco` is
imported where it is needed, so that the mapping can be read without it.

The joint has one inertia (a hinge's `armature`, a slide's body mass: on a slide without it MuJoCo's
friction hardly acts), `damping`, `frictionloss`, `stiffness`, and an actuator of unit gain with a
bias. The gain itself is not fitted: beside free inertia and friction it says nothing more (see
"Identifiability" in the toolbox's documentation).
"""

from __future__ import annotations

import contextlib
import json
import logging
import math
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

PARAMETERS = ("inertia", "damping", "frictionloss", "stiffness", "bias")
STEP_S = 1e-3  # of the simulation at the most; a whole number of them to a sample
_SMALL = 1e-6  # of the inertia: MuJoCo wants a body to have some of both


def mjcf(
    linear: bool, values: Mapping[str, float], step_s: float = STEP_S, springref: float = 0.0
) -> str:
    """The joint as MJCF.

    linear: a slide, else a hinge. values: of `PARAMETERS`, SI; inertia is all that moves (kg or
    kg m^2), bias an effort added to the commanded one (N or N m), hence less the constant load.
    springref: where the spring is slack, m or rad.
    """
    inertia = values["inertia"]
    small = _SMALL * inertia
    mass, armature = (inertia, 0.0) if linear else (small, inertia)
    return f"""\
<mujoco model="drive">
  <compiler angle="radian"/>
  <option timestep="{step_s!r}" integrator="implicitfast" gravity="0 0 0">
    <flag contact="disable"/>
  </option>
  <worldbody>
    <body name="output">
      <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{small!r} {small!r} {small!r}"/>
      <joint name="joint" type="{"slide" if linear else "hinge"}" axis="0 0 1"
             armature="{armature!r}" damping="{values["damping"]!r}"
             frictionloss="{values["frictionloss"]!r}"
             stiffness="{values["stiffness"]!r}" springref="{springref!r}"/>
    </body>
  </worldbody>
  <actuator>
    <general name="drive" joint="joint" gainprm="1" biastype="affine" biasprm="{values["bias"]!r}"/>
  </actuator>
  <sensor>
    <jointpos name="position" joint="joint"/>
    <jointvel name="velocity" joint="joint"/>
  </sensor>
</mujoco>
"""


@dataclass(frozen=True, eq=False)
class Problem:
    """A recording of one drive, as both it and its simulation are posed.

    Attributes:
        linear: a slide, else a hinge.
        rate_hz: of the samples.
        effort, position, velocity: float64[n], what drives the joint and what it is to follow.
        smooth_position, acceleration: float64[n], low-passed; `velocity` is, too.
        fitted, held_out: int64[k, 2], windows: first sample, and the one behind the last. Each is
            begun at the measured state: `smooth_position` and `velocity` of its first sample.
        scale: of position and velocity, by which their errors are divided.
        start: values of `PARAMETERS` to begin with.
        low, high: their bounds. springref: m or rad.
    """

    linear: bool
    rate_hz: float
    effort: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    smooth_position: np.ndarray
    acceleration: np.ndarray
    fitted: np.ndarray
    held_out: np.ndarray
    scale: np.ndarray
    start: np.ndarray
    low: np.ndarray
    high: np.ndarray
    springref: float

    @property
    def step_s(self) -> float:
        """Of the simulation: a whole number of them to a sample."""
        return 1.0 / (self.rate_hz * math.ceil(1.0 / (self.rate_hz * STEP_S) - 1e-9))

    def mjcf(self, values: np.ndarray) -> str:
        """The joint with these values of `PARAMETERS`."""
        named = {name: float(one) for name, one in zip(PARAMETERS, values, strict=True)}
        return mjcf(self.linear, named, self.step_s, self.springref)


def read(path: Path) -> Problem:
    """The problem that `sysid_peer.py` has written."""
    with np.load(path) as held:
        fields = {name: held[name] for name in held.files}
    for name in ("linear", "rate_hz", "springref"):
        fields[name] = fields[name].item()
    return Problem(**fields)


def _states(problem: Problem, model: Any, windows: np.ndarray) -> list[np.ndarray]:
    from mujoco import sysid

    return [
        sysid.create_initial_state(
            model, problem.smooth_position[[first]], problem.velocity[[first]]
        )
        for first, _ in windows
    ]


def fit(problem: Problem, **options: Any) -> tuple[np.ndarray, dict[str, float]]:
    """Values of `PARAMETERS` by `mujoco.sysid`, and how they came about.

    Every fitted window is a sequence of its own; the residual is the position's and the velocity's,
    each over its scale. options: for `sysid.optimize`.
    """
    import mujoco
    from mujoco import sysid

    logging.disable(logging.WARNING)
    spec = mujoco.MjSpec.from_string(problem.mjcf(problem.start))
    model = spec.compile()

    def set_bias(spec: Any, parameter: Any) -> None:
        spec.actuator("drive").biasprm[0] = parameter.value[0]

    def set_inertia(spec: Any, parameter: Any) -> None:
        if problem.linear:
            spec.body("output").mass = parameter.value[0]
        else:
            spec.joint("joint").armature = parameter.value[0]

    def set_joint(name: str) -> Any:
        def write(spec: Any, parameter: Any) -> None:
            held = getattr(spec.joint("joint"), name)
            if isinstance(held, np.ndarray):  # a polynomial: this is its first coefficient
                held[0] = parameter.value[0]
            else:
                setattr(spec.joint("joint"), name, parameter.value[0])

        return write

    setters = {"inertia": set_inertia, "bias": set_bias}
    parameters = sysid.ParameterDict()
    for index, name in enumerate(PARAMETERS):
        parameters.add(
            sysid.Parameter(
                name,
                nominal=problem.start[index],
                min_value=problem.low[index],
                max_value=problem.high[index],
                modifier=setters.get(name) or set_joint(name),
            )
        )
    # Compared with the state, for a sensor's value is that of the step before.
    kinds = sysid.SignalType.MjStateQPos, sysid.SignalType.MjStateQVel
    signals = [("joint_qpos", 1, kinds[0]), ("joint_qvel", 1, kinds[1])]
    controls, measured, names = [], [], []
    for first, behind in problem.fitted.tolist():
        times = np.arange(behind - first) / problem.rate_hz
        rows = slice(first, behind)
        controls.append(
            sysid.TimeSeries.from_control_names(times, problem.effort[rows, None], model)
        )
        seen = np.stack([problem.position[rows], problem.velocity[rows]], axis=1)
        measured.append(sysid.TimeSeries.from_custom_map(times, seen, signals))
        names.append(f"from_{first}")
    sequences = sysid.ModelSequences(
        "drive", spec, names, _states(problem, model, problem.fitted), controls, measured
    )
    made: dict[bytes, Any] = {}

    def build(parameters: Any, spec: Any) -> Any:
        """The toolbox builds a model for each sequence; all of ours have the same."""
        key = parameters.as_vector().tobytes()
        if key not in made:
            if len(made) > 4 * len(PARAMETERS):
                made.clear()
            made[key] = sysid.apply_param_modifiers(parameters, spec)
        return made[key]

    def weigh(
        parameters: Any, predicted: Any, measured: Any, model: Any, everything: bool, state: Any
    ) -> Any:
        """What is judged, in place of the default: that scales every sequence by itself."""
        times = measured.times[1:]  # the first is where it begins
        at = np.stack([np.interp(times, state[:, 0], state[:, one]) for one in (1, 2)], axis=1)
        seen = sysid.TimeSeries(times, measured.data[1:], measured.signal_mapping)
        told = sysid.TimeSeries(times, at, measured.signal_mapping)
        return (seen.data - told.data) / problem.scale, told, seen

    # One thread: more would be started and ended for every window, which takes longer.
    residual = sysid.build_residual_fn(
        models_sequences=[sequences], build_model=build, modify_residual=weigh, n_threads=1
    )
    before = _cost(residual, parameters)
    begun = parameters.copy().move_off_bounds()  # as the toolbox advises
    with contextlib.redirect_stdout(sys.stderr):  # it prints its iterations
        found, _ = sysid.optimize(begun, residual, verbose=False, **options)
    after = _cost(residual, found)
    return found.as_vector(), {"rms_start": before, "rms_fitted": after}


def _cost(residual: Any, parameters: Any) -> float:
    values = np.concatenate(
        [one.ravel() for one in residual(parameters.as_vector(), parameters)[0]]
    )
    return float(np.sqrt(np.mean(values**2)))


def simulate(problem: Problem, values: np.ndarray, windows: np.ndarray) -> np.ndarray:
    """Position and velocity at every sample, float64[n, 2]; NaN outside the windows."""
    import mujoco
    from mujoco import rollout

    model = mujoco.MjModel.from_xml_string(problem.mjcf(values))
    data = mujoco.MjData(model)
    ticks = round(1.0 / (problem.rate_hz * problem.step_s))
    found = np.full((problem.effort.size, 2), np.nan)
    states = _states(problem, model, windows)
    for (first, behind), state in zip(windows.tolist(), states, strict=True):
        at = np.arange((behind - first - 1) * ticks) / ticks
        control = np.interp(at, np.arange(behind - first), problem.effort[first:behind])
        steps, _ = rollout.rollout(model, data, state, control[:, None])
        found[first] = problem.smooth_position[first], problem.velocity[first]
        found[first + 1 : behind] = steps[0, ticks - 1 :: ticks, 1:3]
    return found


def inverse(problem: Problem, values: np.ndarray) -> np.ndarray:
    """The effort that the recorded motion asks for, float64[n], by MuJoCo's inverse dynamics."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(problem.mjcf(values))
    data = mujoco.MjData(model)
    bias = values[PARAMETERS.index("bias")]
    found = np.empty(problem.effort.size)
    motion = problem.smooth_position, problem.velocity, problem.acceleration
    for index, (position, velocity, acceleration) in enumerate(zip(*motion, strict=True)):
        data.qpos[0], data.qvel[0], data.qacc[0] = position, velocity, acceleration
        mujoco.mj_inverse(model, data)
        found[index] = data.qfrc_inverse[0] - bias
    return found


def main() -> None:
    """Fit one problem; the answer holds the found values and what they and the start come to."""
    import mujoco

    problem = read(Path(sys.argv[1]))
    begin = time.perf_counter()
    values, course = fit(problem)
    seconds = time.perf_counter() - begin
    np.savez(
        sys.argv[2],
        values=values,
        motion=simulate(problem, values, problem.held_out),
        motion_start=simulate(problem, problem.start, problem.held_out),
        effort=inverse(problem, values),
        effort_start=inverse(problem, problem.start),
    )
    print(json.dumps({"seconds": seconds, "mujoco": mujoco.__version__, **course}))


if __name__ == "__main__":
    main()
