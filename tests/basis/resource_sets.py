"""Resource sets over a hand with four contacts, from plain to nested, with gravity, and sets of its joints."""

from __future__ import annotations

from graspdsl.basis.resources import ContactResource, ContactSet, JointSet

from .drawing import JOINTS

CONTACTS = 4
GRAVITY = CONTACTS  # its index, behind those of the contacts


def _set(*members: dict[int, float]) -> ContactSet:
    resources = (ContactResource(f"γ{i + 1}", tuple(member.items())) for i, member in enumerate(members))
    return ContactSet("Γ", tuple(resources), CONTACTS)


def _joints(*joints: int) -> JointSet:
    return JointSet("Γ_k", joints, JOINTS)


PLAIN = _set({0: 1.0}, {1: 1.0}, {2: 1.0}, {3: 1.0})
SOME = _set({2: 1.0}, {0: 1.0})
VIRTUAL = _set({0: 1.0}, {1: 0.5, 2: 0.5})
NESTED = _set({3: 1.0}, {0: 0.5, 1: 0.25, 2: 0.25})

SETS = {"plain": PLAIN, "some": SOME, "virtual": VIRTUAL, "nested": NESTED}
WITH_GRAVITY = {
    "gravity": _set({1: 1.0}, {GRAVITY: 1.0}),
    "virtual and gravity": _set({GRAVITY: 1.0}, {1: 0.5, 3: 0.5}),
    "gravity in a virtual contact": _set({0: 1.0}, {2: 0.5, GRAVITY: 0.5}),
}
JOINT_SETS = {"all joints": _joints(*range(JOINTS)), "some joints": _joints(3, 1), "one joint": _joints(2)}
