"""Start poses and their distributions."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graspdsl.hands.descriptions import hands
from graspdsl.objects.shape import shaded
from graspdsl.objects.shapes import catalogue
from graspdsl.spec.trials import StartSettings
from graspdsl.trials.starts import PLACEMENTS_EACH, draws, generator
from graspdsl.worlds.start_pose import pose

ROLL = catalogue()["towel-roll"]
RADIUS, HEIGHT = 0.05, 0.20  # m, of the towel roll
PALM = hands()["barrett"].palm_surface
LEVEL = {"roll": 0.0, "height": 0.1, "standoff": 0.05, "yaw": 0.0, "offset": 0.0, "tilt": 0.0}
ANGLES = st.floats(-1.5, 1.5)


@given(ANGLES, ANGLES, st.floats(-1.0, 1.0), st.sampled_from(["side", "top"]))
def test_a_pose_is_a_rotation(roll: float, yaw: float, tilt: float, approach: str) -> None:
    rotation = pose(approach, {**LEVEL, "roll": roll, "yaw": yaw, "tilt": tilt}, ROLL, PALM).rotation
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


@pytest.mark.slow
@given(ANGLES, ANGLES, st.floats(0.02, 0.3), st.floats(0.0, 0.2))
def test_from_the_side_the_palm_keeps_its_standoff(roll: float, yaw: float, standoff: float, height: float) -> None:
    start = pose("side", {**LEVEL, "roll": roll, "yaw": yaw, "standoff": standoff, "height": height}, ROLL, PALM)
    normal = start.rotation[:, 2]
    palm = start.position + PALM * normal
    assert palm[2] == pytest.approx(height)
    assert np.hypot(*palm[:2]) == pytest.approx(RADIUS + standoff)
    assert np.allclose(normal[:2], -palm[:2] / np.hypot(*palm[:2]), atol=1e-12)  # it faces the axis
    assert normal[2] == pytest.approx(0.0, abs=1e-12)
    assert np.arctan2(normal[1], normal[0]) == pytest.approx(yaw)


def test_from_above_the_palm_keeps_its_standoff() -> None:
    start = pose("top", {**LEVEL, "standoff": 0.06}, ROLL, PALM)
    assert np.allclose(start.rotation[:, 2], [0.0, 0.0, -1.0], atol=1e-12)
    assert np.allclose(start.position + PALM * start.rotation[:, 2], [0.0, 0.0, HEIGHT + 0.06], atol=1e-12)


@pytest.mark.parametrize(
    ("fraction", "metres"),
    [
        (0.5, 0.1),
        ({"uniform": [0.25, 0.75]}, {"uniform": [0.05, 0.15]}),
        ({"normal": [0.5, 0.1]}, {"normal": [0.1, 0.02]}),
        ({"choice": [0.25, 1]}, {"choice": [0.05, 0.2]}),
    ],
)
def test_a_height_may_be_a_fraction_of_that_of_the_object(fraction: object, metres: object) -> None:
    relative, plain = (StartSettings.model_validate({"height": h}) for h in ({"relative": fraction}, metres))
    assert relative.outcomes() == plain.outcomes()
    of_roll = relative.before(ROLL.shape.extent[2])
    drawn = [next(draws(start, ROLL, PALM, generator(1, 2))).drawn["height"] for start in (of_roll, plain)]
    assert drawn[0] == pytest.approx(drawn[1], rel=1e-12)


@given(ANGLES)
def test_roll_turns_the_hand_about_the_normal_of_its_palm(roll: float) -> None:
    level, rolled = (pose("side", {**LEVEL, "roll": angle}, ROLL, PALM) for angle in (0.0, roll))
    assert np.allclose(level.rotation[:, 0], [0.0, 0.0, 1.0], atol=1e-12)  # along the object's axis
    assert np.allclose(rolled.position, level.position, atol=1e-12)
    assert np.allclose(rolled.rotation[:, 2], level.rotation[:, 2], atol=1e-12)
    assert rolled.rotation[:, 0] @ level.rotation[:, 0] == pytest.approx(np.cos(roll))


def test_offset_moves_the_hand_sideways_only() -> None:
    straight, aside = (pose("side", {**LEVEL, "offset": offset}, ROLL, PALM) for offset in (0.0, 0.02))
    change = aside.position - straight.position
    assert np.linalg.norm(change) == pytest.approx(0.02)
    assert change @ straight.rotation[:, 2] == pytest.approx(0.0, abs=1e-12)
    assert change[2] == pytest.approx(0.0, abs=1e-12)


def test_tilt_lowers_the_view_of_the_palm() -> None:
    tilted = pose("side", {**LEVEL, "tilt": 0.5}, ROLL, PALM)
    assert tilted.rotation[2, 2] == pytest.approx(-np.sin(0.5))


def test_a_redraw_keeps_the_orientation_and_moves_the_hand() -> None:
    spec = StartSettings.model_validate({"roll": {"uniform": [-1.0, 1.0]}, "height": {"uniform": [0.05, 0.15]}})
    drawn = list(itertools.islice(draws(spec, ROLL, PALM, generator(1, 0)), PLACEMENTS_EACH + 1))
    rolls = [start.drawn["roll"] for start in drawn]
    assert len(set(rolls[:PLACEMENTS_EACH])) == 1
    assert rolls[PLACEMENTS_EACH] != rolls[0]
    assert len({start.drawn["height"] for start in drawn}) == PLACEMENTS_EACH + 1


@pytest.mark.parametrize(
    ("distribution", "mean", "low", "high"),
    [
        (0.3, 0.3, 0.3, 0.3),
        ({"uniform": [-1.0, 0.5]}, -0.25, -1.0, 0.5),
        ({"normal": [0.2, 0.1]}, 0.2, -0.4, 0.8),
        ({"choice": [-0.5, 0.1, 1.0]}, 0.2, -0.5, 1.0),
    ],
)
def test_values_follow_their_distribution(distribution: object, mean: float, low: float, high: float) -> None:
    spec = StartSettings.model_validate({"roll": distribution})
    values = [next(draws(spec, ROLL, PALM, generator(3, trial))).drawn["roll"] for trial in range(2000)]
    assert np.mean(values) == pytest.approx(mean, abs=0.06)
    assert low <= min(values) <= max(values) <= high


def test_a_trial_draws_the_same_whatever_else_is_run() -> None:
    spec = StartSettings.model_validate({"roll": {"uniform": [-1.0, 1.0]}})
    first = [next(draws(spec, ROLL, PALM, generator(7, trial))).drawn["roll"] for trial in range(5)]
    last = [next(draws(spec, ROLL, PALM, generator(7, trial))).drawn["roll"] for trial in (4, 3, 2, 1, 0)]
    assert first == last[::-1]
    assert len(set(first)) == 5
    assert first != [next(draws(spec, ROLL, PALM, generator(8, trial))).drawn["roll"] for trial in range(5)]


@given(ANGLES, st.sampled_from(["box", "squirt-bottle", "detergent-bottle", "ellipsoid"]))
def test_the_standoff_is_counted_from_what_the_object_shows_to_the_palm(yaw: float, name: str) -> None:
    """No part of an object is nearer to the palm than the standoff, and some part is as near."""
    body = catalogue()[name]
    start = pose("side", {**LEVEL, "yaw": yaw, "standoff": 0.05}, body, PALM)
    normal = start.rotation[:, 2]
    palm = (start.position + PALM * normal) @ normal
    nearest = min((part.vertices @ normal).min() for part in shaded(body.shape))
    assert nearest - palm == pytest.approx(0.05, abs=2e-4)
