"""Where a picture of a grasp is taken from."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from graspdsl.arrays import Array
from graspdsl.worlds.camera import LEAST_ELEVATION, MOST_ELEVATION, camera_on, grasp_direction

numbers = st.floats(-1.0, 1.0)
vectors = st.tuples(numbers, numbers, numbers).map(np.array)
tips_of_grasps = st.lists(vectors, min_size=1, max_size=4).map(np.array)


def unit(vector: Array) -> Array:
    """A vector of length one along another."""
    return np.asarray(vector / np.linalg.norm(vector))


@given(tips_of_grasps, vectors.filter(lambda vector: np.linalg.norm(vector) > 0.1))
def test_a_grasp_is_seen_from_above_but_never_from_straight_above(tips: Array, normal: Array) -> None:
    """Also one whose tips are at one place, or in line with the palm's normal."""
    direction = grasp_direction(tips, unit(normal))
    assert np.linalg.norm(direction) == pytest.approx(1.0)
    elevation = math.asin(direction[2])
    assert LEAST_ELEVATION - 1e-9 <= elevation <= MOST_ELEVATION + 1e-9


@given(vectors, st.floats(-1.2, 1.2), st.floats(0.0, 2 * math.pi))
def test_the_view_turns_with_the_scene(along: Array, pitch: float, turn: float) -> None:
    """About the vertical, in which nothing but the table has a direction; for a palm that does not face it."""
    normal = np.array([math.cos(pitch), 0.0, math.sin(pitch)])
    assume(np.linalg.norm(np.cross(along, normal)) > 0.1)
    tips = np.array([along, -along])
    seen = grasp_direction(tips, normal)
    across = unit(np.cross(along, normal))
    up = np.array([0.0, 0.0, 1.0])
    assume(abs(across @ (np.cross(normal, up) + up)) > 1e-3)  # else two views are as good
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    assume(np.linalg.norm(seen[:2]) > 1e-3)
    np.testing.assert_allclose(grasp_direction(tips @ rotation.T, rotation @ normal), rotation @ seen, atol=1e-6)


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0])
def test_a_grasp_from_above_is_seen_across_its_fingers(angle: float) -> None:
    """Low, and at right angles to the line between the tips, which so is seen in its whole length."""
    line = np.array([math.cos(angle), math.sin(angle), 0.0])
    direction = grasp_direction(np.array([0.05 * line, -0.05 * line]), np.array([0.0, 0.0, -1.0]))
    assert direction @ line == pytest.approx(0.0, abs=1e-12)
    assert math.asin(direction[2]) == pytest.approx(LEAST_ELEVATION)
    camera = camera_on(np.array([0.05 * line, -0.05 * line]), direction, 400, 300)
    ends = camera.pixels(np.array([0.05 * line, -0.05 * line]))
    assert ends[0, 1] == pytest.approx(ends[1, 1])  # level in the picture
    assert abs(ends[0, 0] - ends[1, 0]) == pytest.approx(300.0, rel=0.1)  # over the shorter side


@pytest.mark.parametrize("line", [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.6, 0.8]])
def test_a_grasp_from_the_side_is_seen_over_the_palm_s_shoulder(line: list[float]) -> None:
    normal = np.array([1.0, 0.0, 0.0])
    direction = grasp_direction(np.array([line, -np.array(line)]), normal)
    assert direction @ normal < 0.0
    assert abs(direction[1]) > abs(direction[0])  # but from beside rather than from behind
