"""The model file of a hand, a URDF or MJCF: its links and joints, and the part of it below a root."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from xml.etree import ElementTree

from graspdsl.diagnostics import Diagnostic, DiagnosticError, known_names_hint, listed
from graspdsl.hands.inertia_check import check_inertias
from graspdsl.hands.kinematic_tree import MOST_FAULTS, KinematicTree, TreeJoint
from graspdsl.hands.model_joints import UNSTATED_EFFORT, CheckedJoint, ModelJoint, checked_joint
from graspdsl.hands.urdf_check import UrdfCheck
from graspdsl.hands.urdf_rules import CONTINUOUS, FIXED, HINGES, LINK, MOVING_JOINT, ROBOT
from graspdsl.places.files import refusal
from graspdsl.places.wording import shortened
from graspdsl.places.xml_files import place_in, xml_tree

MOST_LINKS = 100  # the engine takes seconds for more: its time grows with their cube
MOST_NAMED = 5  # joints in a warning
MOST_HINGES = 100  # the engine's states hold 128, those of an arm among them


@dataclass(frozen=True, slots=True)
class RobotModel:
    """A model below its root: its XML as far as it was checked, its links, its joints by name, the mesh files that it
    names, those that are only drawn apart, what is doubtful about it, and the links and joints with faults."""

    tree: ElementTree.Element
    root: str
    links: tuple[str, ...]
    joints: Mapping[str, ModelJoint]
    meshes: tuple[str, ...]
    drawn: tuple[str, ...]
    warnings: tuple[Diagnostic, ...] = ()
    unsound: frozenset[str] = frozenset()

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


class FaultyModelError(DiagnosticError):
    """The faults of a model, and what could be read of it."""

    def __init__(self, diagnostics: Sequence[Diagnostic], model: RobotModel) -> None:
        self.model = model
        super().__init__(diagnostics)


def robot_model(content: bytes, name: str, root: str) -> RobotModel:
    """The model in a URDF or MJCF file, without what is not below ``root`` (empty: all of it).

    Raises DiagnosticError for what is no URDF, for links that form no tree, and for a root that is not there;
    FaultyModelError, which is one, with every number that the engine could not take.
    """
    check = UrdfCheck(name)
    robot = _parsed(content, name, check)
    whole = _tree(robot, root, check)
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
    links = {
        link: check.part(link, whole.links[link], LINK, f"the link {link}") for link in whole.links if link in below
    }
    checked = {joint: checked_joint(joint, found, check) for joint, found in joints.items()}
    _warn_of_friction(checked, check)
    _warn_of_efforts(checked, check)
    check_inertias(whole, root, links, checked, check)
    for link in links.values():
        _without_mass(link)
        kept.append(link)
    kept.extend(found.made for found in checked.values())
    meshes = _meshes(kept, "collision")
    model = RobotModel(
        kept,
        root,
        tuple(links),
        {joint: found.joint for joint, found in checked.items()},
        meshes,
        tuple(name for name in _meshes(kept, "visual") if name not in meshes),
        tuple(check.warnings),
        frozenset(check.unsound),
    )
    if check.found:
        raise FaultyModelError(check.found[:MOST_FAULTS], model)
    return model


def _tree(robot: ElementTree.Element, root: str, check: UrdfCheck) -> KinematicTree:
    try:
        return KinematicTree.of(robot, check.file)
    except DiagnosticError as error:
        # Without a tree nobody knows what is below a root.
        for element in () if root else robot:
            rule = {"link": LINK, "joint": MOVING_JOINT}.get(element.tag)
            if rule is not None:
                check.copy(element, rule, f"the {element.tag} {shortened(element.get('name', ''))}")
        raise DiagnosticError([*error.diagnostics, *check.found][:MOST_FAULTS]) from None


def _parsed(content: bytes, name: str, check: UrdfCheck) -> ElementTree.Element:
    tree = xml_tree(content, name)
    if tree.tag == "mujoco":
        from graspdsl.hands.mjcf import urdf_of_mjcf

        return urdf_of_mjcf(tree, check)
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
        message = f"the friction in {_some(rubbing)} has no effect: the engine's joints have none"
        check.warn(joints[rubbing[0]].element, "no-effect", message, "give them damping, or leave it out")


def _warn_of_efforts(joints: Mapping[str, CheckedJoint], check: UrdfCheck) -> None:
    """No motor is driven without a bound to its effort."""
    weak = [
        name
        for name, joint in joints.items()
        if (joint.joint.kind == CONTINUOUS or joint.joint.limits is not None)
        and joint.joint.kind != FIXED
        and name not in check.unsound
        and not any(float(limit.get("effort", "0")) for limit in joint.made.iterfind("limit"))
    ]
    if weak:
        message = (
            f"the model says no effort, or 0, of {_some(weak)}: up to {UNSTATED_EFFORT:g} N m, or N of a slide, is used"
        )
        hint = 'say how strong they are: effort="…" in <limit>, actuatorfrcrange="-… …" in MJCF'
        check.warn(joints[weak[0]].element, "no-effort", message, hint)


def _some(names: Sequence[str]) -> str:
    return listed([*names[:MOST_NAMED], *(["others"] if len(names) > MOST_NAMED else [])])


def _meshes(robot: ElementTree.Element, use: str) -> tuple[str, ...]:
    found = robot.iterfind(f"link/{use}/geometry/mesh")
    return tuple(dict.fromkeys(name for mesh in found if (name := mesh.get("filename"))))


def _without_mass(link: ElementTree.Element) -> None:
    """A link that says nothing of its mass has none, as URDF has it; the engine would give it a kilogram."""
    if link.find("inertial") is None:
        inertial = ElementTree.SubElement(link, "inertial")
        ElementTree.SubElement(inertial, "mass", value="0")
        zeros = dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), "0")
        ElementTree.SubElement(inertial, "inertia", zeros)
