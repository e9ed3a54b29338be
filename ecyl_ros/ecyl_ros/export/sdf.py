"""A drive as SDF 1.11, the format of Gazebo Sim."""

from __future__ import annotations

from . import links
from .markup import attributes, comment
from .mechanism import Joint, Mechanism

_CONTROLLER = (
    'filename="gz-sim-joint-position-controller-system" '
    'name="gz::sim::systems::JointPositionController"'
)


def sdf(mechanism: Mechanism) -> str:
    """The drive as one SDF file: a model that stands on the world, its servo as a Gazebo system."""
    body = []
    base = _link("base_link", None)
    for joint in links.joints(mechanism):
        body += [_link(f"{joint.name}_link", joint), _joint(joint, mechanism)]
    return (
        '<?xml version="1.0"?>\n<sdf version="1.11">\n'
        f"{comment(left_out(mechanism))}\n  <model {attributes(name=mechanism.name)}>\n"
        '    <joint name="world" type="fixed">\n      <parent>world</parent>\n'
        "      <child>base_link</child>\n    </joint>\n"
        + "\n".join([base, *body, *_servo(mechanism)])
        + "\n  </model>\n</sdf>\n"
    )


def left_out(mechanism: Mechanism) -> tuple[str, ...]:
    """What SDF cannot express of this drive, one sentence each."""
    told = links.left_out(mechanism, servo=True)
    if mechanism.output.constant:
        told.append(f"constant load of {mechanism.output.constant:g}")
    return tuple(told)


def _link(name: str, joint: Joint | None) -> str:
    if joint is None:
        radius, length, middle = links.HOUSING_RADIUS, links.HOUSING_LENGTH, 0.0
        mass, inertia = 1.0, 1.0  # fixed to the world: any will do
    else:
        radius, length, middle = links.shape(joint)
        mass, inertia = links.about_axis(joint)
    across = inertia / 2.0 + mass * length**2 / 12.0
    return (
        f'    <link name="{name}">\n      <inertial>\n        <pose>{middle!r} 0 0 0 0 0</pose>\n'
        f"        <mass>{mass!r}</mass>\n        <inertia><ixx>{inertia!r}</ixx><ixy>0</ixy>"
        f"<ixz>0</ixz><iyy>{across!r}</iyy><iyz>0</iyz><izz>{across!r}</izz></inertia>\n"
        f'      </inertial>\n      <visual name="{name}_shape">\n'
        f"        <pose>{middle!r} 0 0 0 1.5707963267948966 0</pose>\n"
        f"        <geometry><cylinder><radius>{radius!r}</radius><length>{length!r}</length>"
        "</cylinder></geometry>\n      </visual>\n    </link>"
    )


def _joint(joint: Joint, mechanism: Mechanism) -> str:
    limits = {
        "lower": joint.low,
        "upper": joint.high,
        "effort": joint.effort,
        "velocity": joint.speed,
    }
    given = "".join(
        f"<{key}>{value!r}</{key}>" for key, value in limits.items() if value is not None
    )
    if not joint.linear and "lower" not in given:
        kind = "continuous"
    else:
        kind = "prismatic" if joint.linear else "revolute"
    mimic = ""
    if joint is mechanism.output and mechanism.contact is not None:
        ratio = mechanism.contact.rod_per_rotor
        mimic = (
            f'\n        <mimic joint="rotor"><multiplier>{ratio!r}</multiplier>'
            "<offset>0</offset><reference>0</reference></mimic>"
        )
    return (
        f'    <joint name="{joint.name}" type="{kind}">\n      <parent>base_link</parent>\n'
        f"      <child>{joint.name}_link</child>\n      <axis>\n        <xyz>1 0 0</xyz>\n"
        + (f"        <limit>{given}</limit>\n" if given else "")
        + f"        <dynamics><damping>{joint.damping!r}</damping>"
        f"<friction>{joint.friction!r}</friction>"
        f"<spring_reference>0</spring_reference><spring_stiffness>{joint.stiffness!r}"
        f"</spring_stiffness></dynamics>{mimic}\n      </axis>\n    </joint>"
    )


def _servo(mechanism: Mechanism) -> list[str]:
    """Gazebo's PID of position, on the joint that the motor turns, in that joint's units."""
    if mechanism.servo is None:
        return []
    driven = mechanism.rotor or mechanism.output
    scale = 1.0 if mechanism.contact is None else mechanism.contact.rod_per_rotor**2
    given = {
        "joint_name": driven.name,
        "p_gain": scale * mechanism.servo.kp,
        "i_gain": 0.0,
        "d_gain": scale * mechanism.servo.kv,
    }
    if driven.effort is not None:
        given |= {"cmd_max": driven.effort, "cmd_min": -driven.effort}
    inner = "".join(f"\n      <{key}>{value}</{key}>" for key, value in given.items())
    return [f"    <plugin {_CONTROLLER}>{inner}\n    </plugin>"]
