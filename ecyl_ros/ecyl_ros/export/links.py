"""What URDF and SDF share: links with masses and shapes, the rod driven by the rotor."""

from __future__ import annotations

from .mechanism import Joint, Mechanism

# Shapes to look at, m: a housing, a rotor within, a rod that comes out. The drive file knows none.
HOUSING_LENGTH, HOUSING_RADIUS, ROTOR_RADIUS, ROD_RADIUS = 0.3, 0.05, 0.03, 0.02
ROD_LENGTH = 0.3
UNBOUNDED = 1e9  # where nothing limits an effort, speed or travel, and the format wants a number


def joints(mechanism: Mechanism) -> list[Joint]:
    """Rotor and rod, or the one joint of a rigid drive."""
    return [one for one in (mechanism.rotor, mechanism.output) if one is not None]


def shape(joint: Joint) -> tuple[float, float, float]:
    """Radius and length of the link's cylinder, m, and where its middle is along the axis."""
    if joint.linear:
        return ROD_RADIUS, ROD_LENGTH, 0.5 * HOUSING_LENGTH
    return ROTOR_RADIUS, 0.2 * HOUSING_LENGTH, -0.3 * HOUSING_LENGTH


def about_axis(joint: Joint) -> tuple[float, float]:
    """Mass in kg and inertia about the axis in kg m^2 of the joint's link.

    A hinge gets the mass, a slide the inertia, of a solid cylinder of its shape's radius.
    """
    radius = shape(joint)[0]
    if joint.linear:
        return joint.inertia, 0.5 * joint.inertia * radius**2
    return 2.0 * joint.inertia / radius**2, joint.inertia


def left_out(mechanism: Mechanism, servo: bool) -> list[str]:
    """What a format with joints and mimic, but neither contact nor spring between them, loses.

    servo: whether the format has a word for the position loop.
    """
    told = list(mechanism.left_out)
    contact = mechanism.contact
    if contact is not None:
        told.append(
            f"backlash of {contact.backlash:g} rad, stiffness of {contact.stiffness:g} N m/rad and "
            f"contact damping of {contact.damping:g} N m s/rad: the rod follows the rotor rigidly"
        )
    if mechanism.servo is not None and not servo:
        told.append(
            f"gains of the servo: {mechanism.servo.kp:g} per error and {mechanism.servo.kv:g} per "
            "speed at the output"
        )
    return told
