"""A drive as MJCF, MuJoCo's format.

Backlash and flank are the limit of a tendon: between rotor and rod a fixed tendon measures the
twist, free within the clearance. MuJoCo's constraint holds its limit by the acceleration
-(b v + k r) / d, weighed by the impedance d against what the joints would do of themselves. With
the smallest impedance that it allows, and k, b scaled by the joints' mobility A, this is the force
K r + D v to a share d; it pushes and never pulls. Without clearance the tendon is a spring with its
damper.
"""

from __future__ import annotations

from .markup import attributes, comment
from .mechanism import Contact, Joint, Mechanism

ACTUATORS = ("servo", "motor")
_IMPEDANCE = 1e-4  # the smallest that MuJoCo takes (mjMINIMP)
_SLIM = 1e-6  # of a hinge's inertia: mass that a body must have beside its inertia


def mjcf(mechanism: Mechanism, actuator: str = "servo") -> str:
    """The drive as one MJCF file.

    actuator: `servo`, the position loop: its control is the wanted position of the output in m or
    rad; or `motor`: the control is what the motor is told, A as a rule.
    """
    joints = [one for one in (mechanism.rotor, mechanism.output) if one is not None]
    lines = [
        f"<mujoco {attributes(model=mechanism.name)}>",
        comment(left_out(mechanism, actuator)),
        '  <compiler angle="radian" autolimits="true"/>',
        f"  <option {attributes(timestep=mechanism.step_s, integrator='RK4')}/>",
        "  <worldbody>",
        *(line for one in joints for line in _body(one)),
        "  </worldbody>",
    ]
    if mechanism.contact is not None and mechanism.rotor is not None:
        mobility = 1.0 / mechanism.rotor.inertia + 1.0 / (
            mechanism.output.inertia * mechanism.contact.rod_per_rotor**2
        )
        lines += _tendon(mechanism.contact, mobility)
    lines += ["  <actuator>", *_actuators(mechanism, actuator), "  </actuator>", "  <sensor>"]
    for one in joints:
        lines.append(f'    <jointpos name="{one.name}_position" joint="{one.name}"/>')
        lines.append(f'    <jointvel name="{one.name}_velocity" joint="{one.name}"/>')
    return "\n".join([*lines, "  </sensor>", "</mujoco>"]) + "\n"


def left_out(mechanism: Mechanism, actuator: str = "servo") -> tuple[str, ...]:
    """What MJCF cannot express of this drive, one sentence each."""
    told = list(mechanism.left_out)
    if actuator == "motor" and mechanism.servo is not None:
        told.append("the position loop: the actuator is the bare motor")
    if mechanism.output.speed is not None:
        told.append(f"largest speed of setpoints, {mechanism.output.speed:g} m/s")
    return tuple(told)


def _body(joint: Joint) -> list[str]:
    mass = joint.inertia if joint.linear else _SLIM * joint.inertia
    inertia = " ".join([repr(joint.inertia)] * 3) if not joint.linear else "1 1 1"
    own = {
        "name": joint.name,
        "type": "slide" if joint.linear else "hinge",
        "axis": "1 0 0",
        "damping": joint.damping,
        "frictionloss": joint.friction,
        "stiffness": joint.stiffness,
    }
    if joint.low is not None and joint.high is not None:
        own["range"] = f"{joint.low!r} {joint.high!r}"
    return [
        f'    <body name="{joint.name}_body">',
        f'      <inertial pos="0 0 0" {attributes(mass=mass, diaginertia=inertia)}/>',
        f"      <joint {attributes(**own)}/>",
        "    </body>",
    ]


def _tendon(contact: Contact, mobility: float) -> list[str]:
    if contact.backlash > 0.0:
        half = 0.5 * contact.backlash
        said = "beyond its range the flanks touch"
        own = {
            "range": f"{-half!r} {half!r}",
            "solreflimit": f"{-contact.stiffness * mobility!r} {-contact.damping * mobility!r}",
            "solimplimit": f"{_IMPEDANCE} {_IMPEDANCE} 0.001 0.5 1",
        }
    else:
        said = "no clearance, the flanks never part"
        own = {
            "springlength": "0",
            "stiffness": repr(contact.stiffness),
            "damping": repr(contact.damping),
        }
    return [
        "  <tendon>",
        f"    <!-- rotor less load, rad at the rotor; {said} -->",
        f"    <fixed {attributes(name='twist', **own)}>",
        '      <joint joint="rotor" coef="1"/>',
        f'      <joint joint="rod" {attributes(coef=-1.0 / contact.rod_per_rotor)}/>',
        "    </fixed>",
        "  </tendon>",
    ]


def _actuators(mechanism: Mechanism, kind: str) -> list[str]:
    output, lines = mechanism.output, []
    driven = mechanism.rotor or output
    # The servo works in the output's units: its gear is what an output's unit is of the rotor's.
    gear = 1.0 if mechanism.contact is None else mechanism.contact.rod_per_rotor
    if kind == "servo" and mechanism.servo is not None:
        own: dict[str, float | str] = {
            "name": "servo",
            "joint": driven.name,
            "gear": gear,
            "kp": mechanism.servo.kp,
            "kv": mechanism.servo.kv,
        }
        if output.low is not None and output.high is not None:
            own["ctrlrange"] = f"{output.low!r} {output.high!r}"
        if output.effort is not None:
            own["forcerange"] = f"{-output.effort!r} {output.effort!r}"
        lines.append(f"    <position {attributes(**own)}/>")
    else:
        own = dict[str, float | str](name="motor", joint=driven.name, gear=mechanism.gain)
        if mechanism.signal_limit is not None:
            own["ctrlrange"] = f"{-mechanism.signal_limit!r} {mechanism.signal_limit!r}"
        lines.append(f"    <!-- control in {mechanism.signal} -->")
        lines.append(f"    <motor {attributes(**own)}/>")
    if output.constant:
        lines.append(
            f'    <general name="constant_load" joint="{output.name}" gainprm="0" '
            f'biastype="affine" biasprm="{-output.constant!r} 0 0"/>'
        )
    return lines
