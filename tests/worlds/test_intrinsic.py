"""Load cells: intrinsic contact sensing on its own, and against the simulator's truth."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graspdsl.arrays import Array
from graspdsl.objects.box import Box
from graspdsl.objects.shapes import Body
from graspdsl.objects.sphere import Sphere
from graspdsl.spec.sensing import LoadCell, Touch
from graspdsl.worlds.touch.intrinsic import sphere_contact

from .scenes import (
    ROLL,
    bullet_world,
    force_of_table,
    grasped,
    main_program,
    moved,
    opened,
    run_phase,
    settings,
    side_start,
    still,
)

BOUND_REST = 5e-3  # N
RADIUS = 0.0115  # m
WEIGHT = np.array([0.0, 0.0, -9.81 * ROLL.mass])
SEEDS = st.integers(0, 2**32 - 1)


def contact(random: np.random.Generator, steepest: float) -> tuple[Array, Array]:
    """A point on the sphere and a force that pushes there, at most ``steepest`` rad off the inward normal."""
    point = random.normal(size=3)
    point *= RADIUS / np.linalg.norm(point)
    across = np.cross(point, random.normal(size=3))
    across /= np.linalg.norm(across)
    angle = random.uniform(0.0, steepest)
    direction = -np.cos(angle) * point / RADIUS + np.sin(angle) * across
    return point, random.uniform(0.05, 20.0) * direction


@given(SEEDS)
def test_a_soft_contact_is_found_exactly(seed: int) -> None:
    random = np.random.default_rng(seed)
    point, force = contact(random, steepest=1.2)
    spin = random.uniform(-0.003, 0.003) * np.linalg.norm(force) * point / RADIUS
    found = sphere_contact(force, np.cross(point, force) + spin, RADIUS)
    assert np.linalg.norm(found - point) < 1e-9


@given(SEEDS)
def test_friction_does_not_turn_the_normal(seed: int) -> None:
    """The same point under forces of any direction: one answer, though the forces turn by up to a radian."""
    random = np.random.default_rng(seed)
    point, force = contact(random, steepest=1.0)
    straight = -np.linalg.norm(force) * point / RADIUS
    for pressed in (force, straight):
        found = sphere_contact(pressed, np.cross(point, pressed), RADIUS)
        assert np.linalg.norm(found - point) < 1e-9


def test_the_scale_of_the_load_does_not_matter() -> None:
    point, force = contact(np.random.default_rng(0), steepest=0.8)
    for scale in (1e-6, 1.0, 1e6):
        assert np.linalg.norm(sphere_contact(scale * force, scale * np.cross(point, force), RADIUS) - point) < 1e-9


def test_no_force_has_no_place() -> None:
    with pytest.raises(ValueError, match="without a force"):
        sphere_contact(np.zeros(3), np.array([0.0, 0.0, 1e-3]), RADIUS)


@pytest.mark.slow
@pytest.mark.parametrize("roll", [0.0, 0.8])
def test_load_cells_agree_with_the_truth_at_rest(roll: float) -> None:
    with opened(bullet_world(settings())) as world:
        seen = grasped(world, side_start(roll=roll), main_program())
        for _ in range(50):
            seen = world.step(still())
        truth = world.truth()
        assert np.abs(seen.forces - truth.forces).max() < BOUND_REST
        assert np.linalg.norm(seen.points - truth.points, axis=1).max() < 5e-4  # soft tips dent
        assert np.linalg.norm(np.cross(seen.normals, truth.normals), axis=1).max() < 0.01
        assert np.linalg.norm(seen.forces, axis=1).min() > 0.2


@pytest.mark.slow
def test_load_cells_agree_with_the_truth_while_sliding() -> None:
    program = main_program()
    with opened(bullet_world(settings())) as world:
        seen = grasped(world, side_start(roll=0.8), program)
        first, errors = seen.points, []
        for _ in range(150):
            seen = run_phase(world, program, 1, 1, seen)[0]
            difference = (seen.forces - world.truth().forces)[seen.touching]
            errors.append(np.linalg.norm(difference, axis=1))
        assert np.linalg.norm(seen.points - first, axis=1).max() > 0.01  # it did slide
    assert np.percentile(np.concatenate(errors), 95) < 0.02


@pytest.mark.slow
@pytest.mark.parametrize(
    ("body", "height"),
    [
        (ROLL, 0.10),
        (Body("box", Box(size=(0.1, 0.1, 0.2)), 0.5), 0.10),
        (Body("ball", Sphere(diameter=0.12), 0.5), 0.06),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_forces_on_the_object_balance_at_rest(body: Body, height: float) -> None:
    with opened(bullet_world(settings(body=body))) as world:
        seen = grasped(world, side_start(body, roll=0.3, height=height), main_program())
        true, felt, ticks = np.zeros(3), np.zeros(3), 100
        for _ in range(ticks):
            seen = world.step(still())
            truth, table = world.truth(), force_of_table(world)
            true += (truth.forces.sum(axis=0) + table + WEIGHT) / ticks
            felt += (seen.forces.sum(axis=0) + table + WEIGHT) / ticks
        assert np.linalg.norm(true) < 0.02
        assert np.linalg.norm(felt) < 0.02
        across = truth.forces - np.einsum("ki,ki,kj->kj", truth.forces, truth.normals, truth.normals)
        assert np.linalg.norm(across, axis=1).max() > 0.05  # there is friction to get wrong
        assert table[2] > 1.0


@pytest.mark.slow
def test_taring_holds_when_the_wrist_turns_in_the_air() -> None:
    """The weight of the tips is known in every pose: with no threshold at all, next to nothing is felt."""
    sensing = LoadCell(touch=Touch(begins=0.0, ends=0.0))
    with opened(bullet_world(settings(sensing=sensing))) as world:
        first = world.reset(side_start(standoff=0.047), 0)
        away = moved(wrist_z=-0.002)
        for _ in range(60):
            world.step(away)
        turn = moved(wrist_roll_x=0.01, wrist_roll_y=0.008, wrist_roll_z=-0.012)
        for _ in range(80):
            world.step(turn)
        for _ in range(25):
            seen = world.step(still())
        assert np.linalg.norm(seen.orientations - first.orientations, axis=1).min() > 0.5
        assert np.linalg.norm(seen.forces, axis=1).max() < 0.01
        assert np.isnan(world.truth().forces).all()  # nothing touches
