"""Soft fingertips: the law, and the engine that obeys it under forces light and heavy."""

from __future__ import annotations

import numpy as np
import pytest

from graspdsl.quality.carrying import Carrier
from graspdsl.spec.sensing import Exact, Proximity, TactileSensor
from graspdsl.worlds.touch.compliance import LINEAR_FORCE, STIFFNESS, force_of_dent, stiffness_under

from .scenes import ROBOT, bullet_world, grasped, main_program, opened, settings, side_start


def test_light_forces_meet_a_linear_spring() -> None:
    dents = np.linspace(0.0, LINEAR_FORCE / STIFFNESS, 20)
    np.testing.assert_allclose(force_of_dent(dents), 1500.0 * dents, atol=1e-12)
    assert force_of_dent(np.array(-1e-3)) == 0.0


def test_heavy_forces_meet_a_sphere_of_hertz() -> None:
    """Eight times the force dents four times as deep."""
    dent = 1.5 * LINEAR_FORCE / STIFFNESS
    assert force_of_dent(np.array(4.0 * dent)) == pytest.approx(8.0 * force_of_dent(np.array(dent)))


@pytest.mark.parametrize("force", [0.1, 0.5, 1.0, 3.0, 15.0, 40.0])
def test_the_stiffness_is_that_of_the_dent(force: float) -> None:
    assert force_of_dent(np.array(force / stiffness_under(force))) == pytest.approx(force)


@pytest.mark.slow
@pytest.mark.parametrize("sensing", [Exact(), Proximity()])
def test_the_engine_obeys(sensing: TactileSensor) -> None:
    """Squeezed ever harder, the dents that the engine shows belong to the forces that it shows."""
    with opened(bullet_world(settings(sensing=sensing, friction=0.5))) as world:
        carrier = Carrier(world, ROBOT, [0, 1, 2], grasped(world, side_start(roll=0.1), main_program()))
        for squeeze in (2.0, 15.0):
            for _ in range(150):
                carrier.observation = world.step(carrier.command(np.zeros(3), squeeze))
            assert carrier.squeeze == pytest.approx(squeeze, rel=0.02)
            truth = world.truth()
            forces = np.einsum("ki,ki->k", truth.forces, truth.normals)
            nearest = world.stage.fingertips.nearest(0.01)
            dents = -np.array([pair[0] for pair in nearest if pair is not None])
            np.testing.assert_allclose(force_of_dent(dents), forces, rtol=0.05)
