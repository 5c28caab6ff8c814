"""Where a hand faces: the line that meets the object ahead of its palm, and how far along it the palm's surface is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.guess_closing import Closing
from graspdsl.hands.guess_fingers import Fingers
from graspdsl.hands.guess_posture import PosedModel

STRAY = 0.15  # how much a direction counts that the fingers do not close along, against one they do
STRAIGHT = 0.998  # cosine: a direction so near to an axis of the root is meant to be along it
BESIDE = 0.02  # m about the line within which the palm is looked for, at the least


@dataclass(frozen=True, slots=True)
class Face:
    """The frame that a mount carries a hand by, in that of its root: a place (3,) [m] behind the palm, ahead (3,) out
    of the palm, across (3,) the way the fingers close; and the palm's surface [m] ahead of it, None where there is
    none."""

    place: Array
    ahead: Array
    across: Array
    palm_surface: float | None

    @property
    def rotation(self) -> Array:
        """Its axes (3, 3)."""
        return np.column_stack([np.cross(self.across, self.ahead), self.across, self.ahead])


def face_of(posed: PosedModel, fingers: Fingers, closing: Closing) -> Face:
    """Where a hand faces.

    Ahead is where the tips meet, seen from the bases of the fingers, less what of that is along the ways the tips
    close and along the row that they stand in: an object comes in across these.
    """
    tips, toward = closing.tips, closing.toward
    centre = (tips[0] + tips[1:].mean(axis=0)) / 2.0
    base = (fingers.fingers[0].base[0] + np.mean([finger.base[0] for finger in fingers.fingers[1:]], axis=0)) / 2.0
    apart = tips[1:].mean(axis=0) - tips[0]
    ways = [*toward, apart / max(float(np.linalg.norm(apart)), 1e-9)]
    row = tips[1:] - tips[1:].mean(axis=0)
    spread = np.linalg.norm(row, axis=1).max()
    ways += list(row / spread) if spread > 1e-6 else []
    closed = sum((np.outer(way, way) for way in ways), np.zeros((3, 3))) / len(ways)
    ahead = np.linalg.solve(closed + STRAY**2 * np.eye(3), centre - base)
    ahead = _straight(ahead / np.linalg.norm(ahead))
    across = apart - (apart @ ahead) * ahead
    across = _straight(across / np.linalg.norm(across))
    frames = posed.frames(closing.opened)
    palm = posed.points(fingers.palm_links, frames) - centre
    if not len(palm):
        return Face(base, ahead, across, None)
    depths = palm @ ahead
    aside = np.linalg.norm(palm - depths[:, None] * ahead, axis=1)
    near = depths[aside < max(BESIDE, float(np.linalg.norm(apart)) / 2.0)]
    back = float(depths.min())
    surface = float(near.max()) if len(near) else float(np.percentile(depths, 95.0))
    return Face(centre + back * ahead, ahead, across, surface - back)


def _straight(direction: Array) -> Array:
    """A unit direction (3,), along an axis where it is near one."""
    nearest = int(np.argmax(np.abs(direction)))
    if abs(direction[nearest]) < STRAIGHT:
        return direction
    return np.asarray(np.sign(direction[nearest]) * np.eye(3)[nearest])
