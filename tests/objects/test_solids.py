"""Volume, centre of mass and inertia of every shape, against textbooks and against a count of cells."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.objects.box import Box
from graspdsl.objects.compound import Compound
from graspdsl.objects.cylinder import Cylinder
from graspdsl.objects.ellipsoid import Ellipsoid
from graspdsl.objects.mass import Solid, joined
from graspdsl.objects.shapes import catalogue
from graspdsl.objects.sphere import Sphere
from graspdsl.objects.superquadric import Superquadric

from .thing import SHAPES, cells, inside, parts_inside

MASS = 0.7  # kg
CELLS = 120  # along each axis
EACH_SHAPE = pytest.mark.parametrize("name", SHAPES)


@pytest.mark.parametrize(
    ("shape", "volume", "moments"),
    [
        (Sphere(diameter=0.2), 4 / 3 * np.pi * 0.1**3, np.full(3, 2 / 5 * MASS * 0.1**2)),
        (Box(size=(0.1, 0.2, 0.3)), 0.006, MASS / 12 * np.array([0.13, 0.10, 0.05])),
        (
            Cylinder(diameter=0.1, height=0.2),
            np.pi * 0.05**2 * 0.2,
            MASS * np.array([*[0.05**2 / 4 + 0.2**2 / 12] * 2, 0.05**2 / 2]),
        ),
        (
            Ellipsoid(size=(0.2, 0.4, 0.6)),
            4 / 3 * np.pi * 0.1 * 0.2 * 0.3,
            MASS / 5 * np.array([0.2**2 + 0.3**2, 0.1**2 + 0.3**2, 0.1**2 + 0.2**2]),
        ),
    ],
)
def test_textbook_shapes(shape: Sphere | Box | Cylinder | Ellipsoid, volume: float, moments: np.ndarray) -> None:
    solid = shape.solid
    assert solid.volume == pytest.approx(volume, rel=1e-12)
    np.testing.assert_allclose(solid.inertia(MASS), np.diag(moments), rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(solid.centre, 0.0)


@EACH_SHAPE
def test_the_radius_of_gyration_is_that_about_an_axis_on_average(name: str) -> None:
    """In the mean square over any three axes at right angles; of a ball √(2/5) r."""
    solid = SHAPES[name].solid
    turn = Rotation.random(random_state=7).as_matrix()
    about = np.einsum("ia,ij,ja->a", turn, solid.inertia(MASS), turn) / MASS
    assert solid.radius_of_gyration == pytest.approx(np.sqrt(about.mean()), rel=1e-12)
    assert Sphere(diameter=0.2).solid.radius_of_gyration == pytest.approx(0.1 * np.sqrt(2 / 5), rel=1e-12)


def test_a_superquadric_of_exponent_two_is_an_ellipsoid() -> None:
    size = (0.10, 0.12, 0.16)
    one, other = Superquadric(size=size, exponent=2.0).solid, Ellipsoid(size=size).solid
    assert one.volume == pytest.approx(other.volume, rel=1e-12)
    np.testing.assert_allclose(one.moments, other.moments, rtol=1e-12, atol=1e-18)


@pytest.mark.slow
@EACH_SHAPE
def test_integrals_agree_with_a_count_of_cells(name: str) -> None:
    shape = SHAPES[name]
    points, cell = cells(shape, CELLS)
    points = points[inside(shape, points)]
    solid = shape.solid
    size = np.array(shape.extent)
    assert solid.volume == pytest.approx(len(points) * cell, rel=5e-3)
    np.testing.assert_allclose(solid.centre, points.mean(axis=0), atol=2e-3 * size.max())
    moments = cell * (points - points.mean(axis=0)).T @ (points - points.mean(axis=0))
    np.testing.assert_allclose(solid.moments, moments, atol=1e-2 * np.trace(moments))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["squirt-bottle", "detergent-bottle"])
def test_parts_of_a_compound_do_not_overlap(name: str) -> None:
    shape = catalogue()[name].shape
    assert isinstance(shape, Compound)
    points, _ = cells(shape, CELLS)
    within = np.sum(parts_inside(shape, points), axis=0)
    assert within.max() == 1


def test_joined_halves_are_the_whole() -> None:
    half = Box(size=(0.1, 0.2, 0.15)).solid
    whole = joined(half.placed(np.eye(3), np.array([0.0, 0.0, z])) for z in (-0.075, 0.075))
    np.testing.assert_allclose(whole.moments, Box(size=(0.1, 0.2, 0.3)).solid.moments, rtol=1e-12, atol=1e-18)


def test_principal_axes_turn_with_the_solid() -> None:
    turn = Rotation.from_euler("xyz", [0.3, -0.5, 1.1]).as_matrix()
    box = Box(size=(0.1, 0.2, 0.3)).solid
    moments, axes = box.placed(turn, np.zeros(3)).principal(MASS)
    np.testing.assert_allclose(np.sort(moments), np.sort(np.diag(box.inertia(MASS))), rtol=1e-12)
    np.testing.assert_allclose(axes @ np.diag(moments) @ axes.T, turn @ box.inertia(MASS) @ turn.T, atol=1e-15)
    assert np.linalg.det(axes) == pytest.approx(1.0)


@EACH_SHAPE
def test_moments_are_those_of_a_possible_body(name: str) -> None:
    solid: Solid = SHAPES[name].solid
    moments, _ = solid.principal(MASS)
    assert (moments > 0.0).all()
    assert 2.0 * moments.max() <= moments.sum() * (1.0 + 1e-12)  # none is larger than the two others together
