"""Hands described in MJCF, written anew as URDF: bodies, one hinge or slide each, and primitive geoms."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.basis.rotations import roll_pitch_yaw
from graspdsl.spec.named_files import refusal

HINGE, SLIDE = "hinge", "slide"
Attributes = Mapping[str, str]


def urdf_of_mjcf(tree: ElementTree.Element, file: str) -> ElementTree.Element:
    """The URDF tree of a MJCF tree. Raises DiagnosticError for what has no place in it, by name.

    Read are nested bodies with ``inertial``, at most one joint each, and spheres, capsules (cylinders with two balls),
    cylinders and boxes, with classes of defaults; angles as the compiler says. Actuators, tendons and sites are left
    out: a hand file says what is driven and coupled.
    """
    return _Conversion(tree, file).robot()


class _Conversion:
    def __init__(self, tree: ElementTree.Element, file: str) -> None:
        self._tree, self._file = tree, file
        compiler = tree.find("compiler")
        settings = {} if compiler is None else compiler.attrib
        self._degrees = settings.get("angle", "degree") == "degree"
        self._sequence = settings.get("eulerseq", "xyz")
        self._classes: dict[str, dict[str, Attributes]] = {}
        for default in tree.findall("default"):
            self._read_defaults(default, {})
        self._robot = ElementTree.Element("robot", name=tree.get("model", "hand"))

    def _read_defaults(self, default: ElementTree.Element, above: Mapping[str, Attributes]) -> None:
        found = {**above}
        for element in default:
            if element.tag != "default":
                found[element.tag] = {**found.get(element.tag, {}), **element.attrib}
        self._classes[default.get("class", "main")] = found
        for inner in default.findall("default"):
            self._read_defaults(inner, found)

    def robot(self) -> ElementTree.Element:
        world = self._tree.find("worldbody")
        bodies = [] if world is None else world.findall("body")
        if len(bodies) != 1:
            raise self._refused(f"the world has {len(bodies)} bodies, where a hand is one")
        self._body(bodies[0], None, np.zeros(3), "main")
        return self._robot

    def _body(self, body: ElementTree.Element, parent: str | None, shift: Array, above: str) -> None:
        """One body as a link; ``shift`` (3,) [m]: where the parent link's frame is in the parent body's."""
        name = body.get("name", "")
        if not name:
            raise self._refused("a body has no name")
        inherited = body.get("childclass", above)
        joints = body.findall("joint")
        if len(joints) > 1:
            raise self._refused(f"the body {name} has {len(joints)} joints; put a body between them")
        joint = self._whole("joint", joints[0], inherited) if joints else None
        # A URDF joint turns about the frame of its link.
        moved = np.zeros(3) if joint is None or parent is None else _numbers(joint.get("pos", "0 0 0"))
        self._link(body, name, moved, inherited)
        if parent is not None:
            turned = self._rotation(body.attrib)
            place = _numbers(body.get("pos", "0 0 0")) + turned.apply(moved) - shift
            self._joint(joint, name, parent, place, turned)
        for inner in body.findall("body"):
            self._body(inner, name, moved, inherited)

    def _joint(self, joint: Attributes | None, body: str, parent: str, place: Array, turned: Rotation) -> None:
        kind = FIXED if joint is None else KINDS.get(joint.get("type", HINGE), "")
        if not kind:
            raise self._refused(f"the joint of the body {body} is neither a hinge nor a slide")
        name = f"{body}-fixed" if joint is None else joint.get("name", f"{body}-joint")
        made = ElementTree.SubElement(self._robot, "joint", name=name, type=kind)
        ElementTree.SubElement(made, "parent", link=parent)
        ElementTree.SubElement(made, "child", link=body)
        _origin(made, place, turned)
        if joint is None:
            return
        ElementTree.SubElement(made, "axis", xyz=joint.get("axis", "0 0 1"))
        if "range" in joint:
            scale = np.pi / 180.0 if self._degrees and kind == "revolute" else 1.0
            low, high = (f"{scale * end:.9g}" for end in _numbers(joint["range"]))
            ElementTree.SubElement(made, "limit", lower=low, upper=high, effort="0", velocity="10")

    def _link(self, body: ElementTree.Element, name: str, moved: Array, inherited: str) -> None:
        link = ElementTree.SubElement(self._robot, "link", name=name)
        inertial = body.find("inertial")
        if inertial is None:
            raise self._refused(f"the body {name} has no <inertial>")
        made = ElementTree.SubElement(link, "inertial")
        _origin(made, _numbers(inertial.get("pos", "0 0 0")) - moved, self._rotation(inertial.attrib))
        ElementTree.SubElement(made, "mass", value=inertial.get("mass", "0"))
        xx, yy, zz = _numbers(inertial.get("diaginertia", "0 0 0"))
        ElementTree.SubElement(
            made, "inertia", ixx=f"{xx:.9g}", iyy=f"{yy:.9g}", izz=f"{zz:.9g}", ixy="0", ixz="0", iyz="0"
        )
        for geom in body.findall("geom"):
            self._geom(self._whole("geom", geom, inherited), link, name, moved)

    def _geom(self, geom: Attributes, link: ElementTree.Element, body: str, moved: Array) -> None:
        kind, size = geom.get("type", "sphere"), _numbers(geom.get("size", "0.01"))
        place, turned = _numbers(geom.get("pos", "0 0 0")), self._rotation(geom)
        length = 2.0 * float(size[1]) if len(size) > 1 else 0.0
        if "fromto" in geom:
            ends = _numbers(geom["fromto"]).reshape(2, 3)
            place, length = ends.mean(axis=0), float(np.linalg.norm(ends[1] - ends[0]))
            turned, _ = Rotation.align_vectors([ends[1] - ends[0]], [[0.0, 0.0, 1.0]])
        along = turned.apply([0.0, 0.0, 0.5 * length])
        tube = {"radius": f"{size[0]:.9g}", "length": f"{length:.9g}"}
        ball = {"radius": f"{size[0]:.9g}"}
        shapes = {
            "sphere": [("sphere", ball, place)],
            "cylinder": [("cylinder", tube, place)],
            "capsule": [("cylinder", tube, place), ("sphere", ball, place + along), ("sphere", ball, place - along)],
            "box": [("box", {"size": " ".join(f"{2.0 * edge:.9g}" for edge in size)}, place)],
        }
        if kind not in shapes:
            raise self._refused(f"the body {body} has a {kind}, which is not read: only {', '.join(shapes)}")
        touches = geom.get("contype", "1") != "0" or geom.get("conaffinity", "1") != "0"
        for tag, attributes, centre in shapes[kind]:
            for use in ("visual", "collision") if touches else ("visual",):
                made = ElementTree.SubElement(link, use)
                _origin(made, centre - moved, turned)
                ElementTree.SubElement(ElementTree.SubElement(made, "geometry"), tag, attributes)

    def _whole(self, tag: str, element: ElementTree.Element, inherited: str) -> dict[str, str]:
        """The attributes of an element with those of its class of defaults."""
        defaults = self._classes.get(element.get("class", inherited), {})
        return {**defaults.get(tag, {}), **element.attrib}

    def _rotation(self, attributes: Attributes) -> Rotation:
        if "quat" in attributes:
            return Rotation.from_quat(_numbers(attributes["quat"]), scalar_first=True)
        if "euler" in attributes:
            # Capital letters turn about the axes as they have been turned, in scipy's words as in MJCF's small ones.
            swapped = self._sequence.swapcase()
            return Rotation.from_euler(swapped, _numbers(attributes["euler"]), degrees=self._degrees)
        if "axisangle" in attributes:
            *axis, angle = _numbers(attributes["axisangle"])
            vector = np.array(axis) / np.linalg.norm(axis) * (np.radians(angle) if self._degrees else angle)
            return Rotation.from_rotvec(vector)
        return Rotation.identity()

    def _refused(self, what: str) -> Exception:
        return refusal("not-in-mjcf", f"{self._file}: {what}", "change it, or describe the hand in URDF")


FIXED = "fixed"
KINDS = {HINGE: "revolute", SLIDE: "prismatic"}


def _numbers(text: str) -> Array:
    return np.array([float(word) for word in text.split()])


def _origin(of: ElementTree.Element, place: Array, turned: Rotation) -> None:
    rpy = roll_pitch_yaw(turned.as_matrix())
    xyz, angles = (" ".join(f"{number:.9g}" for number in numbers) for numbers in (place, rpy))
    ElementTree.SubElement(of, "origin", xyz=xyz, rpy=angles)
