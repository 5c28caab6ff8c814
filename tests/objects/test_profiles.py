"""Profiles of lines and arcs: joined without a corner, impossible ones refused."""

from __future__ import annotations

import numpy as np
import pytest

from graspdsl.objects.bottle import SmoothBottle
from graspdsl.objects.surfaces.profile import Pair, Profile, rounded

from .table import generator

BOTTLE = SmoothBottle(0.08, 0.25, 0.03, 0.15, 0.06, 0.02, 0.008).profile
# A foot with a hollow under it, a wall that leans in, a lid.
BOWL = rounded(
    ((0.0, 0.02), (0.02, 0.02), (0.03, 0.0), (0.06, 0.0), (0.04, 0.1), (0.0, 0.1)), (0.004, 0.006, 0.01, 0.01)
)
EACH_PROFILE = pytest.mark.parametrize("profile", [BOTTLE, BOWL], ids=["bottle", "bowl"])


@EACH_PROFILE
def test_lines_and_arcs_meet_and_share_their_tangents(profile: Profile) -> None:
    lines, arcs = profile.lines, profile.arcs
    every, ones = np.arange(len(arcs.half)), np.ones(len(arcs.half))
    before = (arcs.at(every, -ones), (lines.start + lines.length[:, None] * lines.direction)[:-1], lines.direction[:-1])
    after = (arcs.at(every, ones), lines.start[1:], lines.direction[1:])
    for joints, points, ahead in (before, after):
        np.testing.assert_allclose(joints, points, atol=1e-15)
        outward = arcs.side[:, None] * (joints - arcs.centre) / arcs.radius[:, None]
        np.testing.assert_allclose(outward, np.stack([ahead[:, 1], -ahead[:, 0]], axis=-1), atol=1e-13)


@EACH_PROFILE
def test_no_point_of_the_outline_is_nearer_than_the_nearest(profile: Profile) -> None:
    outline = profile.outline(2000)
    chords = np.diff(outline, axis=0)
    points = generator().uniform([0.0, -0.2], [0.15, 0.2], (200, 2))
    feet, normals = profile.nearest(points)
    reach = np.linalg.norm(points - feet, axis=-1)
    for point, found in zip(points, reach, strict=True):
        shares = np.clip(np.sum((point - outline[:-1]) * chords, axis=-1) / np.sum(chords**2, axis=-1), 0.0, 1.0)
        gaps = np.linalg.norm(outline[:-1] + shares[:, None] * chords - point, axis=-1)
        assert found == pytest.approx(gaps.min(), abs=1e-8)
    np.testing.assert_allclose(np.abs(np.sum((points - feet) * normals, axis=-1)), reach, atol=1e-15)


@pytest.mark.parametrize(("direction", "reach"), [((0.0, -1.0), 0.0), ((0.0, 1.0), 0.1)])
def test_reach_up_and_down(direction: Pair, reach: float) -> None:
    assert BOWL.reach(*direction) == pytest.approx(reach, abs=1e-15)


def test_reach_sideways_is_to_the_bulge_of_an_arc() -> None:
    assert BOWL.reach(1.0, 0.0) == pytest.approx(BOWL.outline(20_000)[:, 0].max(), abs=1e-9)
    assert BOWL.reach(1.0, 0.0) < 0.06


@pytest.mark.parametrize(
    ("corners", "radii", "words"),
    [
        (((0, 0), (1, 0), (1, 2), (0, 2)), (0.1,), "need 2 radii"),
        (((0, 0), (0, 2)), (), "need 0 radii"),
        (((0, 0), (1, 0), (1, 2), (0, 2)), (0.1, -0.1), "positive"),
        (((0.1, 0), (1, 0), (1, 2), (0, 2)), (0.1, 0.1), "right angles"),
        (((0, 0), (1, 0.1), (1, 2), (0, 2)), (0.1, 0.1), "right angles"),
        (((0, 0), (1, 0), (-1, 1), (1, 2), (0, 2)), (0.1, 0.1, 0.1), "keeps off"),
        (((0, 0), (1, 0), (1, 0), (1, 2), (0, 2)), (0.1, 0.1, 0.1), "twice"),
        (((0, 0), (1, 0), (1, 2), (0, 2)), (0.5, 0.6), None),
        (((0, 0), (1, 0), (1, 1), (0, 1)), (0.5, 0.6), "no room"),
    ],
)
def test_impossible_profiles_are_refused(
    corners: tuple[Pair, ...], radii: tuple[float, ...], words: str | None
) -> None:
    if words is None:
        rounded(corners, radii)
    else:
        with pytest.raises(ValueError, match=words):
            rounded(corners, radii)
