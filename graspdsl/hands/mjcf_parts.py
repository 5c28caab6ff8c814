"""Elements of a MJCF file with their attributes, and what is wrong with them at its line and column."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.diagnostics import Diagnostic, DiagnosticError, listed
from graspdsl.hands.urdf_check import NUMBER
from graspdsl.places.wording import shortened
from graspdsl.places.xml_files import place_in

Attributes = Mapping[str, str]

IN_URDF = "take it out, or describe the hand in URDF"
ORIENTATIONS = ("quat", "euler", "axisangle", "xyaxes", "zaxis")
LONGEST = 200  # characters of a complaint
SHORTEST = 1e-10  # the length of a vector that has no direction
LARGEST = 1e6  # of a number, of any unit: squares of these and their sums are numbers still
WHOLE = re.compile(r"\s*[+-]?\d{1,10}\s*", re.ASCII)
BITS = 32  # of a mask, its sign among them


class Pose(NamedTuple):
    """A frame in another: its origin (3,) [m] and how it is turned."""

    place: Array
    turned: Rotation

    def then(self, inner: Pose) -> Pose:
        """A frame given in this one."""
        return Pose(self.place + self.turned.apply(inner.place), self.turned * inner.turned)


HERE = Pose(np.zeros(3), Rotation.identity())


class NotInMjcfError(DiagnosticError):
    """Complaints about one element, each with its kind, which is the same where the same is wrong with another."""

    def __init__(self, complaints: Mapping[str, Diagnostic]) -> None:
        self.complaints = complaints
        super().__init__(list(complaints.values()))


def refuse_all(errors: Sequence[NotInMjcfError]) -> None:
    """Raises NotInMjcfError with the complaints of all of these, where there are any."""
    if errors:
        raise NotInMjcfError({kind: found for error in errors for kind, found in error.complaints.items()})


@dataclass(slots=True)
class Source:
    """A MJCF file, by its name, and what is wrong with it: of each kind the first complaint, and how many there are."""

    file: str
    found: dict[str, tuple[Diagnostic, int]] = field(default_factory=dict)

    def refused(
        self, element: ElementTree.Element, what: str, hint: str | None = IN_URDF, called: str = ""
    ) -> NotInMjcfError:
        """A complaint about an element, at its line and column."""
        message = f"{place_in(self.file, element)}: {shortened(f'{called}{what}', LONGEST)}"
        return NotInMjcfError({f"{element.tag}: {what}": Diagnostic("not-in-mjcf", message, hint=hint)})

    @contextmanager
    def noting(self) -> Iterator[None]:
        """What is wrong within is noted, and the rest of it passed over."""
        try:
            yield
        except NotInMjcfError as error:
            for kind, complaint in error.complaints.items():
                first, count = self.found.get(kind, (complaint, 0))
                self.found[kind] = first, count + 1

    def complaints(self) -> Iterator[Diagnostic]:
        """All that was noted."""
        for first, count in self.found.values():
            more = f"; and so of {count - 1} more" if count > 1 else ""
            yield replace(first, message=f"{first.message}{more}")


@dataclass(frozen=True, slots=True)
class Part:
    """An element with its attributes, those of its class of defaults among them."""

    source: Source
    element: ElementTree.Element
    attributes: Attributes

    @property
    def called(self) -> str:
        """Its tag and name, for messages."""
        return " ".join(filter(None, (f"<{self.element.tag}>", self.attributes.get("name"))))

    def refused(self, what: str, hint: str | None = IN_URDF) -> NotInMjcfError:
        """A complaint about it."""
        return self.source.refused(self.element, what, hint, f"{self.called}: ")

    def word(self, key: str, known: tuple[str, ...]) -> str:
        """One of the known words, the first where it says nothing."""
        word = self.attributes.get(key, known[0])
        if word not in known:
            raise self.refused(f"its {key} is {word!r}", f"expected {listed(known, 'or')}")
        return word

    def numbers(self, key: str, otherwise: str, *counts: int) -> Array:
        """So many numbers as one of the counts says, none beyond ``LARGEST``."""
        text = self.attributes.get(key, otherwise)
        words = text.split()
        if not all(map(NUMBER.fullmatch, words)):
            raise self.refused(f"its {key} is {text!r}", "expected finite numbers with blanks between them")
        numbers = np.array([float(word) for word in words])
        if len(numbers) not in counts:
            expected = listed([str(count) for count in counts], "or")
            raise self.refused(f"its {key} is {text!r}", f"expected {expected} numbers")
        if np.abs(numbers).max(initial=0.0) > LARGEST:
            raise self.refused(f"its {key} is {text!r}", f"expected numbers from {-LARGEST:g} to {LARGEST:g}")
        return numbers

    def number(self, key: str, otherwise: str) -> float:
        """One number."""
        return float(self.numbers(key, otherwise, 1)[0])

    def mask(self, key: str, otherwise: str) -> int:
        """The bits of a mask."""
        text = self.attributes.get(key, otherwise)
        most = 2 ** (BITS - 1)
        if WHOLE.fullmatch(text) is None or not -most <= int(text) < most:
            raise self.refused(f"its {key} is {text!r}", f"expected a whole number of {BITS} bits")
        return int(text)

    def direction(self, key: str, vector: Array) -> Array:
        """The unit vector along a vector (3,) of an attribute."""
        length = np.linalg.norm(vector)
        if length < SHORTEST:
            raise self.refused(f"its {key} gives no direction: {self.attributes[key]!r}", None)
        unit: Array = vector / length
        return unit


@dataclass(frozen=True, slots=True)
class Angles:
    """What the compiler says of angles: their unit, and about which axes Euler angles turn."""

    degrees: bool
    sequence: str

    def radians(self, angles: Array) -> Array:
        """Angles of the file in rad."""
        return np.radians(angles) if self.degrees else angles

    def pose(self, part: Part) -> Pose:
        """Where a body, a frame, a geom or an inertia is in the frame that it is given in."""
        return Pose(part.numbers("pos", "0 0 0", 3), self._turned(part))

    def _turned(self, part: Part) -> Rotation:
        given = [key for key in ORIENTATIONS if key in part.attributes]
        if len(given) > 1:
            raise part.refused(f"it is turned by {listed(given)}", "say in one way how it is turned")
        match given:
            case ["quat"]:
                quaternion = part.numbers("quat", "", 4)
                if np.linalg.norm(quaternion) < SHORTEST:
                    raise part.refused("its quat is zero", "a quaternion of no turn is 1 0 0 0")
                return Rotation.from_quat(quaternion, scalar_first=True)
            case ["euler"]:
                return self._euler(self.radians(part.numbers("euler", "", 3)))
            case ["axisangle"]:
                numbers = part.numbers("axisangle", "", 4)
                return Rotation.from_rotvec(part.direction("axisangle", numbers[:3]) * self.radians(numbers[3:]))
            case ["xyaxes"]:
                numbers = part.numbers("xyaxes", "", 6)
                x = part.direction("xyaxes", numbers[:3])
                y = part.direction("xyaxes", numbers[3:] - (x @ numbers[3:]) * x)
                return Rotation.from_matrix(np.column_stack([x, y, np.cross(x, y)]))
            case ["zaxis"]:
                return least_turn(part.direction("zaxis", part.numbers("zaxis", "", 3)))
        return Rotation.identity()

    def _euler(self, angles: Array) -> Rotation:
        turned = Rotation.identity()
        for letter, angle in zip(self.sequence, angles, strict=True):
            step = Rotation.from_rotvec(angle * np.eye(3)["xyz".index(letter.lower())])
            # Small letters turn about the axes as they have been turned, capitals about those of the parent.
            turned = turned * step if letter.islower() else step * turned
        return turned


def least_turn(direction: Array) -> Rotation:
    """The least rotation that takes the z axis to a unit vector (3,); of half a turn, the one about x."""
    x, y, z = direction
    across = np.hypot(x, y)
    axis = np.array([-y, x, 0.0]) / across if across > SHORTEST else np.array([1.0, 0.0, 0.0])
    return Rotation.from_rotvec(np.arctan2(across, z) * axis)
