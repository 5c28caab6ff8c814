"""URDF files as solids: their collision geometry about the centre of its bounding box, as one rigid body."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import PurePosixPath
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from graspdsl.angles import roll_pitch_yaw
from graspdsl.arrays import Array
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity
from graspdsl.objects.box import Box
from graspdsl.objects.compound import Compound, Placed, centred, rotation_of
from graspdsl.objects.cylinder import Cylinder
from graspdsl.objects.mesh_files import mesh_of_file
from graspdsl.objects.overlaps import overlaps
from graspdsl.objects.shape import Extent, Shape
from graspdsl.objects.sphere import Sphere
from graspdsl.places.files import SpecFolder, refusal
from graspdsl.places.mesh_places import MeshPlaces
from graspdsl.places.xml_files import place_in, xml_tree

MOST_PARTS = 200
MOST_LINKS = 2000
MOST_FAULTS = 20  # that are told at once
MOST_LENGTH = 1e6  # m

Warn = Callable[[Diagnostic], None]


class Frame(NamedTuple):
    """Where a link or a part of it is: position (3,) [m] and rotation (3, 3)."""

    position: Array
    rotation: Array

    def then(self, other: Frame) -> Frame:
        """A frame given in this one."""
        return Frame(self.position + self.rotation @ other.position, self.rotation @ other.rotation)


ORIGIN = Frame(np.zeros(3), np.eye(3))


class UrdfObject(NamedTuple):
    """The shape of a URDF and the sum of the masses [kg] that it states, zero where it states none."""

    shape: Compound
    mass: float


def object_of_urdf(name: str, folder: SpecFolder, warn: Warn) -> UrdfObject:
    """The collision geometry of a URDF file as one solid of the masses that it states; its inertias are not believed.

    Each part is of even density, so that the centre of mass and the inertia count twice what is in two of them, also in
    a file that states its own: that is said to ``warn`` where two parts notably overlap, as ``overlaps`` estimates it.
    Raises DiagnosticError when it has none, is no URDF, or has joints that move, with all faults of its parts.
    """
    if PurePosixPath(name).suffix.lower() != ".urdf":
        raise refusal("unknown-urdf-format", f"{name} is no URDF file: expected .urdf", "name a .urdf, or use mesh")
    return _Urdf(name, folder.read(name), folder, warn).read()


class _Urdf:
    def __init__(self, name: str, content: bytes, folder: SpecFolder, warn: Warn) -> None:
        self._name, self._folder, self._warn = name, folder, warn
        self._meshes = MeshPlaces(folder, name)
        self._part_places: list[str] = []
        self._found: list[Diagnostic] = []
        self._robot = xml_tree(content, name)
        if self._robot.tag != "robot":
            raise self._bad(f"its root is <{self._robot.tag}>, not <robot>")

    def read(self) -> UrdfObject:
        links = {link.get("name", ""): link for link in self._robot.iter("link")}
        if len(links) > MOST_LINKS:
            raise self._bad(f"it has {len(links)} links, where an object may have {MOST_LINKS}")
        frames = self._frames(links)
        parts = [
            self._placed(frames.get(name, ORIGIN).then(frame), part)
            for name in links
            for frame, part in self._parts(links[name])
        ]
        masses = [mass for link in links.values() for mass in self._masses(link)]
        if self._found:
            raise DiagnosticError(self._found[:MOST_FAULTS])
        if not parts:
            raise self._bad("it has no collision geometry")
        if len(parts) > MOST_PARTS:
            raise self._bad(f"it has {len(parts)} parts, where an object may have {MOST_PARTS}")
        self._warn_of_overlaps(parts)
        return UrdfObject(centred(parts), max(sum(masses), 0.0))

    @contextmanager
    def _noting(self) -> Iterator[None]:
        """What is wrong within is noted, and the rest of it passed over."""
        try:
            yield
        except DiagnosticError as error:
            self._found += error.diagnostics

    def _masses(self, link: ElementTree.Element) -> Iterator[float]:
        for mass in link.findall("inertial/mass"):
            with self._noting():
                yield self._number(mass, "value", 0.0)

    def _warn_of_overlaps(self, parts: list[Placed]) -> None:
        found = next(overlaps(parts), None)
        if found is None:
            return
        first, second = self._part_places[found.first], self._part_places[found.second]
        message = (
            f"the collision parts at {first} and {second} share about {found.share:.0%} of the smaller: "
            "the centre of mass and the inertia of the object count twice what is in both"
        )
        hint = "make the parts touch without overlapping"
        self._warn(Diagnostic("overlapping-parts", message, None, hint, Severity.WARNING))

    def _frames(self, links: dict[str, ElementTree.Element]) -> dict[str, Frame]:
        """Each link's frame in that of the root, all joints fixed; none where these have faults."""
        joints: dict[str, tuple[str, Frame]] = {}
        for joint in self._robot.findall("joint"):
            with self._noting():
                name, kind = joint.get("name", ""), joint.get("type", "")
                if kind != "fixed":
                    what = f"its joint {name} is {kind or 'of no type'}: an object is one rigid body"
                    raise self._bad(what, joint)
                parent, child = (
                    element.get("link", "") if (element := joint.find(tag)) is not None else ""
                    for tag in ("parent", "child")
                )
                if parent not in links or child not in links or child in joints:
                    raise self._bad(f"its joint {name} does not join two links into a tree", joint)
                joints[child] = (parent, self._frame(joint))
        if self._found:
            return {}
        tops = [name for name in links if name not in joints]
        inside: dict[str, list[str]] = {}
        for name, (parent, _) in joints.items():
            inside.setdefault(parent, []).append(name)
        frames = dict.fromkeys(tops, ORIGIN)
        waiting = list(tops)
        while waiting:
            above = waiting.pop()
            for name in inside.get(above, ()):
                frames[name] = frames[above].then(joints[name][1])
                waiting.append(name)
        if len(frames) < len(links):
            raise self._bad("its joints go round in a circle")
        if len(tops) != 1:
            raise self._bad("its links are not joined to one body")
        return frames

    def _parts(self, link: ElementTree.Element) -> Iterator[tuple[Frame, Shape]]:
        for collision in link.findall("collision"):
            for geometry in collision.findall("geometry/*"):
                with self._noting():
                    self._part_places.append(place_in(self._name, geometry))
                    yield self._frame(collision), self._part(geometry)

    def _part(self, geometry: ElementTree.Element) -> Shape:
        # Not validated: a part may be smaller or larger than a shape in a spec.
        match geometry.tag:
            case "box":
                return Box.model_construct(size=self._lengths(geometry, "size"))
            case "sphere":
                return Sphere.model_construct(diameter=2 * self._length(geometry, "radius"))
            case "cylinder":
                diameter, height = 2 * self._length(geometry, "radius"), self._length(geometry, "length")
                return Cylinder.model_construct(diameter=diameter, height=height)
            case "mesh":
                name = self._meshes.name(geometry.get("filename", ""))
                scale = np.array(self._numbers(geometry, "scale", (1.0, 1.0, 1.0)))
                if not (np.abs(scale) > 0.0).all():
                    raise self._bad("the scale of a mesh is zero", geometry)
                return mesh_of_file(name, self._folder.read(name), scale, None, self._warn, centred=False)
        raise self._bad(f"it has geometry of an unknown kind, <{geometry.tag}>", geometry)

    def _placed(self, frame: Frame, part: Shape) -> Placed:
        x, y, z = frame.position.tolist()
        return Placed(part, (x, y, z), roll_pitch_yaw(frame.rotation))

    def _frame(self, element: ElementTree.Element) -> Frame:
        origin = element.find("origin")
        if origin is None:
            return ORIGIN
        rotation = rotation_of(self._numbers(origin, "rpy", (0.0, 0.0, 0.0)))
        return Frame(np.array(self._numbers(origin, "xyz", (0.0, 0.0, 0.0))), rotation)

    def _numbers(self, element: ElementTree.Element, key: str, otherwise: Extent | None) -> Extent:
        text = element.get(key)
        if text is None and otherwise is not None:
            return otherwise
        try:
            x, y, z = (float(number) for number in (text or "").split())
        except ValueError:
            what = f"expected three numbers in the {key} of its <{element.tag}>, found {text!r}"
            raise self._bad(what, element) from None
        if not max(abs(x), abs(y), abs(z)) < MOST_LENGTH:
            raise self._bad(f"the {key} of its <{element.tag}> is out of bounds: {text}", element)
        return x, y, z

    def _number(self, element: ElementTree.Element, key: str, otherwise: float | None) -> float:
        text = element.get(key)
        if text is None and otherwise is not None:
            return otherwise
        try:
            number = float(text or "")
        except ValueError:
            what = f"expected a number in the {key} of its <{element.tag}>, found {text!r}"
            raise self._bad(what, element) from None
        if not abs(number) < MOST_LENGTH:
            raise self._bad(f"the {key} of its <{element.tag}> is out of bounds: {text}", element)
        return number

    def _length(self, element: ElementTree.Element, key: str) -> float:
        length = self._number(element, key, None)
        if length <= 0.0:
            raise self._bad(f"the {key} of its <{element.tag}> is not positive: {length:g}", element)
        return length

    def _lengths(self, element: ElementTree.Element, key: str) -> Extent:
        lengths = self._numbers(element, key, None)
        if min(lengths) <= 0.0:
            raise self._bad(f"the {key} of its <{element.tag}> is not positive: {lengths}", element)
        return lengths

    def _bad(self, what: str, element: ElementTree.Element | None = None) -> DiagnosticError:
        place = self._name if element is None else f"{place_in(self._name, element)}: this"
        return refusal("bad-urdf", f"{place} is no URDF of an object: {what}", None)
