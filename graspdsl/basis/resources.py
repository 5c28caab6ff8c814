"""Controller resources: physical contacts and virtual contacts as weights over the physical ones (Sec. 4.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array


@dataclass(frozen=True, slots=True)
class ContactResource:
    """One resource γ: a label and its weights over the physical contacts of the hand, by index; they sum to one.

    A physical contact weighs itself by one; a virtual contact is the mean of its members (Eq. 4.32), so members of
    nested virtual contacts share their share.
    """

    label: str
    weights: tuple[tuple[int, float], ...]

    @property
    def is_virtual(self) -> bool:
        """Whether it stands for more than one physical contact."""
        return len(self.weights) > 1


@dataclass(frozen=True, slots=True)
class ContactSet:
    """A set Γ of m resources over a hand with k physical contacts."""

    label: str
    members: tuple[ContactResource, ...]
    count: int

    @property
    def matrix(self) -> Array:
        """(m, k): row r averages the contacts of resource r (Eq. 4.32)."""
        matrix = np.zeros((len(self.members), self.count))
        for row, member in enumerate(self.members):
            for contact, weight in member.weights:
                matrix[row, contact] = weight
        return matrix

    @property
    def weights(self) -> Array:
        """(k,): each contact's weight in a sum over the set (Eq. 4.11 with 4.32)."""
        total: Array = self.matrix.sum(axis=0)
        return total

    @property
    def contacts(self) -> tuple[int, ...]:
        """The physical contacts in the set, in order of their first mention."""
        return tuple(dict.fromkeys(contact for member in self.members for contact, _ in member.weights))

    @property
    def has_virtual(self) -> bool:
        """Whether any resource of the set is a virtual contact."""
        return any(member.is_virtual for member in self.members)

    def same_as(self, other: ContactSet) -> bool:
        """Whether both hold the same resources, whatever they are called and in whatever order."""
        return {member.weights for member in self.members} == {member.weights for member in other.members}
