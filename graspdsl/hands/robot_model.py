"""The model file of a hand, a URDF or MJCF: its links and joints, and the part of it below a root."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import deepcopy
from dataclasses import dataclass
from xml.etree import ElementTree

from graspdsl.diagnostics import Diagnostic, DiagnosticError, known_names_hint, listed
from graspdsl.hands.inertia_check import check_inertias
from graspdsl.hands.kinematic_tree import MOST_FAULTS, KinematicTree, TreeJoint
from graspdsl.hands.model_joints import CheckedJoint, ModelJoint, checked_joint
from graspdsl.hands.urdf_check import UrdfCheck
from graspdsl.hands.urdf_rules import HINGES, LINK, ROBOT
from graspdsl.spec.named_files import refusal
from graspdsl.spec.wording import shortened
from graspdsl.spec.xml_files import place_in, xml_tree

MOST_LINKS = 100  # the engine takes seconds for more: its time grows with their cube
MOST_NAMED = 5  # joints in a warning
MOST_HINGES = 100  # the engine's states hold 128, those of an arm among them


@dataclass(frozen=True, slots=True)
class RobotModel:
    """A model below its root: its XML as far as it was checked, its links, its joints by name, the mesh files that it
    names, those that are only drawn apart, and what is doubtful about it."""

    tree: ElementTree.Element
    root: str
    links: tuple[str, ...]
    joints: Mapping[str, ModelJoint]
    meshes: tuple[str, ...]
    drawn: tuple[str, ...]
    warnings: tuple[Diagnostic, ...] = ()

    def with_meshes(self, places: Mapping[str, str]) -> str:
        """The text of the model, its mesh files named by their places; looks of one without a place are left out.

        Raises KeyError for one of ``meshes`` without a place.
        """
        tree = deepcopy(self.tree)
        for link in tree.findall("link"):
            for visual in link.findall("visual"):
                if any(mesh.get("filename", "") not in places for mesh in visual.iter("mesh")):
                    link.remove(visual)
        for mesh in tree.iter("mesh"):
            mesh.set("filename", places[mesh.get("filename", "")])
        return ElementTree.tostring(tree, encoding="unicode")

    def movers(self, link: str) -> tuple[str, ...]:
        """The joints from the root to a link, the first one first."""
        before = {joint.child: (name, joint.parent) for name, joint in self.joints.items()}
        chain = []
        while link in before:
            name, link = before[link]
            chain.append(name)
        return tuple(reversed(chain))


def robot_model(content: bytes, name: str, root: str) -> RobotModel:
    """The model in a URDF or MJCF file, without what is not below ``root`` (empty: all of it).

    Raises DiagnosticError for what is no URDF, for links that form no tree, for a root that is not there, and with
    every number that the engine could not take.
    """
    check = UrdfCheck(name)
    robot = _parsed(content, name, check)
    whole = KinematicTree.of(robot, name)
    if root and root not in whole.links:
        raise refusal(
            "unknown-root", f"there is no link {root!r} in the model", known_names_hint(root, whole.links, "links")
        )
    rooted, root = bool(root), root or whole.root
    below = whole.below(root)
    joints = {joint: found for joint, found in whole.joints.items() if found.parent in below}
    _moderate(below, joints, name, rooted)
    kept = check.copy(robot, ROBOT, "a material")
    kept.set("name", "hand")
    links = {link: check.copy(whole.links[link], LINK, f"the link {link}") for link in whole.links if link in below}
    checked = {joint: checked_joint(joint, found, check) for joint, found in joints.items()}
    _warn_of_friction(checked, check)
    if not check.found:
        check_inertias(whole, root, links, checked, check)
    if check.found:
        raise DiagnosticError(check.found[:MOST_FAULTS])
    for link in links.values():
        _without_mass(link)
        kept.append(link)
    kept.extend(found.made for found in checked.values())
    meshes = _meshes(kept, "collision")
    return RobotModel(
        kept,
        root,
        tuple(links),
        {joint: found.joint for joint, found in checked.items()},
        meshes,
        tuple(name for name in _meshes(kept, "visual") if name not in meshes),
        tuple(check.warnings),
    )


def _parsed(content: bytes, name: str, check: UrdfCheck) -> ElementTree.Element:
    tree = xml_tree(content, name)
    if tree.tag == "mujoco":
        from graspdsl.hands.mjcf import urdf_of_mjcf

        return urdf_of_mjcf(tree, name, check.warnings.append)
    if tree.tag != "robot":
        message = f"{name} is no URDF: its root is <{shortened(tree.tag)}>, not <robot>"
        raise refusal("not-a-urdf", message, "name a URDF or a MJCF file")
    macro = next((element for element in tree.iter() if "xacro" in element.tag.rpartition("}")[0]), None)
    if macro is not None:
        message = f"{place_in(name, macro)}: this is a xacro file, not yet a URDF"
        raise refusal("not-a-urdf", message, "expand it: xacro hand.xacro > hand.urdf")
    return tree


def _moderate(below: Iterable[str], joints: Mapping[str, TreeJoint], file: str, rooted: bool) -> None:
    links = len(set(below))
    moving = sum(joint.kind in HINGES for joint in joints.values())
    for count, most, what in ((links, MOST_LINKS, "links"), (moving, MOST_HINGES, "joints that move")):
        if count > most:
            message = f"{file} has {count} {what} below the root, where a hand may have {most}"
            hint = "name a root nearer to the fingers" if rooted else "name the link the hand begins with: root: …"
            raise refusal("too-many-links", message, hint)


def _warn_of_friction(joints: Mapping[str, CheckedJoint], check: UrdfCheck) -> None:
    """The engine reads the friction of a joint and does nothing with it."""
    rubbing = [
        name
        for name, joint in joints.items()
        if any(float(dynamics.get("friction", "0")) > 0.0 for dynamics in joint.made.iterfind("dynamics"))
    ]
    if rubbing:
        names = listed([*rubbing[:MOST_NAMED], *(["others"] if len(rubbing) > MOST_NAMED else [])])
        message = f"the friction in {names} has no effect: the engine's joints have none"
        check.warn(joints[rubbing[0]].element, "no-effect", message, "give them damping, or leave it out")


def _meshes(robot: ElementTree.Element, use: str) -> tuple[str, ...]:
    found = robot.iterfind(f"link/{use}/geometry/mesh")
    return tuple(dict.fromkeys(mesh.get("filename", "") for mesh in found))


def _without_mass(link: ElementTree.Element) -> None:
    """A link that says nothing of its mass has none, as URDF has it; the engine would give it a kilogram."""
    if link.find("inertial") is None:
        inertial = ElementTree.SubElement(link, "inertial")
        ElementTree.SubElement(inertial, "mass", value="0")
        zeros = dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), "0")
        ElementTree.SubElement(inertial, "inertia", zeros)
