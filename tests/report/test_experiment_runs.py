"""What the bounds of residuals already say of orientations, against grasps drawn at random on a roll."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.report.experiment_runs import ExperimentRun, largest_tilt
from graspdsl.trials.measures import orientation
from report.hand_made import HandMade, evidence

RADIUS, HALF_HEIGHT = 0.05, 0.1  # m
COUNT = 150_000


def contacts(random: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Points (n, 3, 3) and inward normals of three contacts on a standing roll: on the side, opposed more or less, but
    for one in twenty on the top."""
    angles = random.uniform(0.0, 2.0 * np.pi, (count, 1)) + np.array([0.0, np.pi, np.pi])
    angles += random.normal(0.0, 1.0, (count, 3)) * random.uniform(0.0, 0.6, (count, 1))
    heights = random.normal(0.0, 0.02, (count, 3)) * random.uniform(0.0, 1.0, (count, 1))
    normals = -np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=-1)
    points = -RADIUS * normals + np.stack([0.0 * angles, 0.0 * angles, heights], axis=-1)
    on_top = (random.uniform(size=(count, 3)) < 0.05)[..., None]
    points = np.where(on_top, points * [0.5, 0.5, 0.0] + [0.0, 0.0, HALF_HEIGHT], points)
    return points, np.where(on_top, [0.0, 0.0, -1.0], normals)


@pytest.mark.slow
@pytest.mark.parametrize("weights", [(1.0, 0.5, 0.5), (1.0, 1.0, 0.0)], ids=["thumb-and-virtual", "two-contacts"])
@pytest.mark.parametrize(("force", "moment"), [(0.1, 0.005), (0.3, 0.01)])
def test_no_good_grasp_of_a_roll_is_farther_from_perpendicular(
    weights: tuple[float, float, float], force: float, moment: float
) -> None:
    """Than the formula says, and some are four fifths as far."""
    points, normals = contacts(np.random.default_rng(5), COUNT)
    share = np.array(weights)[:, None]
    centroid = (share * points).sum(axis=1, keepdims=True) / share.sum()
    net_force = np.linalg.norm((share * normals).sum(axis=1), axis=-1)
    net_moment = np.linalg.norm((share * np.cross(points - centroid, normals)).sum(axis=1), axis=-1)
    good = (net_force < force) & (net_moment < moment)
    assert good.sum() > 500
    members = share[1:] / share[1:].sum()
    pairs = np.stack([points[good, 0], (members * points[good, 1:]).sum(axis=1)], axis=1)
    tilts = np.pi / 2 - orientation(pairs, np.array([0.0, 0.0, 1.0]))
    assert np.isfinite(tilts).all()
    most = largest_tilt(force, moment, 2.0 * RADIUS)
    assert tilts.max() <= most
    assert tilts.max() > (0.8 if weights[2] else 0.65) * most  # two contacts have no members to make up for


def test_with_no_force_the_tilt_is_that_of_the_moment_between_opposed_contacts() -> None:
    """A moment of 5 mm on a roll of 10 cm: atan 0.05, which is within a thousandth of 0.05 rad."""
    assert largest_tilt(0.0, 0.005, 0.1) == pytest.approx(0.05, abs=1e-4)


def test_of_trials_whose_trajectories_are_lost_nothing_is_claimed() -> None:
    """Neither that they ended near π/2 nor that they did not; one that ended before its first tick is no such trial."""
    whole = evidence(1, [HandMade()] * 4 + [HandMade(touching=False)] * 2 + [HandMade(force=math.nan)])
    left = {number: course for number, course in whole.courses.items() if number not in (1, 4, 6)}
    run = ExperimentRun(replace(whole, courses=left, lost=frozenset({1, 4})))
    assert [record.number for record in run.near(math.pi / 2)] == [0, 2, 3]
    assert [record.number for record in run.far(math.pi / 2)] == [5, 6]
