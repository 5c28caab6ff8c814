"""A robot's URDF as Bullet reads it, its fingertips of the declared shapes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from graspdsl.angles import roll_pitch_yaw
from graspdsl.arrays import Array
from graspdsl.diagnostics import DiagnosticError
from graspdsl.hands.descriptions import Robot
from graspdsl.hands.fingertips import CapsuleTip, EllipsoidTip, FingertipShape, SphereTip
from graspdsl.models.mesh_files import stl_of
from graspdsl.objects.ellipsoid import SmoothEllipsoid
from graspdsl.worlds.rigid.assembly import joined
from graspdsl.worlds.touch.surfaces import frame_about

MARGIN = 0.001  # m by which the engine enlarges every mesh of a URDF
HALF_TURN = 24  # facets of an ellipsoid: they are within 0.1 mm of one of 2 cm


def assembled_urdf(robot: Robot, folder: Path) -> str:
    """The text of a robot's URDF for the engine.

    What touches at a fingertip is the declared shape, in the place of the collision geometry of its link. Files that
    the text names are written into ``folder``.
    """
    whole = joined(robot)
    links = {link.get("name", ""): link for link in whole.iterfind("link")}
    _write_meshes(links.values(), folder)
    for number, contact in enumerate(robot.hand.contacts.values()):
        _give_shape(links[contact.link], contact.shape, folder / f"fingertip-{number}")
    ET.indent(whole)  # the engine cuts lines of more than some thousand characters
    return ET.tostring(whole, encoding="unicode")


def _give_shape(link: ET.Element, shape: FingertipShape, stem: Path) -> None:
    for collision in link.findall("collision"):
        link.remove(collision)
    made = ET.SubElement(link, "collision")
    angles: tuple[float, ...] = (0.0, 0.0, 0.0)
    geometry = ET.SubElement(made, "geometry")
    match shape:
        case SphereTip():
            ET.SubElement(geometry, "sphere", radius=repr(shape.radius))
        case CapsuleTip():
            ET.SubElement(geometry, "capsule", radius=repr(shape.radius), length=repr(shape.length))
            angles = roll_pitch_yaw(frame_about(np.array(shape.axis)))
        case EllipsoidTip():
            file = stem.with_suffix(".obj")
            file.write_text(_mesh(shape), encoding="ascii")
            ET.SubElement(geometry, "mesh", filename=str(file))
            angles = shape.rpy
    ET.SubElement(made, "origin", xyz=_text(shape.centre), rpy=_text(angles))


def _mesh(shape: EllipsoidTip) -> str:
    """An OBJ file of an ellipsoid, which the engine does not know, made smaller all round by its margin."""
    surface = SmoothEllipsoid(shape.semi_axes)
    mesh = surface.mesh(HALF_TURN)
    vertices: Array = mesh.vertices - MARGIN * surface.normals(mesh.vertices)
    lines = [f"v {_text(vertex)}" for vertex in vertices.tolist()]
    return "\n".join([*lines, *(f"f {a} {b} {c}" for a, b, c in (mesh.faces + 1).tolist()), ""])


def _write_meshes(links: Iterable[ET.Element], folder: Path) -> None:
    """Write the triangles of mesh files anew, for the engine does not read them in every format; what is only drawn and
    holds none is left out."""
    written = dict[str, str]()
    for link in links:
        for part in [*link.findall("collision"), *link.findall("visual")]:
            for mesh in part.iter("mesh"):
                path = mesh.get("filename", "")
                try:
                    content = stl_of(path)
                except DiagnosticError:
                    if part.tag == "collision":
                        raise
                    link.remove(part)
                    continue
                if path not in written:
                    written[path] = str(folder / f"mesh-{len(written)}.stl")
                    Path(written[path]).write_bytes(content)
                mesh.set("filename", written[path])


def _text(numbers: tuple[float, ...] | list[float]) -> str:
    return " ".join(map(repr, numbers))
