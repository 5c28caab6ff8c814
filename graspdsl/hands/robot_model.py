"""The model file of a hand, a URDF or MJCF: its links and joints, and the part of it below a root."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

from graspdsl.spec.named_files import refusal
from graspdsl.spec.xml_files import xml_tree

FIXED = "fixed"
HINGES = ("revolute", "prismatic", "continuous")


@dataclass(frozen=True, slots=True)
class ModelJoint:
    """A joint of a model: its kind, the links it joins, its limits [rad or m], None where it has none."""

    kind: str
    parent: str
    child: str
    limits: tuple[float, float] | None
    effort: float | None


@dataclass(frozen=True, slots=True)
class RobotModel:
    """A model below its root: its XML, its links, its joints by name and the mesh files that it names."""

    tree: ElementTree.Element
    root: str
    links: tuple[str, ...]
    joints: Mapping[str, ModelJoint]
    meshes: tuple[str, ...]

    def with_meshes(self, places: Mapping[str, str]) -> str:
        """The text of the model, its mesh files named by their places."""
        for mesh in self.tree.iter("mesh"):
            mesh.set("filename", places.get(mesh.get("filename", ""), ""))
        return ElementTree.tostring(self.tree, encoding="unicode")


def robot_model(content: bytes, name: str, root: str) -> RobotModel:
    """The model in a URDF or MJCF file, without what is not below ``root`` (empty: all of it).

    Raises DiagnosticError for what is no URDF, for a root that is not there, and for links that form no tree.
    """
    tree = _parsed(content, name)
    joints = {joint.get("name", ""): _joint(joint, name) for joint in tree.findall("joint")}
    links = [link.get("name", "") for link in tree.findall("link")]
    children = {joint.child for joint in joints.values()}
    tops = [link for link in links if link not in children]
    if not root and len(tops) != 1:
        message = (
            f"{name} has {len(tops)} links without a parent, where a robot has one: {', '.join(tops[:5]) or 'none'}"
        )
        raise refusal("no-root", message, "name the link to begin with: root: …")
    root = root or tops[0]
    below = _below(root, joints)
    for element in [*tree.findall("link"), *tree.findall("joint")]:
        kept = below if element.tag == "link" else {n for n, joint in joints.items() if joint.parent in below}
        if element.get("name", "") not in kept:
            tree.remove(element)
    meshes = dict.fromkeys(mesh.get("filename", "") for mesh in tree.iter("mesh"))
    return RobotModel(
        tree,
        root,
        tuple(link for link in links if link in below),
        {n: joint for n, joint in joints.items() if joint.parent in below},
        tuple(meshes),
    )


def _parsed(content: bytes, name: str) -> ElementTree.Element:
    tree = xml_tree(content, name)
    if tree.tag == "mujoco":
        from graspdsl.hands.mjcf import urdf_of_mjcf

        try:
            return urdf_of_mjcf(tree, name)
        except ValueError as error:
            raise refusal("not-in-mjcf", f"{name}: a number cannot be read: {error}", None) from None
    if tree.tag != "robot":
        raise refusal("not-a-urdf", f"{name} is no URDF: its root is <{tree.tag}>, not <robot>", None)
    return tree


def _joint(joint: ElementTree.Element, file: str) -> ModelJoint:
    parent, child, limit = joint.find("parent"), joint.find("child"), joint.find("limit")
    if parent is None or child is None:
        raise refusal("not-a-urdf", f"{file}: the joint {joint.get('name')!r} does not join two links", None)
    try:
        ends = None if limit is None else (float(limit.get("lower", "0")), float(limit.get("upper", "0")))
        effort = None if limit is None else float(limit.get("effort", "0"))
    except ValueError:
        raise refusal(
            "not-a-urdf", f"{file}: the limits of the joint {joint.get('name')!r} are no numbers", None
        ) from None
    return ModelJoint(joint.get("type", ""), parent.get("link", ""), child.get("link", ""), ends, effort)


def _below(root: str, joints: Mapping[str, ModelJoint]) -> set[str]:
    found, waiting = {root}, [root]
    while waiting:
        link = waiting.pop()
        for joint in joints.values():
            if joint.parent == link and joint.child not in found:
                found.add(joint.child)
                waiting.append(joint.child)
    return found
