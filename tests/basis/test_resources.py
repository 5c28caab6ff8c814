"""Weights of physical, virtual and nested virtual contacts (Eq. 4.32)."""

from __future__ import annotations

import numpy as np
import pytest

from graspdsl.basis.resources import ContactResource, ContactSet, JointSet
from graspdsl.contracts.drawing import CONTACTS, JOINT_SETS, JOINTS, NESTED, PLAIN, SETS, SOME, VIRTUAL, WITH_GRAVITY


@pytest.mark.parametrize("resources", [*SETS.values(), *WITH_GRAVITY.values()], ids=[*SETS, *WITH_GRAVITY])
def test_each_row_is_a_mean(resources: ContactSet) -> None:
    np.testing.assert_allclose(resources.matrix.sum(axis=1), 1.0)
    np.testing.assert_array_equal(resources.weights, resources.matrix.sum(axis=0))


def test_matrix_follows_the_order_of_the_set() -> None:
    np.testing.assert_array_equal(SOME.matrix, [[0, 0, 1, 0], [1, 0, 0, 0]])
    assert SOME.contacts == (2, 0)


def test_nested_members_share_their_share() -> None:
    np.testing.assert_array_equal(NESTED.weights, [0.5, 0.25, 0.25, 1.0])
    assert NESTED.contacts == (3, 0, 1, 2)


def test_virtual_contacts_are_told_from_physical_ones() -> None:
    assert [member.is_virtual for member in VIRTUAL.members] == [False, True]
    assert (VIRTUAL.has_virtual, PLAIN.has_virtual) == (True, False)


def test_sameness_is_that_of_the_contacts() -> None:
    again = ContactSet(
        "other", tuple(ContactResource("x", member.weights) for member in reversed(VIRTUAL.members)), VIRTUAL.count
    )
    assert VIRTUAL.same_as(again)
    assert not VIRTUAL.same_as(PLAIN)
    assert not NESTED.same_as(VIRTUAL)


def test_gravity_has_a_column_behind_the_contacts_but_is_none_of_them() -> None:
    gravity = WITH_GRAVITY["gravity"]
    np.testing.assert_array_equal(gravity.matrix, [[0, 1, 0, 0, 0], [0, 0, 0, 0, 1]])
    assert [resources.has_gravity for resources in WITH_GRAVITY.values()] == [True] * len(WITH_GRAVITY)
    assert not any(resources.has_gravity for resources in SETS.values())
    for resources in WITH_GRAVITY.values():
        assert resources.matrix.shape == (len(resources.members), CONTACTS + 1)
        assert resources.weights.shape == (CONTACTS + 1,)
        assert CONTACTS not in resources.contacts


def test_a_held_object_turns_all_but_the_direction_of_gravity() -> None:
    """Points above normals: gravity acts at the centre of mass, which turns, and downwards, which does not."""
    np.testing.assert_array_equal(VIRTUAL.turning, [[1.0, 0.5, 0.5, 0.0]] * 2)
    inside = WITH_GRAVITY["gravity in a virtual contact"]
    np.testing.assert_array_equal(inside.turning, [[1.0, 0.0, 0.5, 0.0, 0.5], [1.0, 0.0, 0.5, 0.0, 0.0]])


def test_what_gravity_leaves_of_a_set_are_its_contacts_and_means_of_them() -> None:
    for resources in SETS.values():
        assert resources.without_gravity == resources
    left = {name: resources.without_gravity.matrix.tolist() for name, resources in WITH_GRAVITY.items()}
    assert left == {
        "gravity": [[0.0, 1.0, 0.0, 0.0]],
        "virtual and gravity": [[0.0, 0.5, 0.0, 0.5]],
        "gravity in a virtual contact": [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
    }
    alone = ContactSet("γ_g", (ContactResource("γ_g", ((CONTACTS, 1.0),)),), CONTACTS)
    assert alone.without_gravity.members == ()


def test_joint_set_picks_its_joints_in_its_order() -> None:
    some = JOINT_SETS["some joints"]
    np.testing.assert_array_equal(some.matrix @ np.arange(JOINTS), [3, 1])
    np.testing.assert_array_equal(some.mask, [0, 1, 0, 1, 0])
    assert [resources.size for resources in JOINT_SETS.values()] == [JOINTS, 2, 1]
    assert NESTED.size == 6


def test_joint_sets_are_the_same_by_their_joints_and_never_contacts() -> None:
    some = JOINT_SETS["some joints"]
    assert some.same_as(JointSet("other", (1, 3), JOINTS))
    assert not some.same_as(JOINT_SETS["one joint"])
    assert not some.same_as(SOME)
    assert not SOME.same_as(some)
