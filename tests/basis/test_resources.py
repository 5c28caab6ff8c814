"""Weights of physical, virtual and nested virtual contacts (Eq. 4.32)."""

from __future__ import annotations

import numpy as np
import pytest

from graspdsl.basis.resources import ContactResource, ContactSet

from .resource_sets import NESTED, PLAIN, SETS, SOME, VIRTUAL


@pytest.mark.parametrize("resources", SETS.values(), ids=SETS)
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
