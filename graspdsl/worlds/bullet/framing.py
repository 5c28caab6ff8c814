"""What a camera must show of a hand and an object."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from graspdsl.worlds.bullet.camera import HEIGHT, WIDTH, Camera, camera_on, grasp_direction
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.scene import Scene


def camera_on_grasp(
    hand: BulletHand, scene: Scene, contacts: Iterable[int], width: int = WIDTH, height: int = HEIGHT
) -> Camera:
    """A camera that shows a hand, the object before it and these contacts, by number, between them."""
    origin, rotation = hand.face_frame()
    tips = np.array([position for position, _ in hand.tip_frames()])
    direction = grasp_direction(tips[list(contacts)], rotation[:, 2])
    return camera_on(np.concatenate([tips, [origin], scene.object_corners()]), direction, width, height)
