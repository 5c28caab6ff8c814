"""The bullet world: repeatable, bounded, and rigid where it should be."""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.worlds.kind import Anchor
from graspdsl.worlds.protocol import Command, InfeasibleStartError

from .scenes import (
    JOINTS,
    bullet_world,
    digest,
    grasped,
    main_program,
    moved,
    numbers,
    opened,
    pose_of_object,
    pose_of_palm,
    run_phase,
    settings,
    side_start,
    still,
)


def commands() -> Array:
    """A close of all fingers with some wandering of the wrist."""
    rows = np.random.default_rng(5).normal(0.0, 3e-4, (120, len(JOINTS)))
    rows[:, [JOINTS.index(f"base-{i}") for i in (1, 2, 3)]] += 2e-3
    return rows


@pytest.mark.slow
def test_the_same_commands_show_the_same_bits() -> None:
    assert digest(commands()) == digest(commands())
    assert digest(commands()) != digest(1.01 * commands())


@pytest.mark.slow
def test_a_fresh_process_shows_the_same_bits() -> None:
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as elsewhere:
        assert elsewhere.submit(digest, commands()).result() == digest(commands())


@pytest.mark.slow
def test_a_reset_world_repeats_itself() -> None:
    program = main_program()
    with opened(bullet_world(settings())) as world:
        runs = []
        for roll in (0.3, -0.6, 0.3):
            seen = [world.reset(side_start(roll=roll), 1)]
            seen += run_phase(world, program, 0, 60, seen[0])
            runs.append(b"".join(map(numbers, seen)))
    assert runs[0] == runs[2] != runs[1]


def test_close_may_come_at_any_time() -> None:
    world = bullet_world(settings())
    world.close()
    world.reset(side_start(), 0)
    assert world.is_open
    world.close()
    world.close()
    assert not world.is_open
    assert np.isfinite(world.reset(side_start(), 0).points).all()
    world.close()


def test_a_command_in_another_space_is_an_error() -> None:
    with opened(bullet_world(settings())) as world:
        world.reset(side_start(), 0)
        with pytest.raises(ValueError, match="joints"):
            world.step(Command("x", np.zeros((3, 3))))


@pytest.mark.parametrize(
    "drawn",
    [{"standoff": -0.03}, {"height": 0.0}, {"standoff": 0.4}, {"offset": 0.15}],
    ids=lambda drawn: next(iter(drawn)),
)
def test_starts_that_cannot_be(drawn: dict[str, float]) -> None:
    with opened(bullet_world(settings())) as world:
        with pytest.raises(InfeasibleStartError):
            world.reset(side_start(**drawn), 0)
        assert world.reset(side_start(), 0).time == 0.0


def test_a_start_touches_nothing() -> None:
    with opened(bullet_world(settings())) as world:
        for roll in (-0.4, 0.0, 0.8):
            seen, truth = world.reset(side_start(roll=roll), 0), world.truth()
            assert not seen.touching.any()
            assert np.isnan(truth.forces).all()
            assert truth.touching_links == ()
            assert truth.object_lean < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_joints_stay_within_their_limits(sign: float) -> None:
    with opened(bullet_world(settings())) as world:
        world.reset(side_start(standoff=0.047), 0)
        for _ in range(40):
            seen = world.step(moved(wrist_z=-0.005))  # back, out of the way
        push = Command("q", np.where(np.char.startswith(JOINTS, "wrist"), 0.0, sign * 0.05))
        for _ in range(120):
            seen = world.step(push)
        fingers = ~np.char.startswith(JOINTS, "wrist")
        lower, upper = world.info.lower[fingers], world.info.upper[fingers]
        assert (seen.joints[fingers] > lower - 0.01).all()
        assert (seen.joints[fingers] < upper + 0.01).all()
        end = lower if sign < 0.0 else upper
        assert np.abs(seen.joints[fingers] - end).min() < 0.02  # some did get there
        targets = world._trials[0].target
        assert (targets >= world.info.lower).all()
        assert (targets <= world.info.upper).all()


@pytest.mark.slow
def test_a_held_object_moves_with_the_palm() -> None:
    with opened(bullet_world(settings(anchor=Anchor.HAND))) as world:
        seen = world.reset(side_start(), 0)
        assert np.linalg.norm(seen.weight - [0.0, 0.0, -9.81 * 0.5]) < 1e-9

        def relative() -> tuple[Array, Array]:
            (palm, turn), (place, pose) = pose_of_palm(world), pose_of_object(world)
            return turn.inv().apply(place - palm), (turn.inv() * pose).as_matrix()

        place, turn = relative()
        before = pose_of_object(world)[1]
        for _ in range(100):
            world.step(moved(wrist_roll_x=0.005, wrist_roll_y=-0.004, wrist_roll_z=0.006))
            now, turned = relative()
            assert np.linalg.norm(now - place) < 1e-3
            assert np.arccos(min(1.0, (np.trace(turned @ turn.T) - 1.0) / 2.0)) < 0.01
        assert (pose_of_object(world)[1] * before.inv()).magnitude() > 0.5


@pytest.mark.slow
def test_a_fixed_object_does_not_move() -> None:
    with opened(bullet_world(settings(anchor=Anchor.WORLD))) as world:
        grasped(world, side_start(roll=0.5), main_program())
        before, turn = pose_of_object(world)
        for _ in range(60):
            seen = world.step(moved(base_1=0.002, base_2=0.002, wrist_x=0.0005))
        assert np.linalg.norm(seen.forces, axis=1).max() > 2.0
        after, turned = pose_of_object(world)
        assert np.array_equal(before, after)
        assert (turned * turn.inv()).magnitude() < 1e-9


@pytest.mark.slow
def test_a_free_object_does_move() -> None:
    with opened(bullet_world(settings())) as world:
        grasped(world, side_start(), main_program())
        before, _ = pose_of_object(world)
        for _ in range(60):
            world.step(moved(wrist_y=0.0005))  # along the contacts' normals
        assert np.linalg.norm(pose_of_object(world)[0] - before) > 0.01


@pytest.mark.slow
@pytest.mark.parametrize("height", [0.005, -0.005])
def test_a_probe_displaces_contacts(height: float) -> None:
    """Up or down the side of a cylinder, all contacts alike."""
    asked = np.tile([0.0, 0.0, height], (3, 1))
    with opened(bullet_world(settings(probes=True))) as world:
        before = grasped(world, side_start(), main_program("control.displacement=probing"))
        position = world.truth().object_position
        after, truth = world.step(Command("x", asked)), world.truth()
        assert after.touching.all()
        assert after.time > before.time + 0.3  # many ticks
        assert np.linalg.norm(after.points - before.points - asked, axis=1).max() < 1.5e-3
        assert np.linalg.norm(truth.object_position - position) < 1e-3
        distances = np.linalg.norm((truth.points - truth.object_position)[:, :2], axis=1)
        assert np.abs(distances - 0.05).max() < 1e-3


def test_a_probing_world_moves_joints_too() -> None:
    with opened(bullet_world(settings(probes=True))) as probing, opened(bullet_world(settings())) as sliding:
        start = side_start()
        assert numbers(probing.reset(start, 0)) == numbers(sliding.reset(start, 0))
        assert numbers(probing.step(moved(base_1=0.01))) == numbers(sliding.step(moved(base_1=0.01)))
        assert numbers(probing.step(still())) != numbers(sliding.step(moved(base_2=0.01)))


def off_force(*overrides: str) -> float:
    """How far [N] contact forces get from the 0.5 N asked for while they slide for 6 s."""
    program = main_program(*overrides)
    with opened(bullet_world(settings())) as world:
        seen = grasped(world, side_start(roll=0.5), program)
        shown = run_phase(world, program, 1, 300, seen)
    assert all(seen.touching.all() for seen in shown)
    return float(np.abs([np.linalg.norm(seen.forces, axis=1) - 0.5 for seen in shown]).max())


@pytest.mark.slow
def test_a_transpose_presses_no_more_than_the_pseudo_inverse() -> None:
    """Jᵀ moves contacts not only where they are asked to go: what presses is projected away, or made little of."""
    bound = off_force()
    assert bound < 0.2
    for way in ("control.nullspace=task", "control.position_gain=0.2"):
        assert off_force("control.inverse=transpose", way) < bound
