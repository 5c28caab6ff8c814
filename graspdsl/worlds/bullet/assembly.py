"""One URDF out of two: a hand's model fixed to the face of its mount, its fingertips of the declared shapes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from graspdsl.angles import roll_pitch_yaw
from graspdsl.arrays import Array
from graspdsl.hands.descriptions import MOUNTING, Robot
from graspdsl.hands.fingertips import CapsuleTip, EllipsoidTip, FingertipShape, SphereTip
from graspdsl.objects.ellipsoid import SmoothEllipsoid
from graspdsl.worlds.touch.surfaces import frame_about

MARGIN = 0.001  # m by which the engine enlarges every mesh of a URDF
HALF_TURN = 24  # facets of an ellipsoid: they are within 0.1 mm of one of 2 cm


def assembled_urdf(robot: Robot, folder: Path) -> str:
    """The text of a URDF with the mount's links, then the hand's, joined by a fixed joint at the mount's face.

    What touches at a fingertip is the declared shape, in the place of the collision geometry of its link; it is also
    drawn where the link has no looks. Files that the text names are written into ``folder``.
    """
    whole = ET.Element("robot", name=f"{robot.mount.mount}-{robot.hand.hand}")
    materials: set[str] = set()
    for model in robot.models:
        for element in ET.fromstring(model):
            name = element.get("name", "")
            if element.tag == "material" and name in materials:
                continue
            if element.tag == "material":
                materials.add(name)
            whole.append(element)
    links = {link.get("name", ""): link for link in whole.iterfind("link")}
    for number, contact in enumerate(robot.hand.contacts.values()):
        _give_shape(links[contact.link], contact.shape, folder / f"fingertip-{number}")
    joint = ET.SubElement(whole, "joint", name=MOUNTING, type="fixed")
    ET.SubElement(joint, "parent", link=robot.mount.face)
    ET.SubElement(joint, "child", link=robot.hand.root)
    ET.indent(whole)  # the engine cuts lines of more than some thousand characters
    return ET.tostring(whole, encoding="unicode")


def _give_shape(link: ET.Element, shape: FingertipShape, stem: Path) -> None:
    for collision in link.findall("collision"):
        link.remove(collision)
    for use in ("collision",) if link.find("visual") is not None else ("collision", "visual"):
        made = ET.SubElement(link, use)
        angles: tuple[float, ...] = (0.0, 0.0, 0.0)
        geometry = ET.SubElement(made, "geometry")
        match shape:
            case SphereTip():
                ET.SubElement(geometry, "sphere", radius=repr(shape.radius))
            case CapsuleTip():
                ET.SubElement(geometry, "capsule", radius=repr(shape.radius), length=repr(shape.length))
                angles = roll_pitch_yaw(frame_about(np.array(shape.axis)))
            case EllipsoidTip():
                file = stem.with_name(f"{stem.name}-{use}.obj")
                file.write_text(_mesh(shape, MARGIN if use == "collision" else 0.0), encoding="ascii")
                ET.SubElement(geometry, "mesh", filename=str(file))
                angles = shape.rpy
        ET.SubElement(made, "origin", xyz=_text(shape.centre), rpy=_text(angles))


def _mesh(shape: EllipsoidTip, margin: float) -> str:
    """An OBJ file of an ellipsoid, which the engine does not know, made smaller all round by a margin [m]."""
    surface = SmoothEllipsoid(shape.semi_axes)
    mesh = surface.mesh(HALF_TURN)
    vertices: Array = mesh.vertices - margin * surface.normals(mesh.vertices)
    lines = [f"v {_text(vertex)}" for vertex in vertices.tolist()]
    return "\n".join([*lines, *(f"f {a} {b} {c}" for a, b, c in (mesh.faces + 1).tolist()), ""])


def _text(numbers: tuple[float, ...] | list[float]) -> str:
    return " ".join(map(repr, numbers))
