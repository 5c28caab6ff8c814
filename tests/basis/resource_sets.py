"""Resource sets over a hand with four contacts, from plain to nested."""

from __future__ import annotations

from graspdsl.basis.resources import ContactResource, ContactSet

CONTACTS = 4


def _set(*members: dict[int, float]) -> ContactSet:
    resources = (ContactResource(f"γ{i + 1}", tuple(member.items())) for i, member in enumerate(members))
    return ContactSet("Γ", tuple(resources), CONTACTS)


PLAIN = _set({0: 1.0}, {1: 1.0}, {2: 1.0}, {3: 1.0})
SOME = _set({2: 1.0}, {0: 1.0})
VIRTUAL = _set({0: 1.0}, {1: 0.5, 2: 0.5})
NESTED = _set({3: 1.0}, {0: 0.5, 1: 0.25, 2: 0.25})

SETS = {"plain": PLAIN, "some": SOME, "virtual": VIRTUAL, "nested": NESTED}
