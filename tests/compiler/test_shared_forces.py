"""Forces shared within a virtual contact: of what a reference asks for, each member presses its share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from graspdsl.worlds.protocol import Observation

from .observations import CONTACTS, FIRST, SECOND, THUMB, compiled, observation

PRESS = "φ_f|τ_f({0}) σ_f({0}) (0.8 σ_n({0}))"
PAIR = "{γ1, <γ2, γ3>}"
ALIKE = {THUMB: 0.8, FIRST: 0.8, SECOND: 0.8}
HALVES = {THUMB: 0.8, FIRST: 0.4, SECOND: 0.4}


def pressing(forces: Mapping[int, float]) -> Observation:
    """Contacts that press along their normals with these forces [N]."""
    seen = observation()
    sizes = np.array([forces[contact] for contact in range(CONTACTS)])
    return replace(seen, forces=sizes[:, None] * seen.normals)


def error(formula: str, seen: Observation, **control: Any) -> float:
    """The largest distance [N] of a contact's force from its reference."""
    return float(compiled(formula, **control).evaluate(seen).force_error)


@pytest.mark.parametrize("virtual", ["members", "common"])
def test_members_press_their_shares(virtual: str) -> None:
    pair = PRESS.format(PAIR)
    shared = {"virtual": virtual, "virtual_forces": "shared"}
    assert error(pair, pressing(HALVES), **shared) == pytest.approx(0.0, abs=1e-12)
    assert error(pair, pressing(ALIKE), virtual=virtual) == pytest.approx(0.0, abs=1e-12)
    assert error(pair, pressing(ALIKE), **shared) > 0.1
    assert error(pair, pressing(HALVES), virtual=virtual) > 0.1


def test_members_of_members_share_their_share() -> None:
    """0.8 N: half of it from the first, a quarter from each of the other two."""
    formula = PRESS.format("<γ1, <γ2, γ3>>")
    seen = pressing({THUMB: 0.4, FIRST: 0.2, SECOND: 0.2})
    assert error(formula, seen, virtual_forces="shared") == pytest.approx(0.0, abs=1e-12)


def test_a_vector_is_the_force_of_all_members() -> None:
    """Of two fingers side by side, (0, 0, 0.8): shared, they come to it together; alike, each to all of it."""
    formula, seen = "φ_f|τ_f(<γ2, γ3>) σ_f(<γ2, γ3>) (0, 0, 0.8)", observation()
    up = np.broadcast_to([0.0, 0.0, 1.0], (CONTACTS, 3))
    for mode, size in (("shared", 0.4), ("alike", 0.8)):
        met = replace(seen, normals=up, forces=size * up)
        for virtual in ("members", "common"):
            assert error(formula, met, virtual=virtual, virtual_forces=mode) == pytest.approx(0.0, abs=1e-12)


def test_what_opposes_balances() -> None:
    """A thumb against two fingers: at the references the net force is nothing, where alike it is as large as one's."""
    normals = np.zeros((CONTACTS, 3))
    normals[THUMB, 1], normals[[FIRST, SECOND], 1] = -1.0, 1.0
    for mode, net in (("shared", 0.0), ("alike", 0.8)):
        sizes = HALVES if mode == "shared" else ALIKE
        forces = np.array([sizes[contact] for contact in range(CONTACTS)])[:, None] * normals
        seen = replace(observation(), normals=normals, forces=forces)
        assert error(PRESS.format(PAIR), seen, virtual_forces=mode) == pytest.approx(0.0, abs=1e-12)
        assert np.linalg.norm(forces.sum(axis=0)) == pytest.approx(net, abs=1e-12)


def test_only_virtual_contacts_share() -> None:
    formula = PRESS.format("{γ1, γ2, γ3}")
    assert error(formula, pressing(ALIKE), virtual_forces="shared") == pytest.approx(0.0, abs=1e-12)
