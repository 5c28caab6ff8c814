"""The floating world as a World, on every shape that it has, and trials that run in it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from compiler.specs import floating

from graspdsl.compiler.program import Program, program_of
from graspdsl.objects.box import Box
from graspdsl.objects.shapes import SHAPES
from graspdsl.trials.outcomes import OUTCOMES, Outcome
from graspdsl.trials.setup import trial_loop, world_of
from graspdsl.worlds.floating import RATE, FloatingWorld
from graspdsl.worlds.protocol import Command, Observation, Start

from .floating_runs import HAND

ANYWHERE = Start(np.zeros(3), np.eye(3), {})
OBJECTS = {
    "sphere": "{sphere: {diameter: 0.10}}",
    "ellipsoid": "{ellipsoid: {size: [0.10, 0.15, 0.22]}}",
    "cylinder": "{cylinder: {diameter: 0.10, height: 0.20}}",
    "superquadric": "{superquadric: {size: [0.10, 0.12, 0.16], exponent: 3}}",
    "bottle": "bottle",
    "inline bottle": (
        "{bottle: {diameter: 0.08, height: 0.2, neck_diameter: 0.03, body_height: 0.1, neck_height: 0.05, "
        "shoulder: 0.01, edge: 0.005}, mass: 0.3}"
    ),
    "like": "{like: towel-roll, mass: 2}",
    "ball": "ball",
}
EACH_OBJECT = pytest.mark.parametrize("thing", OBJECTS.values(), ids=OBJECTS)


def program(thing: str, formula: str = "π_gx|{γ1, γ2, γ3} {γ1, γ2, γ3}", until: str = "") -> Program:
    """A formula on an object."""
    bounds = until or "force_residual: 0.1, moment_residual: 0.005, hold: 0.4"
    return program_of(floating(formula, scene=f"object: {thing}", until=bounds), "test.yaml")


def world(thing: str) -> FloatingWorld:
    """The floating world of an object."""
    made = world_of(program(thing))
    assert isinstance(made, FloatingWorld)
    return made


def commands(count: int, longest: float) -> list[Command]:
    """Displacements any which way, as long as ``longest`` [m] and longer."""
    random = np.random.default_rng(5)
    return [Command("x", random.normal(scale=longest, size=(HAND, 3))) for _ in range(count)]


def history(floating_world: FloatingWorld, seed: int, moves: list[Command]) -> list[Observation]:
    """What is seen from the start on."""
    return [floating_world.reset(ANYWHERE, seed), *map(floating_world.step, moves)]


def same(one: Observation, other: Observation) -> bool:
    """Whether two observations agree to the last bit."""
    return all(
        np.array_equal(getattr(one, field.name), getattr(other, field.name))
        for field in dataclasses.fields(Observation)
    )


def test_every_shape_is_here() -> None:
    assert {*OBJECTS} >= {*SHAPES} - {"box"}
    with pytest.raises(ValueError, match="sharp edges"):
        Box(size=(0.1, 0.1, 0.1)).surface()


@EACH_OBJECT
def test_same_start_and_commands_give_the_same_observations(thing: str) -> None:
    moves = commands(20, 0.02)
    first, used = history(world(thing), 3, moves), world(thing)
    history(used, 4, moves[:7])
    again = history(used, 3, moves)
    assert all(map(same, first, again))
    assert not same(first[0], history(used, 4, [])[0])


@EACH_OBJECT
def test_contacts_stay_on_the_surface_and_sense_it(thing: str) -> None:
    made = program(thing)
    surface = made.body.shape.surface()
    for step, seen in enumerate(history(world(thing), 3, commands(50, 0.03))):
        assert np.abs(surface.level(seen.points)).max() < 1e-12
        np.testing.assert_allclose(np.linalg.norm(seen.normals, axis=-1), 1.0, atol=1e-12)
        deeper = seen.points + 1e-4 * seen.normals
        assert np.all(surface.level(deeper) < -0.5e-4)
        assert seen.touching.all()
        assert seen.time == pytest.approx(step / RATE)


@EACH_OBJECT
def test_observation_has_the_shapes_of_a_hand_without_joints(thing: str) -> None:
    floating_world = world(thing)
    seen = floating_world.reset(ANYWHERE, 0)
    shapes = {field.name: np.shape(getattr(seen, field.name)) for field in dataclasses.fields(Observation)}
    rows, jacobians = (HAND, 3), (HAND, 3, 0)
    assert shapes == {
        "time": (),
        "points": rows,
        "normals": rows,
        "forces": rows,
        "touching": (HAND,),
        "joints": (0,),
        "jacobian": jacobians,
        "angular_jacobian": jacobians,
        "orientations": rows,
        "centre_of_mass": (3,),
        "weight": (3,),
    }
    assert floating_world.info.contacts == tuple(f"point-{i + 1}" for i in range(HAND))
    assert floating_world.info.joints == ()
    assert floating_world.info.lower.shape == floating_world.info.upper.shape == (0,)


def test_weight_is_that_of_the_object() -> None:
    for thing, mass in ((OBJECTS["like"], 2.0), (OBJECTS["inline bottle"], 0.3), ("ball", 0.3)):
        np.testing.assert_allclose(world(thing).reset(ANYWHERE, 0).weight, [0.0, 0.0, -9.81 * mass])


@EACH_OBJECT
def test_truth_is_what_is_sensed_and_the_object_stays_put(thing: str) -> None:
    floating_world = world(thing)
    seen = floating_world.reset(ANYWHERE, 1)
    for move in commands(5, 0.02):
        truth = floating_world.truth()
        np.testing.assert_array_equal(truth.points, seen.points)
        np.testing.assert_array_equal(truth.normals, seen.normals)
        np.testing.assert_array_equal(truth.object_position, 0.0)
        np.testing.assert_array_equal(truth.object_axis, [0.0, 0.0, 1.0])
        assert truth.touching_links == ()
        seen = floating_world.step(move)


@EACH_OBJECT
def test_only_the_part_along_the_surface_moves_a_contact(thing: str) -> None:
    floating_world = world(thing)
    before = floating_world.reset(ANYWHERE, 2)
    after = floating_world.step(Command("x", 0.01 * before.normals))
    np.testing.assert_allclose(after.points, before.points, atol=1e-14)
    step = np.cross(before.normals, [0.6, 0.0, 0.8]) * 1e-5
    after = floating_world.step(Command("x", step))
    np.testing.assert_allclose(after.points - before.points, step, atol=1e-7)


@pytest.mark.parametrize("space", ["ψ", "r", "q"])
def test_other_commands_are_refused(space: str) -> None:
    floating_world = world("ball")
    before = floating_world.reset(ANYWHERE, 0)
    with pytest.raises(ValueError, match=f"moves contacts \\(x\\), not {space}"):
        floating_world.step(Command(space, np.zeros((HAND, 3))))
    np.testing.assert_array_equal(floating_world.truth().points, before.points)


def test_starts_are_spread_over_the_surface() -> None:
    """As many contacts above as below, on every side."""
    floating_world = world("ball")
    points = np.concatenate([floating_world.reset(ANYWHERE, seed).points for seed in range(200)])
    assert np.abs(np.mean(points > 0.0, axis=0) - 0.5).max() < 4 * 0.5 / np.sqrt(len(points))


@pytest.mark.slow
@EACH_OBJECT
def test_trials_run_to_a_named_end(thing: str) -> None:
    loop = trial_loop(program(thing))
    for number in range(3):
        record = loop.run(number, 11).record
        assert record.outcome in {Outcome.CONVERGED, OUTCOMES["local-minimum"], Outcome.TIMEOUT}
        assert len(record.rejected) == 0
        assert record.object_shift == record.object_lean == 0.0
        if record.outcome is Outcome.CONVERGED:
            assert record.force_residual_end < 0.1
            assert record.moment_residual_end < 0.005
            assert record.ticks_to_converge is not None
        assert max(record.point_error + record.normal_error) < 1e-7


@pytest.mark.slow
@pytest.mark.parametrize("thing", [OBJECTS["sphere"], OBJECTS["ellipsoid"]], ids=["sphere", "ellipsoid"])
def test_trials_on_smooth_bodies_converge(thing: str) -> None:
    loop = trial_loop(program(thing))
    assert [loop.run(number, 11).record.outcome for number in range(10)] == [Outcome.CONVERGED] * 10


@pytest.mark.slow
def test_a_trial_is_a_function_of_its_number_and_seed() -> None:
    records = []
    for numbers in ((0, 1, 2), (2,)):
        loop = trial_loop(program(OBJECTS["ellipsoid"]))
        records.append([loop.run(number, 11) for number in numbers][-1])
    one, other = (dataclasses.replace(trial.record, wall_s=0.0) for trial in records)
    assert repr(one) == repr(other)
    for name, rows in records[0].trajectory.items():
        np.testing.assert_array_equal(rows, records[1].trajectory[name])


def test_stages_follow_one_another() -> None:
    """C* on a sphere: the force's stage ends the trial's first half, and both residuals are low at the end."""
    trial = trial_loop(program(OBJECTS["sphere"], "π_cstar|{γ1, γ2, γ3} {γ1, γ2, γ3}")).run(0, 1)
    assert trial.record.outcome is Outcome.CONVERGED
    assert trial.record.force_residual_end < 0.1 < trial.record.force_residual_start
