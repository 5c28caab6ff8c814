"""Whether objects stand, by statics, against closed forms and against the engine."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
import yaml

from graspdsl.objects.cylinder import Cylinder
from graspdsl.objects.ellipsoid import Ellipsoid
from graspdsl.objects.shape import Shape
from graspdsl.objects.shapes import Body, shape_from
from graspdsl.objects.standing import fall_of, pose_at_rest
from graspdsl.objects.superquadric import Superquadric
from graspdsl.objects.triangles import TriangleMesh, enclosed
from graspdsl.objects.turned import Turned, posed, turned
from graspdsl.spec.scene import InlineObject
from graspdsl.worlds.bullet.stages import BulletEngine
from graspdsl.worlds.protocol import UnstableObjectError
from graspdsl.worlds.rigid.settling import resting_pose


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "degrees"),
    [
        (Ellipsoid(size=(0.06, 0.06, 0.12)), 90.0),  # on its end
        (Ellipsoid(size=(0.12, 0.06, 0.10)), 90.0),  # on the middle one of its axes
        (Ellipsoid(size=(0.12, 0.10, 0.06)), 0.0),
        (Superquadric(size=(0.06, 0.06, 0.2), exponent=8.0), 0.0),  # on its flat end
    ],
)
def test_how_far_a_body_falls(shape: Shape, degrees: float) -> None:
    assert math.degrees(fall_of(shape)) == pytest.approx(degrees, abs=1.0)


def leaning(aside: float) -> TriangleMesh:
    """A prism 0.1 m high on a base of 0.04 m by 0.04 m, its top displaced sideways [m]."""
    base = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * 0.02
    low, high = np.column_stack([base, np.zeros(4)]), np.column_stack([base + np.array([aside, 0.0]), np.full(4, 0.1)])
    hull = trimesh.convex.convex_hull(np.concatenate([low, high]))
    vertices = np.asarray(hull.vertices) - hull.bounds.mean(axis=0)
    faces = np.asarray(hull.faces, dtype=np.int64)
    return TriangleMesh(vertices, faces, vertices, enclosed(vertices, faces))


@pytest.mark.parametrize(
    ("aside", "stands"), [(0.0, True), (0.034, True), (0.046, False), (0.08, False), (-0.05, False)]
)
def test_a_prism_stands_while_its_middle_is_over_its_base(aside: float, stands: bool) -> None:
    """Its centre of mass is aside by half of what its top is; the base reaches 0.02 m."""
    assert (fall_of(leaning(aside)) == 0.0) is stands


@pytest.mark.slow
@pytest.mark.parametrize(
    "shape",
    [
        Ellipsoid(size=(0.06, 0.06, 0.12)),
        Ellipsoid(size=(0.10, 0.06, 0.05)),
        shape_from(
            {
                "compound": [
                    {"box": {"size": [0.02, 0.02, 0.1]}, "at": [0, 0, 0.05]},
                    {"box": {"size": [0.1, 0.02, 0.02]}, "at": [0.05, 0, 0.11]},
                ]
            }
        ),
        shape_from(
            {
                "compound": [
                    {"box": {"size": [0.06, 0.06, 0.1]}, "at": [0, 0, 0.05]},
                    {"box": {"size": [0.06, 0.02, 0.02]}, "at": [0.04, 0, 0.11]},
                ]
            }
        ),
        leaning(0.03),
        leaning(0.05),
    ],
)
def test_the_engine_says_the_same(shape: Shape) -> None:
    fall = math.degrees(fall_of(shape))
    if fall > 5.0:
        with pytest.raises(UnstableObjectError):
            resting_pose(BulletEngine(), Body("", shape, 0.3), 0.5, 9.81)
    else:
        resting_pose(BulletEngine(), Body("", shape, 0.3), 0.5, 9.81)


@pytest.mark.parametrize(
    ("shape", "pose"),
    [
        (Ellipsoid(size=(0.06, 0.06, 0.12)), "pose: lay-down"),
        (turned(Cylinder(diameter=0.08, height=0.1), (0.03, 0.0, 0.0)), None),  # it tips by 1.7°
        (turned(Ellipsoid(size=(0.08, 0.1, 0.12)), (1.5708, 0.0, 0.0)), None),
    ],
)
def test_in_the_pose_that_is_proposed_it_stays(shape: Shape, pose: str | None) -> None:
    said = pose_at_rest(shape)
    assert said is not None
    assert pose in (None, said)
    whole = shape.shape if isinstance(shape, Turned) else shape
    thing = InlineObject.model_validate({"sphere": {"diameter": 0.1}, **yaml.safe_load(said)})
    assert fall_of(posed(whole, thing.pose)) == 0.0
