"""The shape of a fingertip: the simplest that reaches as far as the end of its link, where that meets an object."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from graspdsl.angles import roll_pitch_yaw
from graspdsl.arrays import Array
from graspdsl.hands.fingertips import CapsuleTip, EllipsoidTip, FingertipShape, SphereTip, directions_around, reach
from graspdsl.hands.guess_fingers import Finger, distal
from graspdsl.hands.guess_posture import PosedModel, touching
from graspdsl.models.model import Solid

KINDS = ("sphere", "capsule", "ellipsoid")  # the simplest first
WAYS = 600  # directions in which a shape is held against the end of the link
SIDE, END = 0.25, -0.25  # the least cosines to where it closes and to where the finger points
GOOD = 0.0005  # m: a simpler shape that is so near, as a root of the mean square, ...
BETTER = 1.3  # or no more than so many times as far as the best, is taken
THINNEST, THICKEST = 0.002, 0.08  # m
FATTER, THINNER = 1.1, 0.8  # of the end of the link, the most and the least


@dataclass(frozen=True, slots=True)
class FittedTip:
    """A shape in the frame of its link; how far its reach is from that of the link [m], as a root of the mean square
    and at the most; whether it is the very solid of the model."""

    shape: FingertipShape
    error: float
    worst: float
    exact: bool = False

    @property
    def kind(self) -> str:
        """How hand files call the shape."""
        return KINDS[(SphereTip, CapsuleTip, EllipsoidTip).index(type(self.shape))]


def fitted_tips(posed: PosedModel, fingers: Sequence[Finger], toward: Sequence[Array]) -> list[FittedTip]:
    """The shapes for the ends of fingers, of one kind but for those that are solids of the model: the simplest that
    is good enough for all. ``toward``: the sides (3,) to which they close, in the frames of their links."""
    tried = [_tried(posed, finger, side) for finger, side in zip(fingers, toward, strict=True)]
    fitted = [fits for fits in tried if not next(iter(fits.values())).exact]
    common = [kind for kind in KINDS if all(kind in fits for fits in fitted)]
    error = {kind: float(np.mean([fits[kind].error for fits in fitted])) for kind in common} if fitted else {}
    best = min(error.values(), default=0.0)
    chosen = next((kind for kind in common if fitted and error[kind] <= max(GOOD, BETTER * best)), "")
    return [fits[chosen] if chosen in fits else next(iter(fits.values())) for fits in tried]


def _tried(posed: PosedModel, finger: Finger, toward: Array) -> dict[str, FittedTip]:
    """Shapes for the end of a finger's last link, by their kinds.

    Shapes are compared by how far they reach along directions that are not away from that side nor back along the
    finger, to all of which an object's surface may stand across.
    """
    solids = touching(posed.model.links[finger.host].solids)
    if len(solids) == 1 and (shape := _very(solids[0])) is not None:
        very = FittedTip(shape, 0.0, 0.0, exact=True)
        return {very.kind: very}
    points = distal(posed.own_points(finger.host), finger.along)
    ways = directions_around(WAYS)
    ways = ways[(ways @ toward > SIDE) & (ways @ finger.along > END)]
    reached = (ways @ points.T).max(axis=1)
    box = _box(points)
    tried = [_sphere(ways, reached, box), _capsule(ways, reached, box), _ellipsoid(ways, reached, box)]
    fits = (_held(shape, ways, reached) for shape in tried if shape is not None)
    return {fit.kind: fit for fit in fits}


def _held(shape: FingertipShape, ways: Array, reached: Array) -> FittedTip:
    off = np.abs(reach(shape, ways) - reached)
    return FittedTip(shape, float(np.sqrt((off**2).mean())), float(off.max()))


def _very(solid: Solid) -> FingertipShape | None:
    """The shape that a solid has, where a fingertip can have it."""
    centre = rounded(solid.frame.place)
    match solid.kind:
        case "sphere":
            return SphereTip(centre=centre, radius=solid.sizes[0])
        case "capsule":
            return CapsuleTip(
                centre=centre, radius=solid.sizes[0], length=solid.sizes[1], axis=rounded(solid.frame.rotation[:, 2])
            )
        case "ellipsoid":
            a, b, c = solid.sizes
            return EllipsoidTip(
                centre=centre, semi_axes=(a, b, c), rpy=rounded(np.array(roll_pitch_yaw(solid.frame.rotation)))
            )
    return None


class _Box(NamedTuple):
    """The smallest box about points: its middle (3,) [m], its axes (3, 3), and half of its edges (3,) [m]."""

    middle: Array
    axes: Array
    halves: Array


def _box(points: Array) -> _Box:
    import trimesh

    box = trimesh.Trimesh(points).bounding_box_oriented.primitive
    frame, edges = np.array(box.transform), np.array(box.extents)
    return _Box(frame[:3, 3], frame[:3, :3], np.maximum(edges / 2.0, THINNEST))


def _sphere(ways: Array, reached: Array, box: _Box) -> SphereTip | None:
    """A sphere reaches c · n + r: the least squares are linear. None where it would be fatter than the link."""
    found = np.linalg.lstsq(np.hstack([ways, np.ones((len(ways), 1))]), reached, rcond=None)[0]
    if not THINNEST < found[3] < FATTER * np.sort(box.halves)[1]:
        return None
    return SphereTip(centre=rounded(found[:3]), radius=_size(found[3]))


def _capsule(ways: Array, reached: Array, box: _Box) -> CapsuleTip | None:
    """A capsule reaches c · n + r + |a · n| l / 2, along the longest edge of the box. None where it would be fatter."""
    order = np.argsort(box.halves)
    axis = box.axes[:, order[2]]
    columns = np.hstack([ways, np.ones((len(ways), 1)), np.abs(ways @ axis)[:, None] / 2.0])
    found = np.linalg.lstsq(columns, reached, rcond=None)[0]
    if not (THINNEST < found[3] < FATTER * box.halves[order[0]] and THINNEST < found[4] < 1.0):
        return None
    return CapsuleTip(centre=rounded(found[:3]), radius=_size(found[3]), length=_size(found[4]), axis=rounded(axis))


def _ellipsoid(ways: Array, reached: Array, box: _Box) -> EllipsoidTip:
    """An ellipsoid reaches c · n + |A Rᵀ n|, its axes along the edges of the box and none much longer."""
    from scipy.optimize import least_squares

    local, high = ways @ box.axes, np.log(FATTER * np.maximum(box.halves, THINNEST))
    low = np.log(THINNER * np.maximum(box.halves, THINNEST))

    def off(at: Array) -> Array:
        return np.asarray(ways @ at[:3] + np.linalg.norm(local * np.exp(at[3:]), axis=1) - reached)

    guess = np.concatenate([box.middle, (low + high) / 2.0])
    ends = ([*box.middle - box.halves, *low], [*box.middle + box.halves, *high])
    found = least_squares(off, guess, bounds=ends).x
    a, b, c = (_size(float(size)) for size in np.exp(found[3:]))
    angles = np.array(roll_pitch_yaw(box.axes))
    return EllipsoidTip(centre=rounded(found[:3]), semi_axes=(a, b, c), rpy=rounded(angles))


def _size(length: float) -> float:
    return round(float(np.clip(length, THINNEST, THICKEST)), 5)


def rounded(numbers: Iterable[float]) -> tuple[float, float, float]:
    """Three numbers with the digits that a file needs: of lengths to 0.01 mm."""
    x, y, z = (round(float(number), 5) + 0.0 for number in numbers)
    return x, y, z
