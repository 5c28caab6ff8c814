"""The chapter's own formulas, 4.3 to 4.7, against central differences and against the basis in use."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross, spherical_frames, spherical_stretch, tangent_frames, tangent_planes
from graspdsl.basis.effectors import EFFECTORS, sphere_by_cartesian
from graspdsl.basis.potentials import POTENTIALS
from graspdsl.basis.sensors import SENSORS
from graspdsl.contracts.differences import central_differences
from graspdsl.contracts.drawing import (
    CONTACTS,
    NESTED,
    PLAIN,
    SETS,
    VIRTUAL,
    WITH_GRAVITY,
    generator,
    inputs,
    with_gravity,
)

from .coordinates import SPHERICAL
from .coordinates import angles as angles_of

ONE = np.ones(1)
RADIUS = np.array(1.7)


def force(angles: Array) -> Array:
    """Eq. 4.3, of (θ, φ)."""
    theta, phi = angles
    return -np.array([np.cos(theta) * np.cos(phi), np.sin(theta) * np.cos(phi), np.sin(phi)])


def force_by_angles(angles: Array) -> Array:
    """Eq. 4.4."""
    theta, phi = angles
    return np.array(
        [
            [np.sin(theta) * np.cos(phi), np.cos(theta) * np.sin(phi)],
            [-np.cos(theta) * np.cos(phi), np.sin(theta) * np.sin(phi)],
            [0.0, -np.cos(phi)],
        ]
    )


def moment(angles: Array, steps: Array) -> Array:
    """Eq. 4.6, of (r_θ, r_φ)."""
    (theta, phi), (r_theta, r_phi) = angles, steps
    return np.array(
        [
            -r_theta * np.sin(phi) * np.cos(theta) + r_phi * np.sin(theta),
            -r_theta * np.sin(phi) * np.sin(theta) - r_phi * np.cos(theta),
            r_theta * np.cos(phi),
        ]
    )


def moment_by_steps(angles: Array) -> Array:
    """Eq. 4.7."""
    theta, phi = angles
    return np.array(
        [
            [-np.cos(theta) * np.sin(phi), np.sin(theta)],
            [-np.sin(theta) * np.sin(phi), -np.cos(theta)],
            [np.cos(phi), 0.0],
        ]
    )


def directions(angles: Array) -> Array:
    """The unit vectors along growing θ and φ, as columns (3, 2)."""
    theta, phi = angles
    east = [-np.sin(theta), np.cos(theta), 0.0]
    north = [-np.cos(theta) * np.sin(phi), -np.sin(theta) * np.sin(phi), np.cos(phi)]
    return np.array([east, north]).T


def places(steepest: float = np.pi / 2) -> Array:
    """Angles (θ, φ) all over the sphere, up to a latitude."""
    random = generator()
    return np.stack([random.uniform(-np.pi, np.pi, 200), random.uniform(-steepest, steepest, 200)], axis=-1)


def test_4_4_is_the_derivative_of_4_3() -> None:
    for angles in places():
        assert np.abs(force_by_angles(angles) - central_differences(force, angles)).max() < 1e-8


def test_4_7_is_the_derivative_of_4_6() -> None:
    for angles in places():
        differences = central_differences(lambda steps, at=angles: moment(at, steps), np.zeros(2))
        assert np.abs(moment_by_steps(angles) - differences).max() < 1e-8


def test_4_6_is_the_moment_of_a_point_on_the_tangent_plane() -> None:
    for angles, steps in zip(places(), generator().normal(size=(200, 2)), strict=True):
        np.testing.assert_allclose(moment(angles, steps), cross(directions(angles) @ steps, force(angles)), atol=1e-14)


def tangents_at(angles: Array) -> Array:
    """How displacements of one contact turn its normal, by local frames, which have no stretch."""
    return sphere_by_cartesian(tangent_frames(force(angles)[None]), np.ones((1, 2)))


def test_local_frames_span_the_plane_across_the_normal() -> None:
    """T Tᵀ = I − n nᵀ, so that no frames are needed where they have no stretch."""
    for angles in places():
        np.testing.assert_allclose(tangents_at(angles), tangent_planes(force(angles)[None]), atol=1e-15)


def test_force_effector_is_4_4_away_from_the_poles() -> None:
    """−P/r along east and north is 4.4 over r, but for the cos φ by which a degree of θ is shorter up there."""
    for angles in places(steepest=np.radians(80)):
        effector = EFFECTORS["τ_frx"].evaluate(ONE, tangents_at(angles), RADIUS)
        lengths = np.array([np.cos(angles[1]), 1.0])
        np.testing.assert_allclose(
            effector @ directions(angles), force_by_angles(angles) / lengths / RADIUS, atol=1e-12
        )


def test_moment_effector_is_4_7() -> None:
    for angles in places(steepest=np.radians(80)):
        effector = EFFECTORS["τ_mrx"].evaluate(ONE, force(angles)[None])
        np.testing.assert_allclose(effector @ directions(angles), moment_by_steps(angles), atol=1e-12)


def test_spherical_effectors_are_the_chapters_entry_by_entry() -> None:
    """4.12 of 4.4; 4.16 of 4.7 with r_θ = rθ; 4.28 and 4.29 by the rows of 4.27 over r; up to the very poles."""
    for angles in places():
        normal = force(angles)[None]
        given = {
            "normals": normal,
            "frames": spherical_frames(normal),
            "stretch": spherical_stretch(normal),
            "tangents": sphere_by_cartesian(spherical_frames(normal), spherical_stretch(normal)),
            "curvature_radius": RADIUS,
        }
        by_x = directions(angles).T / RADIUS
        expected = {
            "τ_fr": force_by_angles(angles),
            "τ_mr": RADIUS * moment_by_steps(angles),
            "τ_w": np.vstack([force_by_angles(angles), moment_by_steps(angles)]),
            "τ_frx": force_by_angles(angles) @ by_x,
            "τ_mrx": RADIUS * moment_by_steps(angles) @ by_x,
            "τ_wx": np.vstack([force_by_angles(angles), moment_by_steps(angles)]) @ by_x,
        }
        for symbol, entries in expected.items():
            effector = EFFECTORS[symbol]
            found = effector.evaluate(ONE, *[given[name] for name in effector.reads])
            np.testing.assert_allclose(found, entries, atol=1e-12)


def test_spherical_effector_of_several_contacts_has_one_block_each() -> None:
    """4.12 over a set is 4.4 of each contact side by side."""
    angles = places()[:CONTACTS]
    normals = np.stack([force(place) for place in angles])
    found = EFFECTORS["τ_fr"].evaluate(VIRTUAL.weights, spherical_frames(normals), spherical_stretch(normals))
    expected = np.hstack(
        [weight * force_by_angles(place) for weight, place in zip(VIRTUAL.weights, angles, strict=True)]
    )
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_spherical_and_tangent_effectors_differ_off_the_equator() -> None:
    """4.4 through 4.27 shortens what lies along θ by cos φ; at the equator the two are one."""
    for latitude, same in ((0.0, True), (np.pi / 3, False)):
        normal = force(np.array([0.7, latitude]))[None]
        forms = [
            EFFECTORS["τ_frx"].evaluate(ONE, sphere_by_cartesian(*frames), RADIUS)
            for frames in (
                (spherical_frames(normal), spherical_stretch(normal)),
                (tangent_frames(normal), np.ones((1, 2))),
            )
        ]
        assert np.allclose(*forms, atol=1e-12) == same


@pytest.mark.parametrize(("by_surface", "by_displacement"), [("τ_fr", "τ_frx"), ("τ_mr", "τ_mrx"), ("τ_w", "τ_wx")])
def test_4_28_and_4_29_are_4_12_and_4_16_through_the_tangent_frame(by_surface: str, by_displacement: str) -> None:
    """With ψ in radians on a sphere of radius r, a displacement is r ψ."""
    given = inputs(generator(), CONTACTS)
    by_psi, by_x = (
        effector.evaluate(NESTED.weights, *[given[name] for name in effector.reads])
        for effector in (EFFECTORS[by_surface], EFFECTORS[by_displacement])
    )
    for contact, frame in enumerate(tangent_frames(given["normals"])):
        step = given["curvature_radius"] * frame
        in_psi, in_x = by_psi[:, 2 * contact : 2 * contact + 2], by_x[:, 3 * contact : 3 * contact + 3]
        np.testing.assert_allclose(in_psi, in_x @ step, atol=1e-12)


def test_4_38_is_4_4_through_the_angles_that_turn_with_the_contact() -> None:
    """∂f/∂ψ ∂ψ/∂r, ψ the angles of the normals: each contact turns by the same r, near a pole or not."""
    around = places(steepest=np.radians(85)).reshape(-1, CONTACTS, 2)
    for angles in around:
        normals = np.stack([force(place) for place in angles])
        expected = np.zeros((3, 3))
        for place, normal, weight in zip(angles, normals, NESTED.weights, strict=True):

            def turned(r: Array, normal: Array = normal, place: Array = place) -> Array:
                after = np.array(angles_of(Rotation.from_rotvec(r).apply(normal)))
                return np.asarray((after - place + np.pi) % (2 * np.pi) - np.pi)

            expected += weight * force_by_angles(place) @ central_differences(turned, np.zeros(3))
        found = EFFECTORS["τ_frr"].evaluate(NESTED.turning, normals)
        np.testing.assert_allclose(found, expected, atol=1e-7)


def test_turning_everything_changes_nothing_without_gravity() -> None:
    """The gradients are ∝ ρ_f × ρ_f and ρ_m × ρ_m: zero, as the chapter has it under 4.41; not so with γ_g."""
    random = generator()
    for resources in (*SETS.values(), *WITH_GRAVITY.values()):
        for _ in range(20):
            given = inputs(random, CONTACTS)
            given = with_gravity(given) if resources.has_gravity else given
            for slope in _slopes(resources.weights, given, turning=resources.turning):
                assert (np.linalg.norm(slope) < 1e-12) != resources.has_gravity


def _slopes(
    weights: Array, given: dict[str, Array], space: str = "x", turning: Array | None = None
) -> tuple[Array, Array]:
    """The gradients ∇φ_fr and ∇φ_mr by contact displacements, (3k,) each; or in ψ, or of what turns (2, k), in r."""
    found = []
    ending = {"ψ": "", "x": "x"}[space] if turning is None else "r"
    moved = weights if turning is None else turning
    for potential, sensor, effector in (("φ_fr", "σ_fr", f"τ_fr{ending}"), ("φ_mr", "σ_mr", f"τ_mr{ending}")):
        sensed = SENSORS[sensor].evaluate(weights, *[given[name] for name in SENSORS[sensor].reads])
        task = EFFECTORS[effector].evaluate(moved, *[given[name] for name in EFFECTORS[effector].reads])
        found.append(task.T @ POTENTIALS[potential].gradient(-sensed))
    return found[0], found[1]


def _cosine(one: Array, other: Array) -> float:
    return float(one @ other / np.linalg.norm(one) / np.linalg.norm(other))


def test_slope_is_written_out_per_contact() -> None:
    """dx_fr ∝ w P F and dx_mr ∝ −w f × M: the forms free of coordinates."""
    given = inputs(generator(), CONTACTS)
    weights, normals = VIRTUAL.weights, given["normals"]
    net = weights @ normals
    twist = weights @ cross(given["points"] - given["origin"], normals)
    force_slope, moment_slope = (slope.reshape(-1, 3) for slope in _slopes(weights, given))
    tangential = net - np.sum(net * normals, axis=-1, keepdims=True) * normals
    np.testing.assert_allclose(force_slope, 2 * weights[:, None] * tangential / given["curvature_radius"], atol=1e-12)
    np.testing.assert_allclose(moment_slope, -2 * weights[:, None] * cross(normals, twist[None]), atol=1e-12)


@pytest.mark.parametrize("space", ["ψ", "x"])
def test_force_and_moment_slopes_are_normal_with_equal_weights(space: str) -> None:
    random = generator()
    for _ in range(200):
        assert abs(_cosine(*_slopes(PLAIN.weights, inputs(random, CONTACTS), space))) < 1e-12


def test_force_and_moment_slopes_are_not_normal_in_the_chapters_coordinates() -> None:
    """The cos φ of 4.4 that 4.7 has not."""
    random = generator()
    draws = (inputs(random, CONTACTS, coordinates=SPHERICAL) for _ in range(200))
    assert np.median([abs(_cosine(*_slopes(PLAIN.weights, given))) for given in draws]) > 0.01


def test_wrench_slope_is_the_sum_of_force_and_moment_slopes() -> None:
    """∇φ_w = ∇φ_fr + ∇φ_mr / r²: one gradient that cannot tell the two apart."""
    random = generator()
    for _ in range(20):
        given = inputs(random, CONTACTS)
        force_slope, moment_slope = _slopes(VIRTUAL.weights, given)
        sensor, effector = SENSORS["σ_w"], EFFECTORS["τ_wx"]
        sensed = sensor.evaluate(VIRTUAL.weights, *[given[name] for name in sensor.reads])
        task = effector.evaluate(VIRTUAL.weights, *[given[name] for name in effector.reads])
        expected = force_slope + moment_slope / given["curvature_radius"] ** 2
        np.testing.assert_allclose(task.T @ POTENTIALS["φ_w"].gradient(-sensed), expected, atol=1e-10)


def test_force_and_moment_slopes_are_not_normal_with_a_virtual_contact() -> None:
    random = generator()
    cosines = [abs(_cosine(*_slopes(VIRTUAL.weights, inputs(random, CONTACTS)))) for _ in range(200)]
    assert np.median(cosines) > 0.01
