"""A model as the text of one URDF, which all that comes after reading uses."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from graspdsl.angles import roll_pitch_yaw
from graspdsl.models.joint_kinds import CONTINUOUS, FIXED
from graspdsl.models.model import Frame, Link, Model, Solid

BALL = Path(__file__).parent / "ball.obj"  # a ball of 1 m, for ellipsoids, which URDF does not have
NO_LIMITS = (0.0, -1.0)  # an engine holds a joint at limits of 0 to 0
VELOCITY = "10"  # rad/s or m/s, which nothing depends on
MOMENTS = ((0, 0, "ixx"), (1, 1, "iyy"), (2, 2, "izz"), (0, 1, "ixy"), (0, 2, "ixz"), (1, 2, "iyz"))


def urdf_text(model: Model) -> str:
    """The model as a URDF: meshes named by where they are, what is drawn under <visual>, no mimicry."""
    robot = ElementTree.Element("robot", name="model")
    for name, link in model.links.items():
        _add_link(robot, name, link)
    for name, joint in model.joints.items():
        made = ElementTree.SubElement(robot, "joint", name=name, type=joint.kind)
        ElementTree.SubElement(made, "parent", link=joint.parent)
        ElementTree.SubElement(made, "child", link=joint.child)
        _add_origin(made, joint.frame)
        if joint.kind == FIXED:
            continue
        ElementTree.SubElement(made, "axis", xyz=_text(joint.axis))
        low, high = NO_LIMITS if joint.kind == CONTINUOUS or joint.limits is None else joint.limits
        strength = {"effort": repr(joint.effort), "velocity": VELOCITY}
        ElementTree.SubElement(made, "limit", {"lower": repr(low), "upper": repr(high), **strength})
        ElementTree.SubElement(made, "dynamics", damping=repr(joint.damping), friction=repr(joint.friction))
    return ElementTree.tostring(robot, encoding="unicode")


def _add_link(robot: ElementTree.Element, name: str, link: Link) -> None:
    made = ElementTree.SubElement(robot, "link", name=name)
    inertial = ElementTree.SubElement(made, "inertial")
    _add_origin(inertial, Frame(link.centre, np.eye(3)))
    ElementTree.SubElement(inertial, "mass", value=repr(link.mass))
    moments = {key: repr(float(link.inertia[row, column])) for row, column, key in MOMENTS}
    ElementTree.SubElement(inertial, "inertia", moments)
    for solid in link.solids:
        for use, wanted in (("visual", solid.seen), ("collision", solid.touches)):
            if wanted:
                _add_solid(ElementTree.SubElement(made, use), solid)


def _add_solid(made: ElementTree.Element, solid: Solid) -> None:
    _add_origin(made, solid.frame)
    geometry = ElementTree.SubElement(made, "geometry")
    match solid.kind, solid.sizes:
        case "box", sizes:
            ElementTree.SubElement(geometry, "box", size=_text(sizes))
        case "ellipsoid", sizes:
            ElementTree.SubElement(geometry, "mesh", filename=str(BALL), scale=_text(sizes))
        case "sphere", (radius,):
            ElementTree.SubElement(geometry, "sphere", radius=repr(radius))
        case (("cylinder" | "capsule"), (radius, length)):
            ElementTree.SubElement(geometry, solid.kind, radius=repr(radius), length=repr(length))
    if solid.mesh is not None:
        ElementTree.SubElement(geometry, "mesh", filename=solid.mesh.place, scale=_text(solid.mesh.scale))
    if made.tag == "visual" and solid.colour is not None:
        # Materials of one name are one in a file: the name has to tell the colour.
        material = ElementTree.SubElement(made, "material", name=f"rgba {_text(solid.colour)}")
        ElementTree.SubElement(material, "color", rgba=_text(solid.colour))


def _add_origin(element: ElementTree.Element, frame: Frame) -> None:
    ElementTree.SubElement(element, "origin", xyz=_text(frame.place), rpy=_text(roll_pitch_yaw(frame.rotation)))


def _text(numbers: Iterable[float]) -> str:
    return " ".join(repr(float(number) + 0.0) for number in numbers)
