"""MJCF on its way to the compiler: includes put in place, every part named, without what only a scene needs."""

from __future__ import annotations

import posixpath
from collections.abc import Iterator, Mapping
from itertools import count
from typing import NamedTuple
from xml.etree import ElementTree

from graspdsl.models.source import Complaints
from graspdsl.places.files import SpecFolder, refusal
from graspdsl.places.wording import shortened
from graspdsl.places.xml_files import PlacedElement, place_in, xml_tree

MOST_INCLUDES = 100
MOST_COPIES = 1000
# Elements that say nothing of links and joints: what is seen and sensed, how the solver works, how a run begins.
PASSED_OVER = {"visual", "statistic", "custom", "size", "option", "sensor", "keyframe", "contact", "deformable"} | {
    *("extension", "texture", "hfield", "skin", "camera", "light", "plugin", "layer", "flex", "flexstrain", "flexvert"),
    "model",
}
PASSED_OVER_KEYS = ("texture", "content_type", "user")
UNREAD = ("composite", "flexcomp")
FOLDERS = ("meshdir", "assetdir", "texturedir")


class Mjcf(NamedTuple):
    """The tree for the compiler, and the files of meshes by the names that stand for them in it."""

    tree: ElementTree.Element
    meshes: Mapping[str, ElementTree.Element]


def mjcf_for_compiler(tree: PlacedElement, files: SpecFolder, name: str, complaints: Complaints) -> Mjcf:
    """What the compiler is to read of a <mujoco> in a file. Raises DiagnosticError where an include cannot be read."""
    folder = posixpath.dirname(name)
    whole = _whole(tree, files, folder, (name,), count())
    settings = {key: text for part in whole.findall("compiler") for key, text in part.attrib.items()}
    for part in whole.findall("compiler"):
        for key in FOLDERS:
            part.attrib.pop(key, None)
    ElementTree.SubElement(whole, "compiler", strippath="false", fusestatic="false", discardvisual="false")
    meshes = dict[str, ElementTree.Element]()
    inside = settings.get("meshdir", settings.get("assetdir", ""))
    for number, mesh in enumerate(whole.iterfind("asset/mesh")):
        file = mesh.get("file", "")
        if not file:
            what = "names no file"
            complaints.fault(mesh, "missing-key", f"the <mesh> {what}", 'write file="part.stl"')
            continue
        stand_in = f"mesh-{number}.obj"
        meshes[stand_in] = PlacedElement("mesh", {"filename": posixpath.join(inside, file)})
        stem = posixpath.splitext(posixpath.basename(file.replace("\\", "/")))[0]
        mesh.attrib.update({"name": mesh.get("name", stem), "file": stand_in})
    for world in whole.findall("worldbody"):
        for element in world.iter():
            if element.tag in UNREAD:
                message = f"a <{element.tag}> is no rigid body"
                complaints.fault(element, "not-a-body", message, "take it out, or build it of bodies and joints")
            elif element.tag == "attach":
                message = "what another model has is not attached here"
                complaints.fault(element, "not-a-body", message, "take it out, or <include> the bodies")
        _check_copies(world, 1, complaints)
    complaints.refuse()
    _name(whole)
    return Mjcf(whole, meshes)


def _check_copies(element: ElementTree.Element, copies: float, complaints: Complaints) -> None:
    """Complain of a <replicate> that makes more than anything with joints has."""
    for child in element:
        inside = copies
        if child.tag == "replicate":
            try:
                inside = copies * float(child.get("count", "1"))
            except ValueError:
                continue  # which the compiler refuses
        if inside > MOST_COPIES:
            message = f"<replicate> makes {inside:.6g} copies, where {MOST_COPIES} are read"
            complaints.fault(child, "file-too-large", message, "make fewer")
        else:
            _check_copies(child, inside, complaints)


def _whole(
    element: PlacedElement, files: SpecFolder, folder: str, inside: tuple[str, ...], included: Iterator[int]
) -> PlacedElement:
    """A copy of an element with what it includes, without what is passed over."""
    made = PlacedElement(element.tag, {k: text for k, text in element.attrib.items() if k not in PASSED_OVER_KEYS})
    made.file, made.line, made.column = element.file, element.line, element.column
    for child in element:
        assert isinstance(child, PlacedElement)
        if child.tag == "include":
            made.extend(list(_included(child, files, folder, inside, included)))
        elif child.tag not in PASSED_OVER and child.get("hfield") is None:
            made.append(_whole(child, files, folder, inside, included))
    return made


def _included(
    element: PlacedElement, files: SpecFolder, folder: str, inside: tuple[str, ...], included: Iterator[int]
) -> Iterator[PlacedElement]:
    """What stands in a file that an element includes."""
    name = posixpath.normpath(posixpath.join(folder, element.get("file", "")))
    at = place_in(element.file, element)
    if name in inside or next(included) > MOST_INCLUDES:
        message = f"{at}: {shortened(name)} includes itself, or there are more than {MOST_INCLUDES} <include>"
        raise refusal("wrong-include", message, "include each file once")
    beside = posixpath.normpath(posixpath.join(posixpath.dirname(element.file), element.get("file", "")))
    if beside != name and files.place(beside).is_file() and not files.place(name).is_file():
        name = beside
    root = xml_tree(files.read(name), name)
    yield from _whole(root, files, folder, (*inside, name), included)  # type: ignore[misc]  # all are PlacedElement


def _name(tree: ElementTree.Element) -> None:
    """Give bodies, joints and geoms without a name one."""
    parts = [(element, body) for world in tree.findall("worldbody") for element, body in _parts(world, "world")]
    taken = {(element.tag, element.get("name")) for element, _ in parts}
    bodies = dict[int, str]()
    for element, body in parts:
        name = element.get("name", "")
        if not name:
            stem = f"{bodies.get(id(body), 'world')}-joint" if element.tag == "joint" else element.tag
            stems = (stem if number == 0 and element.tag == "joint" else f"{stem}-{number + 1}" for number in count())
            name = next(stem for stem in stems if (element.tag, stem) not in taken)
            taken.add((element.tag, name))
            element.set("name", name)
        if element.tag == "body":
            bodies[id(element)] = name


def _parts(element: ElementTree.Element, body: object) -> Iterator[tuple[ElementTree.Element, object]]:
    """Bodies, joints and geoms, each with the body that it is in."""
    for child in element:
        if child.tag in ("body", "joint", "freejoint", "geom"):
            yield child, body
        if child.tag in ("body", "frame", "replicate"):
            yield from _parts(child, child if child.tag == "body" else body)
