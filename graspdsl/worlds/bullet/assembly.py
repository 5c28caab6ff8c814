"""One URDF out of two: a hand's model fixed to the face of its mount."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

from graspdsl.hands.descriptions import HERE, Robot


def assembled_urdf(robot: Robot) -> str:
    """The text of a URDF with the mount's links, then the hand's, joined by a fixed joint at the mount's face."""
    whole = ET.Element("robot", name=f"{robot.mount.mount}-{robot.hand.hand}")
    materials: set[str] = set()
    for file in (robot.mount.urdf, robot.hand.urdf):
        path = HERE / file
        for element in ET.parse(path).getroot():
            name = element.get("name", "")
            if element.tag == "material" and name in materials:
                continue
            if element.tag == "material":
                materials.add(name)
            _make_mesh_paths_absolute(element, path.parent)
            whole.append(element)
    joint = ET.SubElement(whole, "joint", name="mounting", type="fixed")
    ET.SubElement(joint, "parent", link=robot.mount.face)
    ET.SubElement(joint, "child", link=robot.hand.root)
    return ET.tostring(whole, encoding="unicode")


def _make_mesh_paths_absolute(element: ET.Element, folder: Path) -> None:
    for mesh in element.iter("mesh"):
        mesh.set("filename", str(folder / mesh.get("filename", "")))
