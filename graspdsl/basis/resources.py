"""Controller resources: contacts, virtual contacts and gravity as weights; joint sets (Sec. 4.3.2, 4.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array


@dataclass(frozen=True, slots=True)
class ContactResource:
    """One resource γ: a label and its weights over the physical contacts of the hand, by index; they sum to one.

    A physical contact weighs itself by one; a virtual contact is the mean of its members (Eq. 4.32), so members of
    nested virtual contacts share their share. Gravity, γ_g, stands behind the physical contacts: its index is their
    count.
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
        """(m, k): row r averages the contacts of resource r (Eq. 4.32); (m, k + 1) with gravity, its column last."""
        matrix = np.zeros((len(self.members), self.count + self.has_gravity))
        for row, member in enumerate(self.members):
            for contact, weight in member.weights:
                matrix[row, contact] = weight
        return matrix

    @property
    def weights(self) -> Array:
        """(k,): each contact's weight in a sum over the set (Eq. 4.11 with 4.32); (k + 1,) with gravity."""
        total: Array = self.matrix.sum(axis=0)
        return total

    @property
    def shares(self) -> Array:
        """(m,): Σ w² of each resource, the mean of its contacts' forces where each presses with its share w of one."""
        return np.array([sum(weight**2 for _, weight in member.weights) for member in self.members])

    @property
    def turning(self) -> Array:
        """(2, k), (2, k + 1) with gravity: the weights of the points and of the normals that turn with a held object.

        Gravity acts at the object's centre of mass, which turns, and downwards however the object lies.
        """
        normals = self.weights
        normals[self.count :] = 0.0
        return np.stack([self.weights, normals])

    def beside(self, moved: ContactSet) -> Array:
        """(2, k), (2, k + 1) with gravity: the weights in a set whose contacts move, and those in this one."""
        weights = np.zeros((2, len(self.weights)))
        weights[0, : moved.count], weights[1] = moved.weights[: moved.count], self.weights
        return weights

    @property
    def without_gravity(self) -> ContactSet:
        """The set as a sensor that gravity does not reach has it: virtual contacts are means of their other members."""
        if not self.has_gravity:
            return self
        members = []
        for member in self.members:
            kept = [(contact, weight) for contact, weight in member.weights if contact < self.count]
            whole = sum(weight for _, weight in kept)
            if kept:
                shares = tuple((contact, weight / whole) for contact, weight in kept)
                members.append(ContactResource(member.label, shares))
        return ContactSet(f"{self.label} ∖ γ_g", tuple(members), self.count)

    @property
    def contacts(self) -> tuple[int, ...]:
        """The physical contacts in the set, in order of their first mention."""
        mentioned = (contact for member in self.members for contact, _ in member.weights)
        return tuple(dict.fromkeys(contact for contact in mentioned if contact < self.count))

    @property
    def has_gravity(self) -> bool:
        """Whether γ_g is in the set."""
        return any(contact == self.count for member in self.members for contact, _ in member.weights)

    @property
    def size(self) -> int:
        """How many numbers a per-contact reference over the set has."""
        return 3 * len(self.members)

    @property
    def has_virtual(self) -> bool:
        """Whether any resource of the set is a virtual contact."""
        return any(member.is_virtual for member in self.members)

    def same_as(self, other: ContactSet | JointSet) -> bool:
        """Whether both hold the same resources, whatever they are called and in whatever order."""
        if isinstance(other, JointSet):
            return False
        return {member.weights for member in self.members} == {member.weights for member in other.members}


@dataclass(frozen=True, slots=True)
class JointSet:
    """A set of actuated joints, by index into the n joints of the robot, for posture (Sec. 4.3.2)."""

    label: str
    joints: tuple[int, ...]
    count: int

    @property
    def matrix(self) -> Array:
        """(s, n): picks the joints of the set out of all."""
        rows: Array = np.eye(self.count)[list(self.joints)]
        return rows

    @property
    def size(self) -> int:
        """How many numbers a reference over the set has."""
        return len(self.joints)

    def same_as(self, other: ContactSet | JointSet) -> bool:
        """Whether both hold the same joints, whatever they are called and in whatever order."""
        return isinstance(other, JointSet) and set(self.joints) == set(other.joints)

    @property
    def mask(self) -> Array:
        """(n,): one for the joints of the set, else zero."""
        return np.isin(np.arange(self.count), self.joints).astype(float)
