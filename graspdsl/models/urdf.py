"""URDF on its way to the compiler: one tree below a root, numbers that are numbers, shapes that are known."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple
from xml.etree import ElementTree

from graspdsl.diagnostics import known_names_hint, listed
from graspdsl.models.joint_kinds import CONTINUOUS, FIXED, HINGES, PRISMATIC
from graspdsl.models.kinematic_tree import KinematicTree, TreeJoint
from graspdsl.models.model import Mimic
from graspdsl.models.source import Complaints, is_number
from graspdsl.places.files import refusal
from graspdsl.places.wording import shortened
from graspdsl.places.xml_files import PlacedElement

# How many numbers an attribute has, and what they are not below; sizes are above it.
ANY = -math.inf
NUMBERS: Mapping[str, tuple[int, float]] = {
    **dict.fromkeys(("xyz", "rpy", "scale"), (3, ANY)),
    **dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz", "lower", "upper", "multiplier", "offset"), (1, ANY)),
    **dict.fromkeys(("value", "effort", "velocity", "damping", "friction"), (1, 0.0)),
    **dict.fromkeys(("radius", "length"), (1, 0.0)),
    "size": (3, 0.0),
}
SIZES = ("size", "radius", "length", "scale")  # none of which is zero
NEEDED = {
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "mesh": ("filename",),
    "mass": ("value",),
    "inertia": ("ixx", "iyy", "izz"),
    "mimic": ("joint",),
    "axis": ("xyz",),
}
MOST_LINKS = 100  # the Bullet engine takes seconds for more: its time grows with their cube
MOST_HINGES = 100  # its states hold 128, those of an arm among them
SHAPES = ("box", "sphere", "cylinder", "capsule", "mesh")
COUNTS = {1: "a number", 3: "three numbers"}
# What is read of a link or a joint; the rest, of simulators and planners, is passed over.
ELEMENTS = {"inertial", "mass", "inertia", "visual", "collision", "geometry", *SHAPES, "material", "color"} | {
    *("origin", "axis", "limit", "dynamics", "parent", "child")
}
ATTRIBUTES = {"name", "type", "link", "joint", "filename", "rgba", *NUMBERS}
MANY = ("visual", "collision")
PRODUCTS = dict.fromkeys(("ixy", "ixz", "iyz"), "0")


class Urdf(NamedTuple):
    """The tree for the compiler, its root, and what the compiler does not keep: the names of the joints before links,
    the joints that are held at a place, and what follows what."""

    tree: ElementTree.Element
    root: str
    before: Mapping[str, str]
    held: Mapping[str, float]
    mimics: Mapping[str, Mimic]
    meshes: Mapping[str, ElementTree.Element]


def urdf_for_compiler(robot: ElementTree.Element, file: str, root: str, complaints: Complaints) -> Urdf:
    """What the compiler is to read of a <robot>: what is below ``root`` (empty: all).

    Raises DiagnosticError where links and joints form no tree, or there is no such root; faults of elements are noted.
    """
    whole = KinematicTree.of(robot, file)
    if root and root not in whole.links:
        message = f"there is no link {root!r} in the model"
        raise refusal("unknown-root", message, known_names_hint(root, whole.links, "links"))
    below = whole.below(root or whole.root)
    tree = PlacedElement("robot", name="model")
    options = ElementTree.SubElement(tree, "mujoco")
    ElementTree.SubElement(options, "compiler", strippath="false", fusestatic="false", discardvisual="false")
    tree.extend(_coloured(robot.findall("material")))
    tree.extend(_link(link, complaints) for name, link in whole.links.items() if name in below)
    joints = {name: joint for name, joint in whole.joints.items() if joint.parent in below}
    moderate(len(below), sum(joint.kind in HINGES for joint in joints.values()), file, bool(root))
    mimics, held = dict[str, Mimic](), dict[str, float]()
    for name, joint in joints.items():
        tree.append(_joint(name, joint, complaints))
        mimics |= _mimic(name, joint, complaints)
        held |= _held(name, joint, complaints)
        if name in held:
            tree[-1].remove(tree[-1].findall("limit")[0])  # the compiler takes equal ends for none, aloud
    for number, part in enumerate(part for link in tree.iterfind("link") for part in link):
        if part.tag in ("visual", "collision"):
            part.set("name", f"geom-{number}")
    meshes = {}
    for number, mesh in enumerate(tree.iter("mesh")):
        stand_in = f"mesh-{number}.obj"
        meshes[stand_in] = PlacedElement("mesh", mesh.attrib)
        mesh.set("filename", stand_in)
    before = {joint.child: name for name, joint in joints.items()}
    return Urdf(tree, root or whole.root, before, held, mimics, meshes)


def moderate(links: int, moving: int, file: str, rooted: bool) -> None:
    """Raises DiagnosticError where there are more links or joints than an engine can take."""
    for count, most, what in ((links, MOST_LINKS, "links"), (moving, MOST_HINGES, "joints that move")):
        if count > most:
            message = f"{file} has {count} {what} below the root, where a hand may have {most}"
            hint = "name a root nearer to the fingers" if rooted else "name the link the hand begins with: root: …"
            raise refusal("too-many-links", message, hint)


def _link(link: ElementTree.Element, complaints: Complaints) -> ElementTree.Element:
    owner = f"the link {link.get('name', '')}"
    made = _copied(link)
    for part in made.findall("visual"):
        for material in part.findall("material"):
            part.remove(material)
            part.extend(_coloured([material]))
        found = Complaints()
        _check(part, owner, found)
        _check_shape(part, owner, found)
        for fault in found.faults[:1]:
            complaints.undrawn(fault)
            made.remove(part)
    for part in made.findall("collision"):
        _check_shape(part, owner, complaints)
    _check(made, owner, complaints)
    return made


def _check_shape(part: ElementTree.Element, owner: str, complaints: Complaints) -> None:
    shapes = [shape.tag for shape in part.iterfind("geometry/*")]
    if len(shapes) != 1 or shapes[0] not in SHAPES:
        found = listed(f"<{shortened(tag)}>" for tag in shapes[:5]) or "none"
        message = f"{owner}: expected one shape in the <geometry> of a <{part.tag}>, found {found}"
        complaints.fault(part, "wrong-shape", message, f"known shapes: {', '.join(SHAPES)}")


def _joint(name: str, joint: TreeJoint, complaints: Complaints) -> ElementTree.Element:
    made, owner = _copied(joint.element), f"the joint {name}"
    if joint.kind != FIXED and joint.kind not in HINGES:
        found = f"is of the type {shortened(joint.kind)!r}" if joint.kind else "has no type"
        complaints.fault(made, "unknown-joint-type", f"{owner} {found}", f"known types: {', '.join((FIXED, *HINGES))}")
    if joint.kind == FIXED:
        for element in made.findall("*"):
            if element.tag not in ("origin", "parent", "child"):
                made.remove(element)
    _check(made, owner, complaints)
    return made


def _mimic(name: str, joint: TreeJoint, complaints: Complaints) -> dict[str, Mimic]:
    element = joint.element.find("mimic")
    if element is None or joint.kind == FIXED:
        return {}
    before = len(complaints.faults)
    _check(_copied(element), f"the joint {name}", complaints)
    if len(complaints.faults) > before:
        return {}
    multiplier, offset = float(element.get("multiplier", "1")), float(element.get("offset", "0"))
    return {name: Mimic(element.get("joint", ""), multiplier, offset)}


def _held(name: str, joint: TreeJoint, complaints: Complaints) -> dict[str, float]:
    """The place of a joint whose limits leave it none to move to."""
    limit = joint.element.find("limit")
    if limit is None or joint.kind in (FIXED, CONTINUOUS):
        return {}
    ends = [limit.get(key, "0") for key in ("lower", "upper")]
    if not all(map(is_number, ends)):
        return {}
    low, high = map(float, ends)
    if low > high:
        message = f"the joint {name}: its limits leave no room: {low:g} to {high:g}"
        complaints.fault(limit, "out-of-range", message, "the lower limit must be below the upper one")
    elif joint.kind != PRISMATIC and max(-low, high) > MOST_TURN:
        message = f"the joint {name} turns from {low:g} to {high:g} rad, beyond a whole turn"
        degrees = f"if they are degrees, write lower={math.radians(low):.4g} upper={math.radians(high):.4g}"
        complaints.warn(limit, "beyond-a-turn", message, f"limits are in radians; {degrees}")
    return {name: low} if low == high else {}


MOST_TURN = 6.3  # rad, a turn to either side
MOST_ANGLE = 4.0 * math.pi  # rad


def _check(element: ElementTree.Element, owner: str, complaints: Complaints) -> None:
    """Complain about numbers that are none, of the wrong count or too small, and about what is not there."""
    for part in element.iter():
        for key in NEEDED.get(part.tag, ()):
            if not part.get(key):
                complaints.fault(part, "missing-key", f"{owner}: its <{part.tag}> has no {key}", f'write {key}="…"')
        tags = [child.tag for child in part]
        for tag in {*tags} - {*MANY, *SHAPES}:
            if tags.count(tag) > 1:
                message = f"{owner}: expected one <{tag}> in <{part.tag}>, found {tags.count(tag)}"
                complaints.fault(part.findall(tag)[1], "declared-twice", message, "keep one of them")
        for tag in ("mass", "inertia") if part.tag == "inertial" else ():
            if part.find(tag) is None:
                complaints.fault(part, "missing-element", f"{owner}: <inertial> has no <{tag}>", f"add <{tag}>")
        for key, text in part.attrib.items():
            if key in NUMBERS and text:
                _check_numbers(part, key, text, owner, complaints)


def _check_numbers(part: ElementTree.Element, key: str, text: str, owner: str, complaints: Complaints) -> None:
    count, least = NUMBERS[key]
    words, what = text.split(), f"the {key} of <{part.tag}>"
    if len(words) != count or not all(map(is_number, words)):
        message = f"{owner}: expected {COUNTS[count]} as {what}, found {shortened(text)!r}"
        complaints.fault(part, "not-a-number", message, "write finite numbers, blanks between them")
        return
    numbers = [float(word) for word in words]
    if min(numbers) < least or (key in SIZES and not all(numbers)):
        message = f"{owner}: {what} is {'negative' if min(numbers) < least else 'zero'}: {shortened(text)}"
        complaints.fault(part, "out-of-range", message, "sizes are in metres, masses in kilograms")
    elif key == "rpy" and max(map(abs, numbers)) > MOST_ANGLE:
        message = f"{owner}: {what} is beyond two turns: {shortened(text)}"
        complaints.fault(part, "out-of-range", message, "angles are in radians")
    elif part.tag == "axis" and not any(numbers):
        complaints.fault(part, "zero-axis", f"{owner}: its axis is zero", 'give it a direction: xyz="0 0 1"')


def _copied(element: ElementTree.Element) -> ElementTree.Element:
    """A copy of an element at its place, with only what is read of it."""
    made = PlacedElement(element.tag, {key: text for key, text in element.attrib.items() if key in ATTRIBUTES})
    if isinstance(element, PlacedElement):
        made.file, made.line, made.column = element.file, element.line, element.column
    if element.tag == "inertia":
        made.attrib = {**PRODUCTS, **made.attrib}
    made.extend(_copied(child) for child in element if child.tag in ELEMENTS or element.tag == "geometry")
    return made


def _coloured(materials: Iterable[ElementTree.Element]) -> list[PlacedElement]:
    """Materials with colours that are some, without all else."""
    found = []
    for material in materials:
        made = PlacedElement("material", {"name": material.get("name", "")})
        for colour in material.findall("color"):
            words = colour.get("rgba", "").split()
            if len(words) == 4 and all(map(is_number, words)):
                rgba = " ".join(repr(min(max(float(word), 0.0), 1.0)) for word in words)
                made.append(PlacedElement("color", {"rgba": rgba}))
        found.append(made)
    return found
