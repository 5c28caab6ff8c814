"""What the truth says acts on the object: it makes up the change of the object's momentum, step by step."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.objects.shapes import catalogue
from graspdsl.worlds.bullet.engine import EFFORT, pybullet
from graspdsl.worlds.bullet.hand import rotation_matrix
from graspdsl.worlds.kind import Anchor
from graspdsl.worlds.protocol import PARTIES
from graspdsl.worlds.rigid.world import RigidWorld

from .scenes import ROBOT, ROLL, bullet_world, grasped, main_program, opened, run_phase, settings, side_start, still

TIME_STEP = EFFORT.time_step
WITHIN = np.repeat([1e-7, 1e-8], 3)  # N, N·m
STEPS = 20


def damped(velocity: Array) -> Array:
    """What the engine's own damping takes off a velocity a second, linear and quadratic."""
    return np.asarray(0.04 * velocity * (1.0 + np.linalg.norm(velocity)))


@dataclass(frozen=True)
class Step:
    """One step of physics: the rates (6,) of the object's momenta, and what PARTIES put on it, (4, 6)."""

    changed: Array
    loads: Array

    def closes(self, *without: str) -> bool:
        """Whether what acts, but for these parties, is what changed."""
        told = sum(load for party, load in zip(PARTIES, self.loads, strict=True) if party not in without)
        return bool((np.abs(self.changed - told) < WITHIN).all())


def stepped(world: RigidWorld) -> Iterator[Step]:
    """Steps of physics that the world takes as it is."""
    engine, client, thing = pybullet(), world.stage.client, world.stage.scene.object
    mass, _, moments = engine.getDynamicsInfo(thing, -1, client)[:3]

    def motion() -> tuple[Array, Array, Array]:
        _, quaternion = engine.getBasePositionAndOrientation(thing, client)
        axes = rotation_matrix(quaternion)
        velocity, turning = map(np.array, engine.getBaseVelocity(thing, client))
        return velocity, turning, axes @ np.diag(moments) @ axes.T

    for _ in range(STEPS):
        velocity, turning, inertia = motion()
        world.stage.scene.forget()
        engine.stepSimulation(client)
        world.stage.scene.note()
        later, turned, _ = motion()
        force = mass * ((later - velocity) / TIME_STEP + damped(velocity))
        moment = inertia @ ((turned - turning) / TIME_STEP + damped(turning)) + np.cross(turning, inertia @ turning)
        yield Step(np.concatenate([force, moment]), world.truth().loads)
    world.keep(np.array([0]))  # behind whose back these steps were taken: it looks again at what touches


def test_an_object_that_falls_has_its_weight_alone() -> None:
    with opened(bullet_world(settings())) as world:
        world.reset(side_start(), 0)
        world.stage.scene.place(((0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0)))
        steps = list(stepped(world))
    assert all(step.closes() and not step.closes("gravity") for step in steps)
    assert not any(step.loads[:3].any() for step in steps)


def test_an_object_that_slides_over_the_table_is_held_back_by_it() -> None:
    with opened(bullet_world(settings())) as world:
        world.reset(side_start(), 0)
        pybullet().resetBaseVelocity(world.stage.scene.object, [0.2, -0.1, 0.0], [0.0, 0.0, 1.0], world.stage.client)
        steps = list(stepped(world))
    assert all(step.closes() and not step.closes("table") for step in steps)
    assert np.linalg.norm([step.loads[2, :2] for step in steps], axis=1).max() > 1.0  # N


def test_an_object_is_as_heavy_as_gravity_makes_it() -> None:
    with opened(bullet_world(settings(gravity=1.62))) as world:
        world.reset(side_start(), 0)
        _, _, table, gravity = world.truth().loads
    assert gravity[2] == pytest.approx(-1.62 * ROLL.mass)
    np.testing.assert_allclose(table + gravity, 0.0, atol=0.01)


def test_what_is_afloat_stays_where_it_would_stand() -> None:
    with opened(bullet_world(settings(gravity=0.0, anchor=Anchor.AFLOAT))) as world:
        world.reset(side_start(), 0)
        before = world.truth()
        for _ in range(10):
            world.step(still())
        after = world.truth()
        pybullet().resetBaseVelocity(world.stage.scene.object, [0.0, 0.0, -0.5], [0.0, 0.0, 3.0], world.stage.client)
        for _ in range(20):
            world.step(still())
        fallen = world.truth()
    np.testing.assert_allclose(before.object_position, [0.0, 0.0, ROLL.shape.extent[2] / 2], atol=1e-9)
    np.testing.assert_array_equal(after.object_position, before.object_position)
    assert not after.loads.any()
    assert fallen.object_position[2] == pytest.approx(before.object_position[2] - 0.2, abs=0.01)  # through the table
    assert fallen.object_lean == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["squirt-bottle", "detergent-bottle"])
def test_a_bottle_of_many_parts_is_told_whole(name: str) -> None:
    """The engine tells friction on the first body of a pair: with a shape of many parts that is the other one."""
    bottle = catalogue()[name]
    with opened(bullet_world(settings(body=bottle))) as world:
        run_phase(world, main_program(), 0, 60, world.reset(side_start(bottle, height=0.06, standoff=0.05), 0))
        assert all(step.closes() and not step.closes("contacts") for step in stepped(world))
        np.testing.assert_allclose(world.truth().loads[0, :3], np.nansum(world.truth().forces, axis=0), atol=1e-9)


@pytest.mark.slow
def test_a_grasp_that_slides_and_pinches_is_told_whole() -> None:
    """At rest in the fingers as while they slide, however the fingertips rub; what another link does, too."""
    program = main_program()
    with opened(bullet_world(settings())) as world:
        seen = grasped(world, side_start(roll=0.5), program)
        for ticks in (5, 100):
            seen = run_phase(world, program, 1, ticks, seen)[-1]
            for step in stepped(world):
                assert step.closes()
                assert not any(step.closes(party) for party in ("contacts", "table", "gravity"))
        truth = world.truth()
        np.testing.assert_allclose(truth.loads[0, :3], truth.forces.sum(axis=0), atol=1e-9)
        levers = np.cross(truth.points - truth.object_position, truth.forces)
        np.testing.assert_allclose(truth.loads[0, 3:], levers.sum(axis=0), atol=1e-4)
        before = np.array(pybullet().getBaseVelocity(world.stage.scene.object, world.stage.client)[0])
        world.step(still())
        after = np.array(pybullet().getBaseVelocity(world.stage.scene.object, world.stage.client)[0])
        told = world.truth().loads[:, :3].sum(axis=0)
        np.testing.assert_allclose(told, ROLL.mass * (after - before) * world.info.rate, atol=1e-6)
        palm = world.palm()
        place = palm.position + (ROBOT.hand.palm_surface + 0.049) * palm.rotation[:, 2]
        world.stage.scene.place((tuple(place), (0.0, 0.0, 0.0, 1.0)))
        pressed = [step for step in stepped(world) if step.loads[1].any()]
    assert pressed
    assert all(step.closes() and not step.closes("links") for step in pressed)
