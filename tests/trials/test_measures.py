"""Measures of grasps against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graspdsl.arrays import Array
from graspdsl.basis.resources import ContactResource, ContactSet
from graspdsl.trials.measures import DOWN, measure, orientation, sensing_errors, true_contacts
from graspdsl.worlds.protocol import Observation, Truth

UP = np.array([0.0, 0.0, 1.0])


def seen(points: Array, normals: Array, touching: list[bool] | None = None) -> Observation:
    """What contacts at known places sense, without a hand."""
    count = len(points)
    return Observation(
        time=0.0,
        points=points,
        normals=normals,
        forces=np.zeros((count, 3)),
        touching=np.ones(count, dtype=bool) if touching is None else np.array(touching),
        joints=np.zeros(0),
        jacobian=np.zeros((count, 3, 0)),
        angular_jacobian=np.zeros((count, 3, 0)),
        orientations=np.zeros((count, 3)),
        centre_of_mass=np.zeros(3),
        weight=np.zeros(3),
    )


def truth(points: Array, normals: Array, axis: Array = UP, position: Array | None = None) -> Truth:
    """The truth of contacts at known places."""
    place = np.zeros(3) if position is None else position
    return Truth(points, normals, np.zeros_like(points), place, np.eye(3), axis, 0.0, (), (), (), np.zeros((4, 6)))


def contacts(count: int, *groups: tuple[int, ...]) -> ContactSet:
    """A set of virtual contacts; without groups, of each contact alone."""
    chosen = groups or tuple((i,) for i in range(count))
    members = tuple(ContactResource(f"γ{i}", tuple((c, 1 / len(g)) for c in g)) for i, g in enumerate(chosen))
    return ContactSet("Γ", members, count)


def ring(count: int, radius: float = 0.05) -> tuple[Array, Array]:
    """Contacts evenly about the z axis, and their inward normals."""
    turn = 2 * math.pi * np.arange(count) / count
    outward = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(count)])
    return radius * outward, -outward


@given(st.floats(0.0, math.pi / 2), st.floats(0.0, 2 * math.pi))
def test_orientation_of_two_contacts_is_that_of_their_line(angle: float, turn: float) -> None:
    line = np.array([math.sin(angle) * math.cos(turn), math.sin(angle) * math.sin(turn), math.cos(angle)])
    points = np.array([0.3, -0.2, 0.1]) + 0.05 * np.array([line, -line])
    assert orientation(points, UP) == pytest.approx(angle, abs=1e-6)
    assert orientation(points[::-1], -UP) == pytest.approx(angle, abs=1e-6)


@pytest.mark.parametrize("count", [3, 4])
@given(st.floats(0.0, math.pi / 2))
def test_orientation_of_more_is_that_of_their_plane(count: int, angle: float) -> None:
    points = np.array([1.0, 2.0, 3.0]) + ring(count)[0]
    axis = np.array([0.0, math.sin(angle), math.cos(angle)])
    assert orientation(points, axis) == pytest.approx(angle, abs=1e-6)


def test_orientation_of_four_out_of_a_plane_is_that_of_the_nearest_one() -> None:
    points, _ = ring(4)
    points[:, 2] += [0.005, -0.005, 0.005, -0.005]
    assert orientation(points, UP) == pytest.approx(0.0, abs=1e-6)


def test_one_contact_has_no_orientation() -> None:
    assert math.isnan(orientation(np.zeros((1, 3)), UP))


@pytest.mark.parametrize("count", [2, 3, 4])
def test_even_rings_have_no_residual(count: int) -> None:
    points, normals = ring(count)
    found = measure(seen(points, normals), truth(points, normals), contacts(count))
    assert found.force_residual < 1e-15
    assert found.moment_residual < 1e-15
    assert found.orientation == pytest.approx(math.pi / 2 if count == 2 else 0.0, abs=1e-6)


@given(st.floats(0.0, math.pi))
def test_force_residual_of_two_unit_normals(angle: float) -> None:
    points, normals = ring(2)
    normals[1] = [math.cos(angle), math.sin(angle), 0.0]  # contact 0 pushes along -x
    found = measure(seen(points, normals), truth(points, normals), contacts(2))
    assert found.force_residual == pytest.approx(2 * math.sin(angle / 2), abs=1e-12)


@given(st.floats(-0.05, 0.05))
def test_moment_residual_of_an_offset(offset: float) -> None:
    points, normals = ring(2)
    points[1, 2] += offset
    found = measure(seen(points, normals), truth(points, normals), contacts(2))
    assert found.force_residual < 1e-15
    assert found.moment_residual == pytest.approx(abs(offset), abs=1e-15)


def test_virtual_contacts_share_the_weight_of_one() -> None:
    """A thumb against two fingers at its sides: no residual for <γ2, γ3>, a unit of force for three alike."""
    points = np.array([[0.05, 0.0, 0.0], [-0.05, 0.0, 0.03], [-0.05, 0.0, -0.03]])
    normals = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    virtual = measure(seen(points, normals), truth(points, normals), contacts(3, (0,), (1, 2)))
    assert virtual.force_residual < 1e-15
    assert virtual.moment_residual < 1e-15
    assert virtual.orientation == pytest.approx(math.pi / 2)
    alike = measure(seen(points, normals), truth(points, normals), contacts(3))
    assert alike.force_residual == pytest.approx(1.0)


@given(st.floats(0.0, math.pi))
def test_gravity_is_one_more_contact(angle: float) -> None:
    """A finger that pushes at an angle off straight up beneath the centre of mass."""
    points = np.array([[0.0, 0.0, -0.05]])
    normals = np.array([[math.sin(angle), 0.0, math.cos(angle)]])
    grasp = ContactSet("Γ", (ContactResource("γ1", ((0, 1.0),)), ContactResource("γ_g", ((1, 1.0),))), 1)
    found = measure(seen(points, normals), truth(points, normals), grasp)
    assert found.force_residual == pytest.approx(float(np.linalg.norm(normals[0] + DOWN)), abs=1e-12)
    assert found.force_residual == pytest.approx(2 * math.sin(angle / 2), abs=1e-12)
    # About the centroid, each acts at half the distance: ½ d sin, the weight's line passing through both points.
    assert found.moment_residual == pytest.approx(0.025 * math.sin(angle), abs=1e-12)


def test_contacts_that_do_not_touch_count_where_they_are_sensed() -> None:
    points, normals = ring(3)
    known, pointing = points + 0.001, -normals
    known[1] = pointing[1] = np.nan
    found, directions = true_contacts(seen(points, normals), truth(known, pointing))
    assert np.array_equal(found[[0, 2]], known[[0, 2]])
    assert np.array_equal(found[1], points[1])
    assert np.array_equal(directions[1], normals[1])


def test_sensing_errors_are_of_contacts_that_touch() -> None:
    points, normals = ring(3)
    known, pointing = points.copy(), normals.copy()
    known[0] += [0.0, 0.0, 0.002]
    pointing[0] = [-math.cos(0.1), 0.0, math.sin(0.1)]
    known[2] = np.nan
    felt, distances, sines, cosines = sensing_errors(seen(points, normals, [True, False, True]), truth(known, pointing))
    assert felt.tolist() == [True, False, False]
    assert distances[0] == pytest.approx(0.002)
    assert math.atan2(sines[0], cosines[0]) == pytest.approx(0.1)
