"""Where a picture is taken from."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array

WIDTH, HEIGHT = 480, 360  # pixels of a picture, where nothing else is asked for
Picture = npt.NDArray[np.uint8]  # (height, width, 3)

UP = np.array([0.0, 0.0, 1.0])
FIELD_OF_VIEW = math.radians(32.0)  # of the shorter side
NEAR, FAR = 0.05, 6.0  # m
OVERSAMPLING = 2
LEAST_ELEVATION, MOST_ELEVATION = math.radians(22.0), math.radians(50.0)
LEAST_RADIUS = 0.02  # m
TINY = 1e-9


@dataclass(frozen=True, eq=False, slots=True)
class Camera:
    """An upright camera at ``eye`` (3,) that looks at ``target`` (3,) [m], for pictures of width by height pixels."""

    eye: Array
    target: Array
    width: int = WIDTH
    height: int = HEIGHT

    @property
    def view(self) -> Array:
        """The (4, 4) matrix from the world to the camera: x to the right, y up, z towards the viewer."""
        back = (self.eye - self.target) / np.linalg.norm(self.eye - self.target)
        right = np.cross(UP, back)
        right /= np.linalg.norm(right)
        rotation = np.stack([right, np.cross(back, right), back])
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = rotation, -rotation @ self.eye
        return matrix

    @property
    def projection(self) -> Array:
        """The (4, 4) matrix from the camera to clip space (OpenGL's)."""
        shorter = 1.0 / math.tan(FIELD_OF_VIEW / 2)
        least = min(self.width, self.height)
        matrix = np.zeros((4, 4))
        matrix[0, 0], matrix[1, 1] = shorter * least / self.width, shorter * least / self.height
        matrix[2, 2:] = (FAR + NEAR) / (NEAR - FAR), 2 * FAR * NEAR / (NEAR - FAR)
        matrix[3, 2] = -1.0
        return matrix

    def pixels(self, points: Array) -> Array:
        """Where points (..., 3) [m] before the camera are in the picture: (..., 2), right and down from a corner."""
        ones = np.ones((*points.shape[:-1], 1))
        clip = np.concatenate([points, ones], axis=-1) @ (self.projection @ self.view).T
        seen = clip[..., :2] / np.maximum(clip[..., 3:], TINY)
        corner = np.array([1.0, 1.0]) + seen * np.array([1.0, -1.0])
        return np.asarray(corner / 2 * np.array([self.width, self.height]))


def camera_on(points: Array, direction: Array, width: int, height: int) -> Camera:
    """The camera in a direction (3,) from the middle of points (n, 3) [m], as near as shows all of them."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = max(float(np.linalg.norm(points - middle, axis=1).max()), LEAST_RADIUS)
    distance = radius / math.sin(FIELD_OF_VIEW / 2)
    return Camera(middle + distance * direction / np.linalg.norm(direction), middle, width, height)


def box_corners(low: Array, high: Array) -> Array:
    """The corners (8, 3) of the box between two opposite ones."""
    return np.stack(np.meshgrid(*zip(low, high, strict=True), indexing="ij"), axis=-1).reshape(-1, 3)


def grasp_direction(tips: Array, palm_normal: Array) -> Array:
    """The unit vector (3,) from a grasp with fingertips (k, 3) [m] to who looks at it.

    It is normal to the line that the tips are nearest to and to the palm's normal (3,), as far as that can be seen from
    above: neither along the table nor straight down, where it is seen over the palm's shoulder.
    """
    spread = tips - tips.mean(axis=0)
    line = np.linalg.svd(spread)[2][0]
    across = np.cross(line, palm_normal)
    side = np.cross(palm_normal, UP)
    if np.linalg.norm(side) < math.sin(LEAST_ELEVATION):  # the palm faces down or up
        side = across - (across @ UP) * UP
    if np.linalg.norm(across) < TINY:
        across = side
    across = across / max(float(np.linalg.norm(across)), TINY)
    if across @ (side + UP) < 0:
        across = -across
    level = across + 0.5 * side - 0.35 * palm_normal
    level[2] = 0.0
    if np.linalg.norm(level) < TINY:
        level = np.array([0.0, -1.0, 0.0])
    elevation = float(np.clip(math.asin(np.clip(across[2], -1.0, 1.0)), LEAST_ELEVATION, MOST_ELEVATION))
    return math.cos(elevation) * level / np.linalg.norm(level) + math.sin(elevation) * UP
