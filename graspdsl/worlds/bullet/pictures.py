"""Pictures of the engine's world by its software renderer, smoothed, and what they must show."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.scene import Scene
from graspdsl.worlds.camera import HEIGHT, OVERSAMPLING, WIDTH, Camera, Picture, camera_on, grasp_direction

LIGHT = (-0.5, -1.0, 1.8)
SKY, GROUND = np.array([236.0, 240.0, 244.0]), np.array([206.0, 213.0, 220.0])


def camera_on_grasp(
    hand: BulletHand, scene: Scene, contacts: Iterable[int], width: int = WIDTH, height: int = HEIGHT
) -> Camera:
    """A camera that shows a hand, the object before it and these contacts, by number, between them."""
    origin, rotation = hand.face_frame()
    tips = np.array([position for position, _ in hand.tip_frames()])
    direction = grasp_direction(tips[list(contacts)], rotation[:, 2])
    return camera_on(np.concatenate([tips, [origin], scene.object_corners()]), direction, width, height)


def picture_of(engine: Any, client: int, camera: Camera, oversampling: int = OVERSAMPLING) -> Picture:
    """The picture that a camera takes of an engine's world, before a calm background.

    Each pixel is the mean of so many by so many, which smooths edges; the time grows with their number.
    """
    width, height = oversampling * camera.width, oversampling * camera.height
    _, _, colours, _, bodies = engine.getCameraImage(
        width,
        height,
        camera.view.T.ravel().tolist(),
        camera.projection.T.ravel().tolist(),
        lightDirection=LIGHT,
        lightColor=(1.0, 1.0, 1.0),
        lightDistance=3.0,
        lightAmbientCoeff=0.55,
        lightDiffuseCoeff=0.5,
        lightSpecularCoeff=0.12,
        shadow=1,
        renderer=engine.ER_TINY_RENDERER,
        physicsClientId=client,
    )
    seen = np.asarray(colours, dtype=float).reshape(height, width, -1)[:, :, :3]
    nothing = np.asarray(bodies).reshape(height, width) < 0
    down = np.linspace(0.0, 1.0, height)[:, None]
    backdrop = (SKY + down * (GROUND - SKY))[:, None, :]
    whole = np.where(nothing[:, :, None], backdrop, seen)
    fine = whole.reshape(camera.height, oversampling, camera.width, oversampling, 3)
    return np.asarray(np.round(fine.mean(axis=(1, 3))), dtype=np.uint8)
