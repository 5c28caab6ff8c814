"""Hands described in MJCF, written anew as URDF: bodies, one hinge or slide each, and primitive geoms."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from graspdsl.arrays import Array
from graspdsl.diagnostics import DiagnosticError
from graspdsl.hands.kinematic_tree import MOST_FAULTS
from graspdsl.hands.mjcf_compiler import compiler_of
from graspdsl.hands.mjcf_defaults import MAIN, Defaults
from graspdsl.hands.mjcf_elements import add, add_origin
from graspdsl.hands.mjcf_geoms import solids_of, weighs
from graspdsl.hands.mjcf_inertia import principal
from graspdsl.hands.mjcf_joints import LeftOut, describe
from graspdsl.hands.mjcf_known import check_inside, whole
from graspdsl.hands.mjcf_parts import HERE, NotInMjcfError, Part, Pose, Source
from graspdsl.hands.urdf_check import UrdfCheck
from graspdsl.places.xml_files import PlacedElement

FIXED = "fixed"
WORLD = "world"
NEIGHBOURS = 2  # links that are at most so many joints apart never touch in a world


def urdf_of_mjcf(tree: ElementTree.Element, check: UrdfCheck) -> ElementTree.Element:
    """The URDF tree of a MJCF tree. What has no place in it is noted in ``check``, by name, line and column, with the
    names of the links and joints that are not as the file has them. Raises DiagnosticError where there is no hand.

    Read are nested bodies and frames with ``inertial``, at most one hinge or slide each, and spheres, capsules
    (cylinders with two balls), cylinders and boxes, with classes of defaults; angles as the compiler says. Where the
    outermost body is in its own world is nothing to a hand on a mount. Left out are looks, sites and sensors;
    actuators, tendons and equalities of joints, for a hand file says what is driven and coupled; the friction and
    softness of contacts and the options of the solver, for these are the spec's and the world's. Geoms that touch
    nothing of contype and conaffinity 1 are only drawn. The armature and frictionloss of joints are left out
    too, of which ``check`` gets warnings.
    """
    source = Source(check.file)
    conversion = _Conversion(tree, source, check.unsound)
    try:
        robot = conversion.robot()
    except NotInMjcfError as error:
        raise DiagnosticError([*source.complaints(), *error.diagnostics][:MOST_FAULTS]) from None
    check.found.extend(source.complaints())
    check.warnings.extend(conversion.left_out.warnings())
    return robot


class _Inner(NamedTuple):
    """An element of a body, also within frames: where these are in the body, and the class that they give it."""

    element: ElementTree.Element
    about: Pose
    inherited: str


class _Conversion:
    def __init__(self, tree: ElementTree.Element, source: Source, unsound: set[str]) -> None:
        self._tree, self._source, self._unsound = tree, source, unsound
        with source.noting():
            whole(source, tree)
        with source.noting():
            check_inside(source, tree)
        self._compiler = compiler_of(tree, source)
        self._angles = self._compiler.angles
        self._defaults = Defaults(source, tree)
        self._robot = PlacedElement("robot", name=tree.get("model", "hand"))
        self._parents: dict[str, str | None] = {}
        self._joints: set[str] = set()
        self.left_out = LeftOut()

    def robot(self) -> ElementTree.Element:
        worlds = self._tree.findall("worldbody")
        for world in worlds:
            with self._source.noting():
                whole(self._source, world)
        inside = [inner for world in worlds for inner in self._inside(world, HERE, MAIN)]
        bodies = [inner for inner in inside if inner.element.tag == "body"]
        if len(bodies) != 1:
            at = bodies[1].element if bodies else self._tree
            raise self._source.refused(at, f"the world has {len(bodies)} bodies, where a hand is one", None)
        for inner in inside:
            if inner.element.tag != "body":
                with self._source.noting():
                    self._check_floor(self._defaults.part(inner.element, inner.inherited))
        self._body(bodies[0], None, np.zeros(3))
        self._check_contacts()
        return self._robot

    def _inside(self, element: ElementTree.Element, about: Pose, inherited: str) -> Iterator[_Inner]:
        with self._source.noting():
            check_inside(self._source, element)
        for inner in element:
            if inner.tag == "frame":
                pose = HERE
                with self._source.noting():
                    pose = self._angles.pose(whole(self._source, inner))
                yield from self._inside(inner, about.then(pose), self._given(inner, inherited))
            elif inner.tag in ("body", "joint", "geom", "inertial"):
                yield _Inner(inner, about, inherited)

    def _given(self, element: ElementTree.Element, inherited: str) -> str:
        """The class that a body or a frame gives what is in it."""
        name = element.get("childclass", inherited)
        with self._source.noting():
            self._defaults.check(element, name)
            return name
        return inherited

    def _body(self, body: _Inner, parent: str | None, shift: Array) -> None:
        """One body as a link; ``shift`` (3,) [m]: where the parent link's frame is in the parent body's."""
        part = Part(self._source, body.element, body.element.attrib)
        name = self._name(part)
        self._parents[name] = parent
        inside = list(self._inside(body.element, HERE, self._given(body.element, body.inherited)))
        joints = [inner for inner in inside if inner.element.tag == "joint"]
        # A URDF joint turns about the frame of its link.
        pose, hinge, joint = HERE, HERE, None
        with self._noting(name, *(inner.element.get("name", f"{name}-joint") for inner in joints)):
            whole(self._source, body.element)
            if len(joints) > 1:
                raise part.refused(f"the body has {len(joints)} joints", "put a body between them")
            found = self._defaults.part(joints[0].element, joints[0].inherited) if joints else None
            if found is not None and parent is None:
                raise found.refused("the outermost body has a joint", "take it out, or put the body into one without")
            pose = body.about.then(self._angles.pose(part)) if parent else HERE
            if found is not None:
                hinge = joints[0].about.then(Pose(found.numbers("pos", "0 0 0", 3), HERE.turned))
            joint = found
        link = self._link(part, name, inside, hinge.place, bool(joints))
        if parent is not None:
            made = self._joint(part, joints[0].element if joints else None, joint, hinge, (parent, name))
            add_origin(made, Pose(pose.then(hinge).place - shift, pose.turned))
        for inner in inside:
            if inner.element.tag == "body":
                self._body(inner, name, hinge.place)
            elif inner.element.tag == "geom":
                with self._noting(name):
                    self._geom(self._defaults.part(inner.element, inner.inherited), link, inner.about, hinge.place)

    def _name(self, body: Part) -> str:
        """The name of a body, or another where it has none of its own."""
        name = body.attributes.get("name", "")
        with self._source.noting():
            if not name:
                raise body.refused("a body has no name", "name it")
            if name in self._parents:
                raise body.refused("another body has this name", "give each its own")
            return name
        return f"{name or 'body'}-{len(self._parents)}"

    @contextmanager
    def _noting(self, *names: str) -> Iterator[None]:
        """Notes what is wrong within, and that links and joints of these names are not as the file has them."""
        before = sum(count for _, count in self._source.found.values())
        with self._source.noting():
            yield
        if sum(count for _, count in self._source.found.values()) > before:
            self._unsound.update(names)

    def _joint(
        self,
        part: Part,
        element: ElementTree.Element | None,
        joint: Part | None,
        hinge: Pose,
        ends: tuple[str, str],
    ) -> ElementTree.Element:
        """The joint between two bodies; of one that is not read whole only its name."""
        parent, body = ends
        name = f"{body}-fixed" if element is None else element.get("name", f"{body}-joint")
        if element is not None and name in self._joints:
            with self._source.noting():
                other = joint or Part(self._source, element, element.attrib)
                raise other.refused("another joint has this name", "give each its own")
            name = f"{name}-{len(self._joints)}"
        self._joints.add(name)
        made = add(self._robot, "joint", {"name": name, "type": FIXED}, part.element if element is None else element)
        add(made, "parent", {"link": parent})
        add(made, "child", {"link": body})
        if joint is not None:
            with self._noting(name):
                describe(made, joint, hinge, self._compiler)
                self.left_out.note(joint)
        return made

    def _link(self, body: Part, name: str, inside: list[_Inner], moved: Array, moves: bool) -> ElementTree.Element:
        link = add(self._robot, "link", {"name": name}, body.element)
        with self._noting(name):
            self._weigh(link, body, inside, moved, moves)
        return link

    def _weigh(self, link: ElementTree.Element, body: Part, inside: list[_Inner], moved: Array, moves: bool) -> None:
        inertials = [inner for inner in inside if inner.element.tag == "inertial"]
        if not inertials:
            self._check_massless(body, inside, moves)
            return
        if len(inertials) > 1:
            raise body.refused(f"the body has {len(inertials)} <inertial>", "keep one")
        part = whole(self._source, inertials[0].element)
        check_inside(self._source, part.element)
        mass, moments, axes = principal(part, moves)
        pose = inertials[0].about.then(self._angles.pose(part)).then(Pose(np.zeros(3), axes))
        made = add(link, "inertial", {}, part.element)
        add_origin(made, Pose(pose.place - moved, pose.turned))
        add(made, "mass", {"value": f"{mass!r}"})
        xx, yy, zz = map(repr, moments.tolist())
        add(made, "inertia", {"ixx": xx, "iyy": yy, "izz": zz, "ixy": "0", "ixz": "0", "iyz": "0"})

    def _check_massless(self, body: Part, inside: list[_Inner], moves: bool) -> None:
        """A body without <inertial> has the mass of its geoms, which is not worked out here."""
        geoms = (self._defaults.part(geom.element, geom.inherited) for geom in inside if geom.element.tag == "geom")
        if moves:
            raise body.refused("the body moves and has no <inertial>", "give it one")
        if self._compiler.geoms_weigh and any(map(weighs, geoms)):
            raise body.refused("the body has no <inertial>, and geoms that weigh", 'give it one, or its geoms mass="0"')

    def _geom(self, geom: Part, link: ElementTree.Element, about: Pose, moved: Array) -> None:
        check_inside(self._source, geom.element)
        touches = (geom.mask("contype", "1") | geom.mask("conaffinity", "1")) & 1
        for solid in solids_of(geom, self._angles):
            pose = about.then(solid.pose)
            for use in ("visual", "collision") if touches else ("visual",):
                made = add(link, use, {}, geom.element)
                add_origin(made, Pose(pose.place - moved, pose.turned))
                add(add(made, "geometry", {}), solid.tag, solid.sizes)

    def _check_floor(self, geom: Part) -> None:
        if geom.attributes.get("type") != "plane":
            raise geom.refused("it belongs to the world and not to the hand", "take it out, or put it into a body")

    def _check_contacts(self) -> None:
        for tag in ("contact", "equality"):
            for section in self._tree.findall(tag):
                with self._source.noting():
                    check_inside(self._source, section)
        for element in self._tree.findall("contact/exclude"):
            with self._source.noting():
                part = whole(self._source, element)
                bodies = [part.attributes.get(key, "") for key in ("body1", "body2")]
                if not set(bodies) <= {WORLD, *self._parents}:
                    raise part.refused(f"there is no such pair of bodies: {' and '.join(bodies)}", None)
                if WORLD not in bodies and self._apart(*bodies) > NEIGHBOURS:
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
