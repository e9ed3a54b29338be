"""Joint values of an MJCF or URDF file, as far as a rigid drive file has a place for them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import yaml

from ..errors import InputError

_LARGEST = 50_000_000  # bytes: a scene with its meshes inline
Element = ElementTree.Element


@dataclass(kw_only=True)
class JointValues:
    """One joint as its file has it; SI. None where the file does not say.

    Attributes:
        name: of the joint. linear: a slide, else a hinge.
        inertia: kg or kg m^2, of all that the file says moves with it.
        damping, friction, stiffness: per speed, level, of a spring.
        position_kp: 1/s. speed_kp: N s/m or N m s/rad: of a servo on the joint.
        effort: largest effort of the servo.
        remarks: what the file could not tell or has no place, one line each.
    """

    name: str
    linear: bool
    inertia: float | None = None
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    position_kp: float | None = None
    speed_kp: float | None = None
    effort: float | None = None
    remarks: list[str] = field(default_factory=list)


def read_joint(path: Path, name: str | None) -> JointValues:
    """The values of joint `name`, or of the only joint.

    Raises:
        InputError: unreadable, neither MJCF nor URDF, no such joint, or a value that is no number.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if len(data) > _LARGEST or b"<!ENTITY" in data:  # entities may grow without bounds
        raise InputError(f"{path}: expected MJCF or URDF of at most {_LARGEST} bytes, no entities")
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError) as error:
        raise InputError(f"{path}: no XML: {error}") from None
    if root.tag == "mujoco":
        return _Mjcf(path, root).joint(name)
    if root.tag == "robot":
        return _urdf(path, root, name)
    raise InputError(f"{path}: <{root.tag[:40]}>, expected MJCF (<mujoco>) or URDF (<robot>)")


def parameters(joint: JointValues) -> dict[str, str | float]:
    """The values by the dotted keys of a rigid drive file, effort in N or N m."""
    output, signal = ("linear", "force") if joint.linear else ("rotary", "torque")
    values: dict[str, str | float | None] = {
        "drive.kind": "rigid",
        "drive.output": output,
        "actuation.signal": signal,
        "load.mass" if joint.linear else "load.inertia": joint.inertia,
        "load.viscous_friction": joint.damping or None,
        "load.coulomb_friction": joint.friction or None,
        "load.stiffness": joint.stiffness or None,
    }
    if joint.position_kp is not None and joint.speed_kp is not None:
        values["controller.position.kp"] = joint.position_kp
        values["controller.speed.kp"] = joint.speed_kp
        values["controller.command_limit"] = joint.effort
    return {key: value for key, value in values.items() if value is not None}


def rigid_file(joint: JointValues, source: str) -> str:
    """A rigid drive file that begins with these values."""
    tree: dict[str, Any] = {}
    for key, value in parameters(joint).items():
        *groups, name = key.split(".")
        place = tree
        for group in groups:
            place = place.setdefault(group, {})
        place[name] = value
    head = (f"joint {joint.name} of {source}, as ecyl export --to rigid read it", *joint.remarks)
    lines = [
        "# " + "".join(letter if letter.isprintable() else " " for letter in line) for line in head
    ]
    body = yaml.safe_dump({"/**": {"ros__parameters": tree}}, sort_keys=False)
    return "\n".join(lines) + "\n" + body


def _numbers(text: str | None, count: int, where: str) -> list[float]:
    try:
        values = [float(word) for word in (text or "").split()]
    except ValueError:
        values = []
    if len(values) < count or not all(math.isfinite(value) for value in values):
        raise InputError(f"{where} = {(text or '')[:60]!r}, expected {count} finite numbers")
    return values


def _choose(path: Path, names: list[str], name: str | None) -> str:
    listed = ", ".join(names[:12]) or "none"
    if name is None:
        if len(names) != 1:
            raise InputError(f"{path}: {len(names)} joints that move ({listed}); expected --joint")
        return names[0]
    if name not in names:
        raise InputError(f"{path}: no joint {name[:60]} that slides or turns; there are {listed}")
    return name


class _Mjcf:
    """An MJCF file with its default classes."""

    def __init__(self, path: Path, root: Element) -> None:
        self._path, self._root = path, root
        if root.find(".//include") is not None or root.find(".//attach") is not None:
            raise InputError(
                f"{path}: takes in other files; expected one whole file (MuJoCo's "
                "mj_saveLastXML writes one)"
            )
        self._defaults: dict[str, dict[str, dict[str, str]]] = {"main": {}}
        for one in root.findall("default"):
            self._add_defaults(one, {}, one.get("class", "main"))

    def _add_defaults(
        self, element: Element, above: Mapping[str, dict[str, str]], name: str
    ) -> None:
        own = {tag: dict(values) for tag, values in above.items()}
        for child in element:
            if child.tag != "default":
                own.setdefault(child.tag, {}).update(child.attrib)
        self._defaults[name] = own
        for child in element.findall("default"):
            self._add_defaults(child, own, child.get("class", ""))

    def _full(self, element: Element, inherited: str, tag: str | None = None) -> dict[str, str]:
        """An element's attributes over those of its class."""
        chosen = self._defaults.get(element.get("class", inherited), {})
        return {**chosen.get(tag or element.tag, {}), **element.attrib}

    def joint(self, name: str | None) -> JointValues:
        found: dict[str, tuple[Element, dict[str, str]]] = {}

        def walk(body: Element, inherited: str) -> None:
            inherited = body.get("childclass", inherited)
            for one in body.findall("joint"):
                full = self._full(one, inherited)
                if full.get("type", "hinge") in ("hinge", "slide"):
                    found[full.get("name", f"joint {len(found) + 1}")] = body, full
            for child in body.findall("body"):
                walk(child, inherited)

        for world in self._root.findall("worldbody"):
            for body in world.findall("body"):
                walk(body, "main")
        chosen = _choose(self._path, list(found), name)
        body, full = found[chosen]
        linear = full.get("type", "hinge") == "slide"
        where = f"{self._path}: joint {chosen}"

        def number(key: str) -> float:  # of a polynomial the first coefficient
            return _numbers(full[key], 1, f"{where}: {key}")[0] if key in full else 0.0

        made = JointValues(
            name=chosen,
            linear=linear,
            damping=number("damping"),
            friction=number("frictionloss"),
            stiffness=number("stiffness"),
        )
        self._inertia(body, full, made, number("armature"), where)
        self._servo(made, where)
        return made

    def _inertia(
        self, body: Element, joint: dict[str, str], made: JointValues, armature: float, where: str
    ) -> None:
        total, unknown = armature, []
        bodies = list(body.iter("body")) if made.linear else [body]
        for one in bodies:
            own = one.find("inertial")
            if own is None:
                unknown.append(one.get("name", "?"))
            elif made.linear:
                total += _numbers(own.get("mass"), 1, f"{where}: mass")[0]
            else:
                axis = _numbers(joint.get("axis", "0 0 1"), 3, f"{where}: axis")
                anchor = _numbers(joint.get("pos", "0 0 0"), 3, f"{where}: pos")
                total += _about(own.attrib, axis, anchor, f"{where}: inertial")
        if unknown:
            listed = ", ".join(unknown[:6])
            made.remarks.append(f"without an inertial element, so not counted: body {listed}")
        if not made.linear and body.find("body") is not None:
            made.remarks.append("bodies further out than the joint's own are not counted")
        made.inertia = total if total > 0.0 else None

    def _servo(self, made: JointValues, where: str) -> None:
        for group in self._root.findall("actuator"):
            for one in group:
                full = self._full(one, "main")
                if full.get("joint") != made.name:
                    continue
                gear = _numbers(full.get("gear", "1"), 1, f"{where}: gear")[0]
                if one.tag != "position":
                    made.remarks.append(f"actuator <{one.tag}> has no gains of a position loop")
                    continue
                kp = _numbers(full.get("kp", "1"), 1, f"{where}: kp")[0] * gear**2
                kv = _numbers(full.get("kv", "0"), 1, f"{where}: kv")[0] * gear**2
                if kv > 0.0:
                    made.position_kp, made.speed_kp = kp / kv, kv
                else:
                    made.remarks.append("a servo without kv: no speed loop to take over")
                if "forcerange" in full:
                    limit = _numbers(full["forcerange"], 2, f"{where}: forcerange")[1]
                    made.effort = abs(gear) * limit if limit > 0.0 else None


def _about(
    inertial: Mapping[str, str], axis: list[float], anchor: list[float], where: str
) -> float:
    """Inertia about an axis through `anchor` of a body whose frame is the joint's, kg m^2."""
    length = math.sqrt(sum(one * one for one in axis)) or 1.0
    a = [one / length for one in axis]
    mass = _numbers(inertial.get("mass"), 1, f"{where}: mass")[0]
    centre = _numbers(inertial.get("pos", "0 0 0"), 3, f"{where}: pos")
    if "fullinertia" in inertial:
        xx, yy, zz, xy, xz, yz = _numbers(inertial["fullinertia"], 6, f"{where}: fullinertia")
    else:
        xx, yy, zz = _numbers(inertial.get("diaginertia"), 3, f"{where}: diaginertia")
        xy = xz = yz = 0.0
        turned = any(one in inertial for one in ("quat", "euler", "axisangle", "xyaxes", "zaxis"))
        if turned and max(xx, yy, zz) > (1.0 + 1e-9) * min(xx, yy, zz):
            raise InputError(f"{where}: turned against its body; expected fullinertia")
    return _moment((xx, yy, zz, xy, xz, yz), a) + mass * _distance(centre, anchor, a)


def _moment(tensor: tuple[float, ...], a: list[float]) -> float:
    xx, yy, zz, xy, xz, yz = tensor
    own = xx * a[0] ** 2 + yy * a[1] ** 2 + zz * a[2] ** 2
    return own + 2.0 * (xy * a[0] * a[1] + xz * a[0] * a[2] + yz * a[1] * a[2])


def _distance(centre: list[float], anchor: list[float], a: list[float]) -> float:
    """Square of a point's distance from the axis, m^2."""
    off = [one - other for one, other in zip(centre, anchor, strict=False)]
    along = sum(one * other for one, other in zip(off, a, strict=False))
    return max(sum(one * one for one in off[:3]) - along**2, 0.0)


def _urdf(path: Path, root: Element, name: str | None) -> JointValues:
    moving = {
        one.get("name", "?"): one
        for one in root.findall("joint")
        if one.get("type") in ("prismatic", "revolute", "continuous")
    }
    chosen = _choose(path, list(moving), name)
    joint = moving[chosen]
    where = f"{path}: joint {chosen}"
    made = JointValues(name=chosen, linear=joint.get("type") == "prismatic")
    dynamics, limit = joint.find("dynamics"), joint.find("limit")
    if dynamics is not None:
        made.damping = _numbers(dynamics.get("damping", "0"), 1, f"{where}: damping")[0]
        made.friction = _numbers(dynamics.get("friction", "0"), 1, f"{where}: friction")[0]
    if limit is not None and limit.get("effort") is not None:
        effort = _numbers(limit.get("effort"), 1, f"{where}: effort")[0]
        made.effort = effort if effort > 0.0 else None
    links = {one.get("name", ""): one for one in root.findall("link")}
    child = _child(joint)
    if made.linear:
        outer = {_child(one): _parent(one) for one in root.findall("joint")}
        carried = [one for one in links if _carries(one, child, outer)]
    else:
        carried = [child]
        if any(_parent(one) == child for one in root.findall("joint")):
            made.remarks.append("links further out than the joint's own are not counted")
    total = 0.0
    for one in carried:
        inertial = links[one].find("inertial") if one in links else None
        if inertial is None:
            made.remarks.append(f"without an inertial element, so not counted: link {one}")
            continue
        total += _urdf_inertia(inertial, joint, made.linear, where)
    made.inertia = total if total > 0.0 else None
    made.remarks.append("URDF has no gains")
    return made


def _urdf_inertia(inertial: Element, joint: Element, linear: bool, where: str) -> float:
    mass_of, origin, tensor = (inertial.find(tag) for tag in ("mass", "origin", "inertia"))
    mass = _numbers(None if mass_of is None else mass_of.get("value"), 1, f"{where}: mass")[0]
    if linear:
        return mass
    if tensor is None:
        raise InputError(f"{where}: no inertia; expected ixx to izz of its link")
    place = {} if origin is None else origin.attrib
    turned = _numbers(place.get("rpy", "0 0 0"), 3, f"{where}: rpy")
    values = [
        _numbers(tensor.get(key, "0"), 1, f"{where}: {key}")[0]
        for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    ]
    if any(turned) and (max(values[:3]) > (1.0 + 1e-9) * min(values[:3]) or any(values[3:])):
        raise InputError(f"{where}: inertia turned by rpy; expected it along the link's axes")
    axis_of = joint.find("axis")
    axis = _numbers("1 0 0" if axis_of is None else axis_of.get("xyz"), 3, f"{where}: axis")
    length = math.sqrt(sum(one * one for one in axis)) or 1.0
    a = [one / length for one in axis]
    centre = _numbers(place.get("xyz", "0 0 0"), 3, f"{where}: xyz")
    return _moment(tuple(values), a) + mass * _distance(centre, [0.0, 0.0, 0.0], a)


def _named(joint: Element, tag: str) -> str:
    found = joint.find(tag)
    return "" if found is None else found.get("link", "")


def _child(joint: Element) -> str:
    return _named(joint, "child")


def _parent(joint: Element) -> str:
    return _named(joint, "parent")


def _carries(link: str, child: str, outer: Mapping[str, str]) -> bool:
    """Whether `link` is `child` or hangs on it."""
    seen: set[str] = set()
    while link not in seen:
        if link == child:
            return True
        seen.add(link)
        link = outer.get(link, "")
    return False
