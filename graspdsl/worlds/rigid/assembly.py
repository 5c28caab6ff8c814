"""One URDF out of two: a hand's model fixed to the face of its mount."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from graspdsl.hands.descriptions import MOUNTING, Robot


def joined(robot: Robot) -> ET.Element:
    """A URDF with the mount's links, then the hand's, joined by a fixed joint at the mount's face."""
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
    joint = ET.SubElement(whole, "joint", name=MOUNTING, type="fixed")
    ET.SubElement(joint, "parent", link=robot.mount.face)
    ET.SubElement(joint, "child", link=robot.hand.root)
    return whole
