"""A grasp to begin with: a standing cylinder that the fingertips of a hand meet before its other links do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.hands.fingertips import EllipsoidTip, FingertipShape
from graspdsl.hands.guess_closing import Closing
from graspdsl.hands.guess_face import Face
from graspdsl.hands.guess_fingers import Fingers
from graspdsl.hands.guess_posture import PosedModel

WAYS = 49  # from open to closed
SOME = 300  # points of each link
ALIKE = 0.5  # cosine between the ways in which fingers close that do so side by side
WIDEST = 0.6  # of how far the hand opens
NARROWEST = 0.015  # m
ENOUGH = 0.0045  # m between the object and what is not to touch it; a start keeps 4 mm
DEEPEST = 0.02  # m that the tips are below the top of an object that is grasped from above


@dataclass(frozen=True, slots=True)
class GuessedGrasp:
    """A cylinder of a width [m] that stands where the fingertips meet, and how the palm faces it: from the side, all
    fingers but the opposing one in a row along its axis, or from above, the tips ``deep`` [m] below its top.

    standoff: the gap [m] between palm and object; room: how far [m] the nearest other link then is from it; beside: how
    far [m] hand and fingertips reach along the object's axis, from the side.
    """

    side: bool
    width: float
    deep: float
    standoff: float
    room: float
    beside: tuple[float, float]


def grasp_of(
    posed: PosedModel, fingers: Fingers, closing: Closing, face: Face, shapes: Sequence[FingertipShape]
) -> tuple[float, GuessedGrasp]:
    """How far a hand opens between opposing fingertips [m], and a grasp for it.

    Fingers that close side by side come from the side, a row of them along the object's axis; others from above. Of the
    widths that the tips are apart on their way, the one nearest to that at the pinch is taken which leaves the other
    links room; where none does, the one that leaves most.
    """
    together = len(shapes) > 2 and float((closing.toward[1:] @ closing.toward[1:].T).min()) > ALIKE
    sizes = np.array([_radius(shape) for shape in shapes])
    surface = face.palm_surface or 0.0
    found: list[GuessedGrasp] = []
    for way in np.linspace(0.0, 1.0, WAYS):
        frames = posed.frames(closing.opened + way * (closing.closed - closing.opened))
        tips = np.array(
            [
                frames[finger.host].place + frames[finger.host].rotation @ np.array(shape.centre)
                for finger, shape in zip(fingers.fingers, shapes, strict=True)
            ]
        )
        tips = (tips - face.place) @ face.rotation
        middle = (tips[0] + tips[1:].mean(axis=0)) / 2.0
        if together:
            apart = float(abs(tips[1:, 1].mean() - tips[0, 1]))
        else:
            apart = 2.0 * float(np.linalg.norm(tips[:, :2] - middle[:2], axis=1).min())
        width = apart - sizes[0] - float(sizes[1:].mean())
        hosts = {finger.host for finger in fingers.fingers}
        others = [link for link in posed.model.links if link not in hosts]
        points = (posed.points(others, frames, SOME) - face.place) @ face.rotation - middle
        depth = float(middle[2]) - surface
        deep = min(DEEPEST, depth / 2.0)
        if together:
            off, standoff = np.hypot(points[:, 1], points[:, 2]) - width / 2.0, depth - width / 2.0
        else:
            off = np.maximum(np.hypot(points[:, 0], points[:, 1]) - width / 2.0, -deep - points[:, 2])
            standoff = depth - deep
        beside = float(np.abs(points[:, 0]).max(initial=0.0)), float(np.abs(tips[:, 0] - middle[0]).max())
        room = min(float(off.min(initial=ENOUGH)), standoff, ENOUGH)
        found.append(GuessedGrasp(together, float(width), deep, float(standoff), room, beside))
    opening = max(grasp.width for grasp in found)
    fitting = [grasp for grasp in found if NARROWEST < grasp.width <= WIDEST * opening] or found
    moved = np.abs(closing.closed - closing.opened)
    most = int(np.argmax(moved))
    share = float(abs(closing.pinch - closing.opened)[most] / moved[most]) if moved[most] > 0.0 else 0.0
    pinch = found[round(share * (WAYS - 1))].width
    best = max(fitting, key=lambda grasp: (min(grasp.room, ENOUGH), -abs(grasp.width - pinch)))
    return opening, best


def _radius(shape: FingertipShape) -> float:
    return min(shape.semi_axes) if isinstance(shape, EllipsoidTip) else shape.radius
