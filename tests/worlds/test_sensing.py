"""Tactile sensing over whole sliding trials, against the simulator's contacts."""

from __future__ import annotations

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.compiler.program import program_of
from graspdsl.trials.setup import trial_loop

from .scenes import MAIN, main_program

pytestmark = pytest.mark.slow

TRIALS = ((101, 0), (102, 1), (103, 2))  # seed and number
SLIDING = 1


def errors(*overrides: str) -> tuple[Array, Array]:
    """Distances [m] of sensed from true points and angles [rad] between normals while contacts touch and slide."""
    loop = trial_loop(main_program("evaluate=[]", *overrides))
    distances, angles = [], []
    for seed, number in TRIALS:
        rows = loop.run(number, seed).trajectory
        sliding = (rows["phase"] == SLIDING)[:, None] & rows["touching"].astype(bool)
        both = sliding & np.isfinite(rows["forces"]).all(axis=2)
        assert both.sum() > 50
        points, sensed = rows["points"][both].astype(float), rows["sensed_points"][both].astype(float)
        normals, felt = rows["normals"][both].astype(float), rows["sensed_normals"][both].astype(float)
        distances.append(np.linalg.norm(sensed - points, axis=1))
        sine = np.linalg.norm(np.cross(felt, normals), axis=1)
        angles.append(np.arctan2(sine, np.einsum("ki,ki->k", felt, normals)))
    return np.concatenate(distances), np.concatenate(angles)


@pytest.mark.parametrize(
    ("world", "friction"), [*(("bullet", friction) for friction in (0.2, 0.4, 0.6)), ("mujoco", 0.4)]
)
def test_load_cells_place_contacts(world: str, friction: float) -> None:
    distances, angles = errors(f"scene.friction={friction}", f"scene.world={world}")
    assert np.percentile(distances, 95) < 1e-3
    assert np.degrees(np.percentile(angles, 95)) < 2.0
    assert distances.max() > 0.0  # it is sensed, not copied


@pytest.mark.parametrize(("name", "tared"), [("load_cell", 0.5), ("skin", 0.5), ("proximity", 0.0)])
def test_sensors_as_they_are_lead_to_a_good_grasp(name: str, tared: float) -> None:
    """By the simulator's truth, with noise, bias and latency, from a start half a radian off."""
    spec = MAIN.parent / "sensing" / f"{name}.yaml"
    program = program_of(spec.read_text("utf-8"), spec.name, ("trials.start.roll=0.5",))
    record = trial_loop(program).run(0, 7).record
    assert record.orientation_start < 1.3
    assert record.force_residual_end < 0.1
    assert record.moment_residual_end < 0.005
    assert abs(record.orientation_end - np.pi / 2) < 0.05
    assert 0.0 < record.point_error[0] < record.point_error[1] < 3e-3
    assert 0.0 < record.normal_error[0] < record.normal_error[1] < 0.2
    assert record.tare_s == tared


def test_exact_sensing_is_exact() -> None:
    distances, angles = errors("scene.sensing=exact")
    assert distances.max() == 0.0
    assert angles.max() == 0.0
