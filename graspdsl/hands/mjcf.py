"""Hands described in MJCF, written anew as URDF: bodies, one hinge or slide each, and primitive geoms."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.rotations import roll_pitch_yaw
from graspdsl.hands.mjcf_defaults import MAIN, Defaults
from graspdsl.hands.mjcf_geoms import solids_of
from graspdsl.hands.mjcf_inertia import principal
from graspdsl.hands.mjcf_known import check_inside, whole
from graspdsl.hands.mjcf_parts import HERE, Angles, Part, Pose, Source

HINGE, SLIDE = "hinge", "slide"
FIXED = "fixed"
ON_OFF = ("auto", "true", "false")
NEIGHBOURS = 2  # links that are at most so many joints apart never touch in a world


def urdf_of_mjcf(tree: ElementTree.Element, file: str) -> ElementTree.Element:
    """The URDF tree of a MJCF tree. Raises DiagnosticError for what has no place in it, by name, line and column.

    Read are nested bodies and frames with ``inertial``, at most one hinge or slide each, and spheres, capsules
    (cylinders with two balls), cylinders and boxes, with classes of defaults; angles as the compiler says. Where the
    outermost body is in its own world is nothing to a hand on a mount. Left out are looks, sites and sensors;
    actuators, tendons and equalities of joints, for a hand file says what is driven and coupled; the friction and
    softness of contacts and the options of the solver, for these are the spec's and the world's. Geoms that touch
    nothing of contype and conaffinity 1 are only drawn.
    """
    return _Conversion(tree, Source(file)).robot()


class _Inner(NamedTuple):
    """An element of a body, also within frames: where these are in the body, and the class that they give it."""

    element: ElementTree.Element
    about: Pose
    inherited: str


class _Conversion:
    def __init__(self, tree: ElementTree.Element, source: Source) -> None:
        self._tree, self._source = tree, source
        whole(source, tree)
        check_inside(source, tree)
        self._angles, self._autolimits = _compiler(tree, source)
        self._defaults = Defaults(source, tree)
        self._robot = ElementTree.Element("robot", name=tree.get("model", "hand"))
        self._parents: dict[str, str | None] = {}
        self._joints: set[str] = set()

    def robot(self) -> ElementTree.Element:
        worlds = self._tree.findall("worldbody")
        for world in worlds:
            whole(self._source, world)
        inside = [inner for world in worlds for inner in self._inside(world, HERE, MAIN)]
        bodies = [inner for inner in inside if inner.element.tag == "body"]
        if len(bodies) != 1:
            at = bodies[1].element if bodies else self._tree
            raise self._source.refused(at, f"the world has {len(bodies)} bodies, where a hand is one", None)
        for inner in inside:
            if inner.element.tag != "body":
                self._check_floor(self._defaults.part(inner.element, inner.inherited))
        self._body(bodies[0], None, np.zeros(3))
        self._check_contacts()
        return self._robot

    def _inside(self, element: ElementTree.Element, about: Pose, inherited: str) -> Iterator[_Inner]:
        check_inside(self._source, element)
        for inner in element:
            if inner.tag == "frame":
                part = whole(self._source, inner)
                yield from self._inside(inner, about.then(self._angles.pose(part)), self._given(inner, inherited))
            elif inner.tag in ("body", "joint", "geom", "inertial"):
                yield _Inner(inner, about, inherited)

    def _given(self, element: ElementTree.Element, inherited: str) -> str:
        """The class that a body or a frame gives what is in it."""
        name = element.get("childclass", inherited)
        self._defaults.check(element, name)
        return name

    def _body(self, body: _Inner, parent: str | None, shift: Array) -> None:
        """One body as a link; ``shift`` (3,) [m]: where the parent link's frame is in the parent body's."""
        part = whole(self._source, body.element)
        name = part.attributes.get("name", "")
        if not name:
            raise part.refused("a body has no name", "name it")
        if name in self._parents:
            raise part.refused("another body has this name", "give each its own")
        self._parents[name] = parent
        inside = list(self._inside(body.element, HERE, self._given(body.element, body.inherited)))
        joints = [inner for inner in inside if inner.element.tag == "joint"]
        if len(joints) > 1:
            raise part.refused(f"the body has {len(joints)} joints", "put a body between them")
        joint = self._defaults.part(joints[0].element, joints[0].inherited) if joints else None
        if joint is not None and parent is None:
            raise joint.refused("the outermost body has a joint", "take it out, or put the body into one without")
        # A URDF joint turns about the frame of its link.
        hinge = HERE if joint is None else joints[0].about.then(Pose(joint.numbers("pos", "0 0 0", 3), HERE.turned))
        link = self._link(part, name, inside, hinge.place, joint is not None)
        if parent is not None:
            pose = body.about.then(self._angles.pose(part))
            made = self._joint(joint, hinge, name, parent)
            _origin(made, Pose(pose.then(hinge).place - shift, pose.turned))
        for inner in inside:
            if inner.element.tag == "body":
                self._body(inner, name, hinge.place)
            elif inner.element.tag == "geom":
                self._geom(self._defaults.part(inner.element, inner.inherited), link, inner.about, hinge.place)

    def _joint(self, joint: Part | None, hinge: Pose, body: str, parent: str) -> ElementTree.Element:
        name = f"{body}-fixed" if joint is None else joint.attributes.get("name", f"{body}-joint")
        made = ElementTree.SubElement(self._robot, "joint", name=name, type=FIXED)
        ElementTree.SubElement(made, "parent", link=parent)
        ElementTree.SubElement(made, "child", link=body)
        if joint is None:
            return made
        if name in self._joints:
            raise joint.refused("another joint has this name", "give each its own")
        self._joints.add(name)
        kind = joint.attributes.get("type", HINGE)
        if kind not in (HINGE, SLIDE):
            raise joint.refused(f"the joint of the body {body} is neither a hinge nor a slide, but {kind!r}")
        axis = joint.numbers("axis", "0 0 1", 3)
        axis = hinge.turned.apply(joint.direction("axis", axis) if "axis" in joint.attributes else axis)
        ElementTree.SubElement(made, "axis", xyz=_text(axis))
        damping = joint.number("damping", "0")
        if damping < 0.0:
            raise joint.refused(f"its damping is negative: {damping:g}", None)
        ElementTree.SubElement(made, "dynamics", damping=f"{damping!r}")
        limits, strength = self._limits(joint, "range", "limited"), self._strength(joint)
        made.set("type", "prismatic" if kind == SLIDE else "continuous" if limits is None else "revolute")
        if limits is not None:
            low, high = (self._angles.radians(limits) if kind == HINGE else limits).tolist()
            limit = {"lower": f"{low!r}", "upper": f"{high!r}", "effort": f"{strength!r}", "velocity": "10"}
            ElementTree.SubElement(made, "limit", limit)
        return made

    def _limits(self, joint: Part, key: str, switch: str) -> Array | None:
        """The ends (2,) of a range that is on, None of one that is off."""
        state = joint.word(switch, ON_OFF)
        ends = joint.numbers(key, "0 0", 2)
        if state == "false":
            return None
        if state == "auto" and key in joint.attributes and not self._autolimits:
            raise joint.refused(f"it has a {key}, but does not say whether it is {switch}", f'write {switch}="true"')
        if ends[0] > ends[1] or (state == "true" and ends[0] == ends[1]):
            raise joint.refused(f"its {key} leaves no room: {_text(ends)}", "the lower end comes first")
        return ends if ends[0] < ends[1] else None

    def _strength(self, joint: Part) -> float:
        """The most that drives a joint [N or Nm], zero where the file does not say."""
        ends = self._limits(joint, "actuatorfrcrange", "actuatorfrclimited")
        if ends is None:
            return 0.0
        if ends[0] != -ends[1]:
            raise joint.refused("its actuatorfrcrange is not as strong either way", "write it as -a a")
        return float(ends[1])

    def _link(self, body: Part, name: str, inside: list[_Inner], moved: Array, moves: bool) -> ElementTree.Element:
        link = ElementTree.SubElement(self._robot, "link", name=name)
        inertials = [inner for inner in inside if inner.element.tag == "inertial"]
        if not inertials:
            raise body.refused("the body has no <inertial>", "give it one")
        if len(inertials) > 1:
            raise body.refused(f"the body has {len(inertials)} <inertial>", "keep one")
        part = whole(self._source, inertials[0].element)
        check_inside(self._source, part.element)
        mass, moments, axes = principal(part, moves)
        pose = inertials[0].about.then(self._angles.pose(part)).then(Pose(np.zeros(3), axes))
        made = ElementTree.SubElement(link, "inertial")
        _origin(made, Pose(pose.place - moved, pose.turned))
        ElementTree.SubElement(made, "mass", value=f"{mass!r}")
        xx, yy, zz = map(repr, moments.tolist())
        ElementTree.SubElement(made, "inertia", ixx=xx, iyy=yy, izz=zz, ixy="0", ixz="0", iyz="0")
        return link

    def _geom(self, geom: Part, link: ElementTree.Element, about: Pose, moved: Array) -> None:
        check_inside(self._source, geom.element)
        touches = (geom.mask("contype", "1") | geom.mask("conaffinity", "1")) & 1
        for solid in solids_of(geom, self._angles):
            pose = about.then(solid.pose)
            for use in ("visual", "collision") if touches else ("visual",):
                made = ElementTree.SubElement(link, use)
                _origin(made, Pose(pose.place - moved, pose.turned))
                ElementTree.SubElement(ElementTree.SubElement(made, "geometry"), solid.tag, dict(solid.sizes))

    def _check_floor(self, geom: Part) -> None:
        if geom.attributes.get("type") != "plane":
            raise geom.refused("it belongs to the world and not to the hand", "take it out, or put it into a body")

    def _check_contacts(self) -> None:
        for tag in ("contact", "equality"):
            for section in self._tree.findall(tag):
                check_inside(self._source, section)
        for element in self._tree.findall("contact/exclude"):
            part = whole(self._source, element)
            bodies = [part.attributes.get(key, "") for key in ("body1", "body2")]
            if not set(bodies) <= set(self._parents):
                raise part.refused(f"there is no such pair of bodies: {' and '.join(bodies)}", None)
            if self._apart(*bodies) > NEIGHBOURS:
                message = f"{bodies[0]} and {bodies[1]} are more than {NEIGHBOURS} joints apart and would touch"
                raise part.refused(message)

    def _apart(self, one: str, other: str) -> int:
        """How many joints are between two bodies."""
        return len(set(self._ancestors(one)) ^ set(self._ancestors(other)))

    def _ancestors(self, body: str) -> Iterator[str]:
        at: str | None = body
        while at is not None:
            yield at
            at = self._parents[at]


def _compiler(tree: ElementTree.Element, source: Source) -> tuple[Angles, bool]:
    """The unit and the sequence of angles, and whether a range alone limits a joint; later elements go first."""
    angles, autolimits = Angles(True, "xyz"), True
    for element in tree.findall("compiler"):
        part = whole(source, element)
        check_inside(source, element)
        if "angle" in part.attributes:
            angles = Angles(part.word("angle", ("degree", "radian")) == "degree", angles.sequence)
        if "autolimits" in part.attributes:
            autolimits = part.word("autolimits", ("true", "false")) == "true"
        sequence = part.attributes.get("eulerseq", angles.sequence)
        if len(sequence) != 3 or not set(sequence.lower()) <= set("xyz"):
            raise part.refused(f"its eulerseq is {sequence!r}", "expected three letters out of xyzXYZ")
        angles = Angles(angles.degrees, sequence)
    return angles, autolimits


def _text(numbers: Array) -> str:
    return " ".join(map(repr, numbers.tolist()))


def _origin(of: ElementTree.Element, pose: Pose) -> None:
    rpy = np.array(roll_pitch_yaw(pose.turned.as_matrix()))
    ElementTree.SubElement(of, "origin", xyz=_text(pose.place), rpy=_text(rpy))
