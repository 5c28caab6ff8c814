"""What every world owes its controllers, whichever engine is behind it."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler.program import program_of
from graspdsl.hands.descriptions import robot
from graspdsl.objects.shapes import catalogue
from graspdsl.worlds.kind import WorldSettings
from graspdsl.worlds.kinds import WORLDS
from graspdsl.worlds.protocol import Command, Observation, Start, WitnessedWorld
from graspdsl.worlds.start_pose import pose

ROBOT = robot("barrett", "gantry")
ROLL = catalogue()["towel-roll"]
DRAWN = {"roll": 0.3, "yaw": 0.2, "tilt": 0.0, "height": 0.1, "standoff": 0.047, "offset": 0.0}
START = pose("side", DRAWN, ROLL, ROBOT.hand.palm_surface)
SETTINGS = WorldSettings(ROBOT, ROLL, 0.4)
MAIN = Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml"


WAYS = [(name, probes) for name, kind in WORLDS.items() for probes in sorted({False, kind.probes("probing")})]


@pytest.fixture(params=WAYS, ids=lambda way: f"{way[0]}{'-probing' if way[1] else ''}")
def world_and_space(request: pytest.FixtureRequest) -> tuple[WitnessedWorld, str]:
    """A world of the table and a gradient space that it carries out a tick at a time."""
    name, probes = request.param
    kind = WORLDS[name]
    space = "q" if GradientSpace.JOINTS in kind.sliding else "x"
    return kind.make(replace(SETTINGS, sensing=kind.sensor(None), probes=probes)), space


def small(world: WitnessedWorld, space: str, seed: int) -> Command:
    """A small random command of the right size."""
    size = (len(world.info.contacts), 3) if space == "x" else (len(world.info.joints),)
    return Command(space, np.random.default_rng(seed).normal(scale=1e-4, size=size))


def run(world: WitnessedWorld, space: str, start: Start, ticks: int = 5) -> list[Observation]:
    """A few observations from a start."""
    seen = [world.reset(start, seed=11)]
    seen += [world.step(small(world, space, seed)) for seed in range(ticks)]
    return seen


def same(one: Observation, other: Observation) -> bool:
    """Whether two observations agree to the last bit."""
    pairs = ((getattr(one, field.name), getattr(other, field.name)) for field in fields(Observation))
    return all(np.array_equal(np.asarray(a), np.asarray(b), equal_nan=True) for a, b in pairs)


def test_observations_have_the_promised_shapes(world_and_space: tuple[WitnessedWorld, str]) -> None:
    """k contacts and n joints, unit normals, zero force where nothing touches."""
    world, space = world_and_space
    contacts, joints = len(world.info.contacts), len(world.info.joints)
    for seen in run(world, space, START):
        assert seen.points.shape == seen.normals.shape == seen.forces.shape == (contacts, 3)
        assert seen.touching.shape == (contacts,)
        assert seen.touching.dtype == bool
        assert seen.joints.shape == (joints,)
        assert seen.jacobian.shape == seen.angular_jacobian.shape == (contacts, 3, joints)
        assert seen.orientations.shape == (contacts, 3)
        assert seen.centre_of_mass.shape == seen.weight.shape == (3,)
        np.testing.assert_allclose(np.linalg.norm(seen.normals, axis=1), 1.0, atol=1e-9)
        assert not seen.forces[~seen.touching].any()
    world.close()


def test_time_goes_on(world_and_space: tuple[WitnessedWorld, str]) -> None:
    """A tick takes one over the rate."""
    world, space = world_and_space
    times = [seen.time for seen in run(world, space, START)]
    np.testing.assert_allclose(np.diff(times), 1.0 / world.info.rate)
    assert times[0] == 0.0
    world.close()


def test_a_trial_repeats(world_and_space: tuple[WitnessedWorld, str]) -> None:
    """The same start, seed and commands give the same observations to the last bit."""
    world, space = world_and_space
    first, again = run(world, space, START), run(world, space, START)
    assert all(same(one, other) for one, other in zip(first, again, strict=True))
    assert not same(first[0], first[-1])
    world.close()


def test_a_command_in_another_space_is_refused(world_and_space: tuple[WitnessedWorld, str]) -> None:
    """A world says so when it cannot carry a command out."""
    world, space = world_and_space
    world.reset(START, seed=1)
    with pytest.raises(ValueError, match="moves"):
        world.step(replace(small(world, space, 0), space="r"))
    world.close()


def closed(world: WitnessedWorld) -> Observation:
    """What is seen once the fingers, where there are any, have closed upon the object."""
    seen = world.reset(START, seed=11)
    close = program_of(MAIN.read_text("utf-8"), MAIN.name).pipelines()[0][0]
    for _ in range(200 if len(seen.joints) else 0):
        seen = world.step(close.evaluate(seen).command)
    return seen


@pytest.mark.slow
def test_the_truth_agrees_with_what_is_sensed(world_and_space: tuple[WitnessedWorld, str]) -> None:
    """Where a contact touches, its true point is where it is sensed, within the softness of a fingertip."""
    world, _ = world_and_space
    seen, truth = closed(world), world.truth()
    touching = np.isfinite(truth.points[:, 0]) & seen.touching
    assert touching.sum() == len(world.info.contacts)
    np.testing.assert_allclose(truth.points[touching], seen.points[touching], atol=1e-3)
    assert np.isclose(np.linalg.norm(truth.object_axis), 1.0)
    np.testing.assert_allclose(truth.object_rotation @ truth.object_rotation.T, np.eye(3), atol=1e-6)
    assert truth.object_lean < 0.01
    world.close()


def test_closing_twice_is_no_harm(world_and_space: tuple[WitnessedWorld, str]) -> None:
    """A closed world can be closed again and reset again."""
    world, _ = world_and_space
    world.reset(START, seed=1)
    world.close()
    world.close()
    assert world.reset(START, seed=1).time == 0.0
    world.close()
