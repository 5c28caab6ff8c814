"""How long the arrows of forces are in a picture of a trial."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graspdsl.trials.replay import LONGEST_FORCE, ORDINARY, force_scale


def rounds_below(scale: float) -> float:
    """The next of the numbers 1, 2, 5, 10, … above one of them."""
    digit = round(scale / 10.0 ** math.floor(math.log10(scale) + 1e-9))
    return scale * {1: 2.0, 2: 2.5, 5: 2.0}[digit]


@given(st.lists(st.floats(1e-6, 1e6), min_size=1, max_size=30))
def test_an_ordinary_force_has_the_longest_arrow_that_a_round_scale_allows(sizes: list[float]) -> None:
    """The scale is 1, 2 or 5 times a power of ten; the next one would be too long."""
    forces = np.array(sizes)[:, None] * np.array([0.6, 0.0, -0.8])
    scale = force_scale(forces)
    ordinary = float(np.percentile(sizes, ORDINARY))
    assert scale * ordinary <= LONGEST_FORCE * (1 + 1e-9)
    assert rounds_below(scale) * ordinary > LONGEST_FORCE * (1 - 1e-9)


@pytest.mark.parametrize(("newtons", "scale"), [(1.0, 0.05), (0.9, 0.05), (1.1, 0.02), (2.5, 0.02), (6.0, 0.005)])
def test_scales_by_hand(newtons: float, scale: float) -> None:
    assert force_scale(np.array([[0.0, 0.0, newtons]])) == pytest.approx(scale)


def test_contacts_that_do_not_touch_and_rare_blows_change_nothing() -> None:
    """Ticks by contacts by axes, as they are stored; one blow in a hundred is no ordinary force."""
    forces = np.zeros((100, 2, 3), dtype=np.float32)
    forces[:, 0, 2] = 2.5
    forces[:50, 1] = np.nan
    assert force_scale(forces) == pytest.approx(0.02)
    forces[3, 0, 2] = 400.0
    assert force_scale(forces) == pytest.approx(0.02)


@pytest.mark.parametrize("forces", [np.zeros((4, 2, 3)), np.full((4, 2, 3), np.nan), np.zeros((0, 2, 3))])
def test_no_force_has_no_scale(forces: np.ndarray) -> None:
    assert force_scale(forces) == 0.0
