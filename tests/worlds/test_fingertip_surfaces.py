"""Fingertip surfaces: contacts of every kind are found again; nearest points and normals against brute force."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.hands.fingertips import CapsuleTip, EllipsoidTip, FingertipShape, SphereTip
from graspdsl.worlds.touch.surfaces import CapsuleSurface, EllipsoidSurface, FingertipSurface, fingertip_surface

SHAPES: tuple[FingertipShape, ...] = (
    SphereTip(radius=0.0115),
    EllipsoidTip(semi_axes=(0.008, 0.011, 0.016), rpy=(0.3, -0.7, 1.1)),
    EllipsoidTip(semi_axes=(0.02, 0.004, 0.01)),
    CapsuleTip(radius=0.008, length=0.02, axis=(1.0, -2.0, 0.5)),
    CapsuleTip(radius=0.012, length=0.001),
)
EACH_SHAPE = pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
SEEDS = st.integers(0, 2**32 - 1)
ANY = arrays(float, 3, elements=st.floats(-1e300, 1e300))
SIZE = 0.05  # m, larger than every tip


def surface_point(surface: FingertipSurface, random: np.random.Generator) -> Array:
    """Some point of the surface, everywhere on it."""
    return surface.nearest(random.normal(size=3) * random.choice([SIZE, 0.01]))


def pushed(surface: FingertipSurface, point: Array, random: np.random.Generator) -> tuple[Array, Array]:
    """The load (f, m) of a contact with friction of up to 1.2 rad and with torsion about its normal."""
    normal = surface.normal(point)
    across = np.cross(normal, random.normal(size=3))
    across /= np.linalg.norm(across)
    angle, strength = random.uniform(0.0, 1.2), random.uniform(0.05, 20.0)
    force = strength * (-np.cos(angle) * normal + np.sin(angle) * across)
    torsion = random.uniform(-0.004, 0.004) * strength * normal
    return force, np.cross(point, force) + torsion


@EACH_SHAPE
@given(seed=SEEDS)
def test_a_soft_contact_is_found_again(shape: FingertipShape, seed: int) -> None:
    random, surface = np.random.default_rng(seed), fingertip_surface(shape)
    point = surface_point(surface, random)
    force, moment = pushed(surface, point, random)
    assert np.linalg.norm(surface.contact(force, moment) - point) < 1e-9


@EACH_SHAPE
@given(force=ANY, moment=ANY)
def test_every_load_has_a_point_of_the_surface(shape: FingertipShape, force: Array, moment: Array) -> None:
    surface = fingertip_surface(shape)
    if not force.any():
        with pytest.raises(ValueError, match="without a force"):
            surface.contact(force, moment)
        return
    point = surface.contact(force, moment)
    assert np.linalg.norm(surface.nearest(point) - point) < 1e-9
    assert surface.normal(point) @ (force / np.abs(force).max()) < 1e-5


@EACH_SHAPE
def test_noise_moves_a_contact_little(shape: FingertipShape) -> None:
    """The point is a continuous function of the load: a thousandth of noise moves it by less than half a millimetre."""
    random, surface = np.random.default_rng(5), fingertip_surface(shape)
    for _ in range(300):
        point = surface_point(surface, random)
        force = -surface.normal(point)
        noise = random.normal(size=(2, 3)) * np.array([[1e-3], [1e-5]])
        found = surface.contact(force + noise[0], np.cross(point, force) + noise[1])
        assert np.linalg.norm(found - point) < 5e-4


@EACH_SHAPE
def test_a_contact_solves_the_equation_best(shape: FingertipShape) -> None:
    """Of 20000 points of the surface none explains a contact's load as well as the one that is found."""
    random, surface = np.random.default_rng(6), fingertip_surface(shape)
    taxels = surface.taxels(4e-4).points
    normals = np.array([surface.normal(point) for point in taxels])

    def misfit(points: Array, outward: Array, force: Array, moment: Array) -> Array:
        rest = moment - np.cross(points, force)
        rest = rest - np.einsum("ti,ti->t", rest, outward)[:, None] * outward
        return np.where(outward @ force < 0.0, np.linalg.norm(rest, axis=1), np.inf)

    for _ in range(10):
        point = surface_point(surface, random)
        force, moment = pushed(surface, point, random)
        found = surface.contact(force, moment)
        grid = misfit(taxels, normals, force, moment)
        assert misfit(found[None], surface.normal(found)[None], force, moment)[0] <= grid.min()
        assert np.linalg.norm(taxels[grid.argmin()] - found) < 2e-3


@given(seed=SEEDS)
def test_contacts_turn_with_the_tip(seed: int) -> None:
    random = np.random.default_rng(seed)
    turn = Rotation.random(random_state=seed % 2**31).as_matrix()
    force, moment = random.normal(size=3), 0.008 * random.normal(size=3)  # whether a contact explains it or not
    axes = Rotation.from_euler("xyz", [0.4, 1.0, -0.2]).as_matrix()
    pairs = (
        (EllipsoidSurface((0.008, 0.011, 0.016), axes), EllipsoidSurface((0.008, 0.011, 0.016), turn @ axes)),
        (CapsuleSurface(0.008, 0.02, axes), CapsuleSurface(0.008, 0.02, turn @ axes)),
    )
    for still, turned in pairs:
        found = turned.contact(turn @ force, turn @ moment)
        assert np.linalg.norm(found - turn @ still.contact(force, moment)) < 1e-9


def test_an_ellipsoid_and_a_capsule_become_spheres() -> None:
    random = np.random.default_rng(7)
    round_ones = (
        EllipsoidTip(semi_axes=(0.0115, 0.0115, 0.0115), rpy=(1.0, 2.0, 3.0)),
        CapsuleTip(radius=0.0115, length=1e-12),
    )
    for _ in range(200):
        force, moment = random.normal(size=3), 0.005 * random.normal(size=3)
        sphere = fingertip_surface(SHAPES[0]).contact(force, moment)
        for shape in round_ones:
            assert np.linalg.norm(fingertip_surface(shape).contact(force, moment) - sphere) < 1e-8


def test_a_line_of_action_beside_the_sphere_has_its_nearest_point() -> None:
    """A force along −z that acts 15 mm beside the centre of a sphere of 11.5 mm: its rim on that side."""
    force, away = np.array([0.0, 0.0, -1.0]), np.array([0.009, 0.012, 0.0])
    found = fingertip_surface(SHAPES[0]).contact(force, np.cross(away, force))
    np.testing.assert_allclose(found, 0.0115 * away / 0.015, atol=1e-7)


@EACH_SHAPE
@given(seed=SEEDS)
def test_nearest_points_stand_above_their_feet(shape: FingertipShape, seed: int) -> None:
    random, surface = np.random.default_rng(seed), fingertip_surface(shape)
    foot = surface_point(surface, random)
    above = foot + random.uniform(0.0, SIZE) * surface.normal(foot)
    assert np.linalg.norm(surface.nearest(above) - foot) < 1e-9


@EACH_SHAPE
def test_normals_are_across_the_surface(shape: FingertipShape) -> None:
    random, surface = np.random.default_rng(8), fingertip_surface(shape)
    for _ in range(100):
        point = surface_point(surface, random)
        normal = surface.normal(point)
        assert np.linalg.norm(normal) == pytest.approx(1.0)
        beside = surface.nearest(point + 1e-7 * random.normal(size=3))
        assert abs(normal @ (beside - point)) < 1e-4 * np.linalg.norm(beside - point) + 1e-16
        assert normal @ point > 0.0


@pytest.mark.slow
@EACH_SHAPE
def test_taxels_cover_the_surface_evenly(shape: FingertipShape) -> None:
    surface = fingertip_surface(shape)
    points, areas = surface.taxels(0.001)
    assert max(np.linalg.norm(surface.nearest(point) - point) for point in points) < 1e-7
    apart = np.linalg.norm(points[:, None] - points, axis=2) + np.diag(np.full(len(points), np.inf))
    assert np.percentile(apart.min(axis=0), 5) > 4e-4
    assert apart.min(axis=0).max() < 1.5e-3
    fine = surface.taxels(0.0004).areas.sum()
    assert areas.sum() == pytest.approx(fine, rel=0.02)


def test_areas_of_taxels_sum_to_that_of_the_shape() -> None:
    sphere, capsule = SHAPES[0], SHAPES[3]
    assert isinstance(sphere, SphereTip)
    assert isinstance(capsule, CapsuleTip)
    assert fingertip_surface(sphere).taxels(0.0005).areas.sum() == pytest.approx(4 * np.pi * sphere.radius**2, rel=1e-3)
    tube = 2 * np.pi * capsule.radius * (capsule.length + 2 * capsule.radius)
    assert fingertip_surface(capsule).taxels(0.0005).areas.sum() == pytest.approx(tube, rel=1e-3)
