"""A drive as URDF, ready for robot_state_publisher.

The joints have the names of `/ecyl/joint_states`. The rod mimics the rotor: where its position is
published, robot_state_publisher takes that; where it is not, it follows the rotor.
"""

from __future__ import annotations

from . import links
from .markup import attributes, comment
from .mechanism import Joint, Mechanism


def urdf(mechanism: Mechanism) -> str:
    """The drive as one URDF file."""
    body = [_link("base_link", None)]
    for joint in links.joints(mechanism):
        body.append(_link(f"{joint.name}_link", joint))
        body.append(_joint(joint, mechanism))
    return (
        '<?xml version="1.0"?>\n'
        f"<robot {attributes(name=mechanism.name)}>\n{comment(left_out(mechanism))}\n"
        + "\n".join(body)
        + "\n</robot>\n"
    )


def left_out(mechanism: Mechanism) -> tuple[str, ...]:
    """What URDF cannot express of this drive, one sentence each."""
    told = links.left_out(mechanism, servo=False)
    if mechanism.output.stiffness:
        told.append(f"spring load of {mechanism.output.stiffness:g} per travel")
    if mechanism.output.constant:
        told.append(f"constant load of {mechanism.output.constant:g}")
    return tuple(told)


def _link(name: str, joint: Joint | None) -> str:
    if joint is None:  # no inertia: KDL, which robot_state_publisher uses, wants none at the root
        radius, length, middle = links.HOUSING_RADIUS, links.HOUSING_LENGTH, 0.0
        inertial = ""
    else:
        radius, length, middle = links.shape(joint)
        mass, inertia = links.about_axis(joint)
        across = inertia / 2.0 + mass * length**2 / 12.0
        moments = attributes(ixx=inertia, ixy=0.0, ixz=0.0, iyy=across, iyz=0.0, izz=across)
        inertial = (
            f'    <inertial>\n      <origin xyz="{middle!r} 0 0"/>\n'
            f"      <mass {attributes(value=mass)}/>\n      <inertia {moments}/>\n    </inertial>\n"
        )
    return (
        f'  <link name="{name}">\n{inertial}    <visual>\n'
        f'      <origin xyz="{middle!r} 0 0" rpy="0 1.5707963267948966 0"/>\n'
        f"      <geometry><cylinder {attributes(radius=radius, length=length)}/></geometry>\n"
        "    </visual>\n  </link>"
    )


def _joint(joint: Joint, mechanism: Mechanism) -> str:
    effort = links.UNBOUNDED if joint.effort is None else joint.effort
    speed = links.UNBOUNDED if joint.speed is None else joint.speed
    limit = {"effort": effort, "velocity": speed}
    if joint.linear:
        kind = "prismatic"
        limit["lower"] = -links.UNBOUNDED if joint.low is None else joint.low
        limit["upper"] = links.UNBOUNDED if joint.high is None else joint.high
    else:
        kind = "continuous"
    lines = [
        f'  <joint name="{joint.name}" type="{kind}">',
        f'    <parent link="base_link"/>\n    <child link="{joint.name}_link"/>',
        '    <axis xyz="1 0 0"/>',
        f"    <limit {attributes(**limit)}/>",
        f"    <dynamics {attributes(damping=joint.damping, friction=joint.friction)}/>",
    ]
    if joint is mechanism.output and mechanism.contact is not None:
        ratio = mechanism.contact.rod_per_rotor
        lines.append(f'    <mimic joint="rotor" {attributes(multiplier=ratio)}/>')
    return "\n".join([*lines, "  </joint>"])
