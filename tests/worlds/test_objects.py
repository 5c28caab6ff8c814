"""Objects in the bullet world: they stand, weigh, turn and meet a fingertip as their shapes say."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.objects.box import Box
from graspdsl.objects.ellipsoid import Ellipsoid
from graspdsl.objects.facets import AROUND
from graspdsl.objects.shape import Shape, shaded
from graspdsl.objects.shapes import Body, catalogue
from graspdsl.objects.superquadric import Superquadric
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.setup import trial_loop
from graspdsl.worlds.bullet.engine import EFFORT, pybullet
from graspdsl.worlds.bullet.scene import Scene
from graspdsl.worlds.bullet.stages import BulletEngine
from graspdsl.worlds.kind import Anchor
from graspdsl.worlds.protocol import UnstableObjectError
from graspdsl.worlds.rigid.lean import Standing
from graspdsl.worlds.rigid.settling import resting_pose

from .scenes import main_program

FRICTION, GRAVITY = 0.5, 9.81
TIP = 0.0115  # m, the radius of a fingertip
BODIES = {
    **catalogue(),
    "pillow": Body("pillow", Superquadric(size=(0.12, 0.09, 0.10), exponent=3.0), 0.4),
    "brick": Body("brick", Superquadric(size=(0.09, 0.06, 0.14), exponent=8.0), 0.4),
}
EACH_BODY = pytest.mark.parametrize("name", BODIES)


class Stage(NamedTuple):
    """An engine with a scene in it."""

    engine: Any
    client: int
    scene: Scene

    def simulate(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / EFFORT.time_step)):
            self.engine.stepSimulation(self.client)

    def pushed(self, torque: Array) -> Array:
        """The angular velocity (3,) [rad/s] after a torque (3,) [N m] of one step."""
        self.engine.applyExternalTorque(self.scene.object, -1, torque.tolist(), self.engine.WORLD_FRAME, self.client)
        self.engine.stepSimulation(self.client)
        return np.array(self.engine.getBaseVelocity(self.scene.object, self.client)[1])


@contextlib.contextmanager
def staged(body: Body, anchor: Anchor = Anchor.NONE, gravity: float = GRAVITY) -> Iterator[Stage]:
    """A scene without a hand."""
    engine = pybullet()
    client = engine.connect(engine.DIRECT)
    try:
        engine.setTimeStep(EFFORT.time_step, client)
        engine.setGravity(0, 0, -gravity, client)
        yield Stage(engine, client, Scene(engine, client, body, FRICTION, anchor))
    finally:
        engine.disconnect(client)


@EACH_BODY
def test_it_stands_still(name: str) -> None:
    with staged(BODIES[name]) as stage:
        stage.scene.place(resting_pose(BulletEngine(), BODIES[name], FRICTION, GRAVITY))
        before = stage.scene.object_pose()
        standing = Standing.of(before[1], BODIES[name].shape)
        for _ in range(8):
            stage.simulate(0.25)
            assert np.degrees(standing.lean(stage.scene.object_pose()[1])) < 0.5
        after = stage.scene.object_pose()
        assert np.linalg.norm(after[0] - before[0]) < 1e-3
        turned = Rotation.from_matrix(after[1] @ before[1].T).magnitude()
        assert np.degrees(turned) < 0.5


@EACH_BODY
def test_it_stands_where_it_is_put(name: str) -> None:
    body = BODIES[name]
    with staged(body) as stage:
        stage.scene.place(resting_pose(BulletEngine(), body, FRICTION, GRAVITY))
        position, rotation = stage.scene.object_pose()
        origin = position - rotation @ body.shape.solid.centre
        np.testing.assert_allclose(origin, [0.0, 0.0, body.shape.extent[2] / 2], atol=1e-4)


@EACH_BODY
def test_a_torque_turns_it_as_its_inertia_says(name: str) -> None:
    body = BODIES[name]
    torque = np.array([0.01, -0.02, 0.015])
    with staged(body, gravity=0.0) as stage:
        rate = stage.pushed(torque)
    expected = np.linalg.solve(body.shape.solid.inertia(body.mass), torque * EFFORT.time_step)
    # The engine damps turning by a few hundredths a second.
    np.testing.assert_allclose(rate, expected, atol=1e-3 * np.linalg.norm(expected))


def _samples(shape: Shape, count: int) -> Iterator[tuple[Array, Array]]:
    """Points on the sides of a shape, evenly over its area, with outward normals."""
    random = np.random.default_rng(1)
    parts = shaded(shape)
    corners = np.concatenate([part.vertices[part.faces] for part in parts])
    normals = np.concatenate([part.normals[part.faces] for part in parts])
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    for face in random.choice(len(areas), count, p=areas / areas.sum()):
        weights = random.dirichlet((1.0, 1.0, 1.0))
        normal = weights @ normals[face]
        yield weights @ corners[face], normal / np.linalg.norm(normal)


def _sensed(stage: Stage, tip: int, centre: Array) -> tuple[Array, float]:
    """The normal and the distance of the object from a fingertip with its centre at a point."""
    engine, client = stage.engine, stage.client
    engine.resetBasePositionAndOrientation(tip, centre.tolist(), [0, 0, 0, 1], client)
    near = engine.getClosestPoints(tip, stage.scene.object, 0.02, physicsClientId=client)
    nearest = min(near, key=lambda point: point[8])
    return np.array(nearest[7]), nearest[8]


# What a hand meets of an object, up to these coordinates: below the neck of a bottle, and before its handle.
GRASPED = {"squirt-bottle": (1.0, 1.0, 0.17 - 0.135), "detergent-bottle": (0.01, 1.0, 0.16 - 0.125)}
ANYWHERE = (1.0, 1.0, 1.0)


@pytest.mark.parametrize("name", ["squirt-bottle", "detergent-bottle", "bottle", "ellipsoid", "pillow", "brick"])
@pytest.mark.parametrize("gap", [0.002, -0.0003], ids=["near", "pressed"])
def test_a_fingertip_meets_the_true_surface(name: str, gap: float) -> None:
    """Within half a millimetre of the shape, and its normal as good as facets can give it."""
    shape = BODIES[name].shape
    limit = GRASPED.get(name, ANYWHERE)
    angles, sizes = [], []
    with staged(BODIES[name], Anchor.WORLD) as stage:
        engine, client = stage.engine, stage.client
        ball = engine.createCollisionShape(engine.GEOM_SPHERE, radius=TIP, physicsClientId=client)
        tip = engine.createMultiBody(0.0, ball, physicsClientId=client)
        up = np.array([0.0, 0.0, shape.extent[2] / 2])
        for point, normal in _samples(shape, 1500):
            if abs(normal[2]) < 0.7 and (point < limit).all():
                sensed, distance = _sensed(stage, tip, point + up + (TIP + gap) * normal)
                angles.append(np.degrees(np.arccos(np.clip(sensed @ normal, -1.0, 1.0))))
                sizes.append(distance - gap)
    assert len(angles) > 300
    half_facet = 180.0 / AROUND
    assert np.mean(angles) < half_facet
    assert np.percentile(angles, 95) < 2.0 * half_facet
    # A hull lies within its curved surface, so that the tip is hardly ever nearer than the shape itself.
    assert np.percentile(np.abs(sizes), 99) < 5e-4 + 1e-4 * (name == "brick")


@pytest.mark.parametrize("name", BODIES)
def test_rays_meet_the_true_extent(name: str) -> None:
    body = BODIES[name]
    height = body.shape.extent[2]
    with staged(body, Anchor.WORLD) as stage:
        for direction in ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]):
            reach = body.shape.support(np.array(direction))
            tall = np.linspace(0.003, height - 0.003, 200)
            starts = [[*(0.4 * np.array(direction[:2])), z] for z in tall] if direction[2] == 0.0 else [[0.0, 0.0, 1.0]]
            if direction[2]:
                starts = [[x, 0.0, 1.0] for x in np.linspace(-0.06, 0.06, 121)]
            ends = [[x - 2 * direction[0], y - 2 * direction[1], z - 2 * direction[2]] for x, y, z in starts]
            hits = stage.engine.rayTestBatch(starts, ends, physicsClientId=stage.client)
            met = [np.dot(hit[3], direction) for hit in hits if hit[0] == stage.scene.object]
            base = height / 2 if direction[2] else 0.0
            assert max(met) == pytest.approx(base + reach, abs=5e-4)


def test_lean_is_of_what_was_up_whichever_axis_is_the_longest() -> None:
    body = Body("plank", Box(size=(0.2, 0.06, 0.05)), 0.3)
    assert body.major_axis == (1.0, 0.0, 0.0)
    for begun in (np.eye(3), Rotation.from_euler("z", 0.4).as_matrix()):
        for angle in (0.2, 1.0, 2.0):
            for turn in (0.0, 0.7):
                leaning = Rotation.from_euler("xyz", [angle, 0.0, turn]).as_matrix() @ begun
                assert Standing.of(begun, body.shape).lean(leaning) == pytest.approx(angle)
                assert Standing.of(begun, body.shape, topples=False).lean(leaning) == 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "shape",
    [
        Ellipsoid(size=(0.10, 0.12, 0.16)),  # on its end, where it can balance
        Superquadric(size=(0.06, 0.06, 0.20), exponent=2.0),
    ],
)
def test_what_balances_on_a_tip_is_said_to_fall(shape: Ellipsoid | Superquadric) -> None:
    with pytest.raises(UnstableObjectError, match=r"does not stand: put on the table, it fell over by \d+°"):
        resting_pose(BulletEngine(), Body("egg", shape, 0.3), FRICTION, GRAVITY)


@pytest.mark.slow
def test_a_trial_of_what_does_not_stand_says_so() -> None:
    egg = "scene.object={ellipsoid: {size: [0.10, 0.12, 0.16]}}"
    trial = trial_loop(main_program(egg)).run(0, 1)
    assert trial.record.outcome is Outcome.TOPPLED
    assert "does not stand" in trial.record.detail
