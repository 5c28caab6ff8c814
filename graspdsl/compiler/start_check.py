"""What can be known of the trials of a spec and of their starts before anything is simulated."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from functools import cached_property

import numpy as np

from graspdsl.arrays import Array
from graspdsl.compiler.complaints import Complaints
from graspdsl.compiler.settings import different_trials
from graspdsl.diagnostics import known_names_hint, likely
from graspdsl.hands.descriptions import Hand, Robot, joint_limits
from graspdsl.hands.fingertip_motion import FingertipMotion
from graspdsl.objects.shape import SHORTEST, convex_parts
from graspdsl.objects.shapes import Body
from graspdsl.objects.standing import STANDING, fall_of, pose_at_rest
from graspdsl.places.document import Document, Path
from graspdsl.spec.distributions import Choice, Normal, Uniform, numbers_of
from graspdsl.spec.models import Spec
from graspdsl.spec.scene import InlineObject
from graspdsl.spec.trials import PARAMETERS
from graspdsl.worlds.protocol import TABLE_SIZE
from graspdsl.worlds.start_pose import UP, pose

AROUND = 24  # directions about the normal of the palm in which an object's width is looked at
OBLIQUE = 0.75  # cosine of an angle
ASIDE = 1e-4
SLANT = 0.02  # rad by which a side may stand askew and is still taken for one that fingers lie on
SPREAD = 3.0  # standard deviations that are looked at
HINT = "or let a number of 'start' differ, as in roll: {uniform: [-0.5, 0.5]}"
START: Path = ("trials", "start")


def check_sizes(
    spec: Spec, hand: Hand, motion: FingertipMotion, body: Body, document: Document, complaints: Complaints
) -> None:
    """Warn of objects that do not stand or that no hand takes, and of palms that are nowhere near the object."""
    _Sizes(spec, hand, motion, body, document, complaints).all()


def check_start_posture(spec: Spec, robot: Robot, document: Document, complaints: Complaints) -> None:
    """Complain about a start posture of joints that the hand has not, or beyond their limits."""
    limits = dict(zip(robot.joints, zip(*joint_limits(robot), strict=True), strict=True)) if robot.hand.urdf else {}
    for name, place in spec.trials.start.posture.items():
        path: Path = ("trials", "start", "posture", name)
        complaints.about(path)
        if name not in robot.hand.joints:
            message = f"the hand {robot.hand.hand} has no actuated joint {name!r}"
            hint = known_names_hint(name, robot.hand.joints, "joints")
            span = document.key_span(path)
            complaints.error("unknown-joint", message, span, hint, likely(name, robot.hand.joints, span))
            continue
        low, high = limits[name]
        beyond = [number for number in numbers_of(place) if not low <= number <= high]
        if beyond:
            message = f"{name} moves from {low:g} to {high:g}, found {beyond[0]:g}"
            complaints.error("out-of-range", message, document.span(path), "keep within the limits of the joint")


def check_trials(spec: Spec, document: Document, complaints: Complaints) -> None:
    """Warn of more trials asked for than can differ, and of cells of a grid that no trial begins in."""
    trials, different = spec.trials, different_trials(spec)
    if "count" in trials.model_fields_set and trials.count > different:
        message = f"only {different:g} of {trials.count} trials can differ: the others repeat them"
        if different == 1:
            message = f"nothing is drawn at random: all {trials.count} trials are equal"
        _warn_of_key(
            document, complaints, "equal-trials", message, ("trials", "count"), f"write count: {different:g}, {HINT}"
        )
    cells = math.prod(axis.cells for axis in trials.grid or ())
    if cells > trials.count:
        message = (
            f"{trials.count} trials begin in the first {trials.count} of the grid's {cells} cells, and in no other"
        )
        hint = f"write count: {cells}, or use fewer cells"
        _warn_of_key(document, complaints, "empty-cells", message, ("trials", "grid"), hint)


def _warn_of_key(document: Document, complaints: Complaints, code: str, message: str, path: Path, hint: str) -> None:
    complaints.about(path)
    complaints.warning(code, message, document.key_span(path), hint)


class _Sizes:
    def __init__(
        self, spec: Spec, hand: Hand, motion: FingertipMotion, body: Body, document: Document, complaints: Complaints
    ) -> None:
        self._hand, self._motion, self._body = hand, motion, body
        self._document, self._complaints = document, complaints
        self._start, self._thing, self._afloat = spec.trials.start, spec.scene.object, spec.scene.afloat
        gridded: dict[str, tuple[float, float]] = {
            axis.parameter: (axis.middle(0), axis.middle(axis.cells - 1)) for axis in spec.trials.grid or ()
        }
        self._ends = {name: gridded.get(name) or _ends(getattr(self._start, name)) for name in PARAMETERS}

    def all(self) -> None:
        extent = self._body.shape.extent
        if max(extent) < SHORTEST:  # it has had its complaint
            return
        if max(extent) > min(TABLE_SIZE[:2]):
            if not (isinstance(self._thing, InlineObject) and self._thing.file):  # told already
                about = f"the object is {max(extent):.3g} m long, where the table is {min(TABLE_SIZE[:2]):g} m wide"
                self._warn_of_object("object-size", about, "lengths are in metres")
            return
        anchored = isinstance(self._thing, InlineObject) and (self._thing.held or self._thing.fixed)
        stands = anchored or self._afloat or not self._falls()
        if anchored or (stands and not self._is_too_wide()):
            self._palm()

    def _falls(self) -> bool:
        if self._body.shape.rests:
            return False
        fall = math.degrees(fall_of(self._body.shape))
        lies = pose_at_rest(self._body.shape) if fall > 0.0 else None
        if fall > STANDING:
            self._warn_of_object(
                "object-falls",
                f"the object does not stand: put on the table as it is, it tips over by {fall:.0f}°",
                f"write '{lies}'" if lies else "put it on a broader side, or add 'fixed: true' to the object",
            )
        elif fall > 0.0:
            self._warn_of_object(
                "object-tips",
                f"put on the table as it is, the object tips by {fall:.1f}°, and every trial begins with it at rest so",
                f"to put it down so, write '{lies}'" if lies else "make its foot even",
            )
        return fall > STANDING

    def _is_too_wide(self) -> bool:
        """Whether no pair of fingertips can be on both sides of the object, or of a part of it."""
        openings, found = self._motion.openings(), list[tuple[float, float]]()
        if len(openings) == 0:  # of one fingertip
            return False
        for width, depth in self._widths():
            if ((openings[:, 0] >= width) & (openings[:, 1] >= depth)).any():
                return False
            found.append((width, depth))
        width, depth = min(found)
        gaps = openings[openings[:, 1] >= depth, 0]
        where = f" as far ahead of its palm as that is ({1000 * depth:.0f} mm)" if depth > 0.001 else ""
        opens = f"opens to {1000 * gaps.max():.0f} mm" if len(gaps) else "has no two fingertips"
        self._warn_of_object(
            "object-too-wide",
            f"the object is {1000 * width:.0f} mm wide at the least, but the hand {self._hand.hand} {opens}{where}",
            "use a smaller object, a larger hand, or another approach",
        )
        return True

    def _widths(self) -> Iterator[tuple[float, float]]:
        """How wide the object is and how deep there, before its parts, across the normals of the palm in all starts."""
        shape = self._body.shape
        normals = [np.array(normal) for normal in {tuple(rotation[:, 2].tolist()) for _, rotation in self._poses}]
        for normal in normals:
            yield from _across(shape.support, normal)
        if not shape.convex:
            for normal, part in itertools.product(normals, convex_parts(shape)):
                yield from _across(part.support, normal)

    def _palm(self) -> None:
        """Where the middle of the palm is, in all starts."""
        top, standoff = self._body.shape.extent[2], self._ends["standoff"][0]
        if self._start.approach != "top" and self._ends["height"][0] > top:
            self._warn_of_start(
                "height",
                f"the palm is {self._ends['height'][0]:g} m or more above the table, above the top of the object at "
                f"{top:.3g} m",
                f"a palm that faces the object's side is at most {top:.3g} m high",
            )
            return
        reach = self._motion.reach()
        if standoff > reach:
            self._warn_of_start(
                "standoff",
                f"the palm is {standoff:g} m or more from the object, but the fingers reach {reach:.3g} m ahead of it",
                f"use a standoff below {reach:.3g} m",
            )
        aside = min(map(abs, self._ends["offset"])) if np.prod(self._ends["offset"]) > 0.0 else 0.0
        width = max(self._body.shape.extent) / 2 + self._motion.breadth()
        if aside > width:
            self._warn_of_start(
                "offset",
                f"the hand passes the object: it is {aside:g} m or more aside, where object and hand together reach "
                f"{width:.3g} m",
                f"use an offset below {width:.3g} m",
            )
        palms = [place + self._hand.palm_surface * rotation[:, 2] for place, rotation in self._poses]
        if not self._afloat and all(palm[2] < 0.0 for palm in palms):
            self._warn_of_start("height", "the palm is below the table in every start", "heights are above the table")
        elif all(self._is_inside(palm) for palm in palms):
            self._warn_of_start(
                "standoff", "the palm is inside the object in every start", "use a larger standoff, or a smaller tilt"
            )

    def _is_inside(self, point: Array) -> bool:
        """Whether a point (3,) [m] is within the object's outline seen from above, and not above it or below."""
        shape = self._body.shape
        headings = (2 * math.pi * way / AROUND for way in range(AROUND))
        sides = (np.array([math.cos(heading), math.sin(heading), 0.0]) for heading in headings)
        return bool(0.0 < point[2] < shape.extent[2] and all(side @ point < shape.support(side) for side in sides))

    @cached_property
    def _poses(self) -> list[tuple[Array, Array]]:
        """The hand's poses at the ends of all the ranges of a start, and in their middle."""
        poses = []
        middle = tuple((low + high) / 2.0 for low, high in self._ends.values())
        for values in {middle, *itertools.product(*self._ends.values())}:
            drawn = dict(zip(self._ends, values, strict=True))
            start = pose(self._start.approach or "side", drawn, self._body, self._hand.palm_surface)
            poses.append((start.position, start.rotation))
        return poses

    def _warn_of_object(self, code: str, message: str, hint: str) -> None:
        self._warn(code, message, ("scene", "object"), hint)

    def _warn_of_start(self, name: str, message: str, hint: str) -> None:
        self._warn("start-out-of-place", message, (*START, name), hint)

    def _warn(self, code: str, message: str, path: Path, hint: str) -> None:
        self._complaints.about(path)
        self._complaints.warning(code, message, self._document.span(path), hint)


def _ends(place: float | Uniform | Normal | Choice) -> tuple[float, float]:
    """The least and the largest number that is drawn, but for the tails of a normal distribution."""
    match place:
        case Uniform(uniform=(low, high)):
            return low, high
        case Normal(normal=(mean, deviation)):
            return mean - SPREAD * deviation, mean + SPREAD * deviation
        case Choice(choice=values):
            return min(values), max(values)
    return float(place), float(place)


def _across(support: Callable[[Array], float], normal: Array) -> Iterator[tuple[float, float]]:
    """How wide a shape is across the normal (3,) of a palm, and how far ahead of its nearest point, in each direction.

    The depth [m] is that of the place nearest to the palm at which a shape is so wide: none, where a face is met. The
    axes of the shape count as across it up to OBLIQUE; from below, where the table is, no finger comes.
    """
    level = np.cross(normal, UP)
    first = level / np.linalg.norm(level) if np.linalg.norm(level) > ASIDE else np.array([1.0, 0.0, 0.0])
    second = np.cross(normal, first)
    turns = [math.pi * way / AROUND for way in range(AROUND)]
    sides = [*np.eye(3), *(math.cos(turn) * first + math.sin(turn) * second for turn in turns)]
    nearest = support(-normal)
    for side in sides:
        if max(abs(side @ normal), abs(side @ UP)) > OBLIQUE:
            continue
        ends = (side, -side)
        sizes = [support(end) for end in ends]
        # The derivative of a support function in a direction is how far the shape reaches that way there.
        near = [(support(end - SLANT * normal) - size) / SLANT for end, size in zip(ends, sizes, strict=True)]
        yield sum(sizes), nearest - min(near)
