"""What pictures show is where geometry in closed form has it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graspdsl.compiler.program import program_of
from graspdsl.hands.descriptions import robot
from graspdsl.objects.shapes import catalogue
from graspdsl.trials.setup import settings_of
from graspdsl.worlds.camera import Camera
from graspdsl.worlds.kind import View, WorldSettings
from graspdsl.worlds.mujoco.pictures import LIGHT
from graspdsl.worlds.mujoco.studio import GraspStudio, SurfaceStudio
from graspdsl.worlds.protocol import Start

MAIN = Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml"
CAMERA = Camera(np.array([0.35, -0.5, 0.3]), np.zeros(3), 161, 120)
BALL = catalogue()["ball"]
RADIUS = BALL.shape.extent[0] / 2
CONTACT = np.array([0.0, -RADIUS, 0.0])


@pytest.fixture(scope="module")
def ball() -> SurfaceStudio:
    """A ball about the origin and one contact on it, on the side of the light."""
    studio = SurfaceStudio(View(WorldSettings(robot("points", "gantry"), BALL, 0.5), None, [0], [0]))
    studio.show({"points": CONTACT[None]})
    return studio


@pytest.mark.parametrize("oversampling", [1, 2])
def test_a_ball_is_seen_where_it_is(ball: SurfaceStudio, oversampling: int) -> None:
    """Each pixel that a line of sight goes through a sphere in, but for those at its outline."""
    picture = ball.picture(CAMERA, oversampling).astype(float)
    across = np.stack(np.meshgrid(np.arange(161) + 0.5, np.arange(120) + 0.5), axis=-1)
    distance = np.linalg.norm(CAMERA.eye)
    # A point before each pixel: its direction is undone by the camera's own projection.
    clip = np.concatenate([across / [161, 120] * 2 - 1, np.ones((120, 161, 1))], axis=-1) * [1, -1, -1]
    local = clip / [CAMERA.projection[0, 0], CAMERA.projection[1, 1], 1.0]
    rays = local @ CAMERA.view[:3, :3]
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    np.testing.assert_allclose(CAMERA.pixels(CAMERA.eye + rays), across)
    beside = np.sqrt(distance**2 - (rays @ CAMERA.eye) ** 2)  # of the line of sight from the middle
    warm = picture[..., 0] >= picture[..., 2]  # paper and what is lit of it; the background is cool
    free = np.linalg.norm(across - CAMERA.pixels(CONTACT), axis=-1) > 3.0
    assert warm[(beside < 0.97 * RADIUS) & free].all()
    assert not warm[beside > 1.02 * RADIUS].any()
    assert 500 < warm.sum() < 10_000


def test_a_contact_is_seen_where_it_is(ball: SurfaceStudio) -> None:
    """Two pixels large."""
    picture = ball.picture(CAMERA).astype(float)
    x, y = CAMERA.pixels(CONTACT).astype(int)
    assert picture[y, x, 2] > 1.5 * picture[y, x, 0]


def test_what_faces_the_light_is_brighter_than_what_does_not(ball: SurfaceStudio) -> None:
    """Smoothly: a ball of triangles has no more steps than one of a closed form."""
    picture = ball.picture(CAMERA).astype(float)
    toward, away = (
        CAMERA.pixels(RADIUS * side / np.linalg.norm(side)).astype(int)
        for side in (LIGHT + CAMERA.eye, CAMERA.eye - LIGHT / 4)
    )
    assert picture[toward[1], toward[0], 1] > 1.15 * picture[away[1], away[0], 1]


def test_things_stand_where_they_are_put() -> None:
    """An object under the hand, its centre of mass where it was told."""
    settings = settings_of(program_of(MAIN.read_text("utf-8"), "spec"))
    start = Start(np.array([0.0, 0.0, 0.5]), np.diag([1.0, -1.0, -1.0]), {})
    studio = GraspStudio(View(settings, start, [0, 1, 2], [0, 1]))
    turned = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    place = np.array([0.05, -0.02, 0.3])
    joints = np.zeros(len(settings.robot.joints))
    studio.show({"joints": joints, "object_position": place, "object_rotation": turned})
    corners, size = studio.corners("object"), np.array(settings.body.shape.extent)
    np.testing.assert_allclose(np.ptp(corners, axis=0), turned @ size, rtol=1e-3)
    centre = place - turned @ settings.body.shape.solid.centre
    np.testing.assert_allclose(corners.mean(axis=0), centre, atol=1e-4)
    picture = studio.picture(studio.camera(96, 72))
    assert len(np.unique(picture)) > 20
    studio.close()
    assert not studio.is_open
