"""The page on grades: its table is what its script makes, and numbers are those of the program."""

from __future__ import annotations

import math
import re
import runpy

import numpy as np
import pytest
from quality.grasps import antipodal

from graspdsl.quality.contact_models import PATCH, SoftFinger
from graspdsl.quality.wrench_space import wrench_space

from .pages import DOCS, PAGES

PAGE = PAGES["quality.md"]
SCRIPT = runpy.run_path(str(DOCS / "render_quality.py"))


def test_its_patch_is_that_of_all_soft_fingers() -> None:
    [patch] = re.findall(r"^patch = math.sqrt\((.*)\)$", PAGE, flags=re.M)
    assert math.sqrt(eval(patch)) == pytest.approx(PATCH, rel=1e-12)


@pytest.mark.slow
def test_the_table_is_what_its_script_makes() -> None:
    """A row of it; run docs/render_quality.py where it is not."""
    [row] = SCRIPT["rows"]("2, drawn", (8,))
    assert f"\n{row}\n" in PAGE
    assert PAGE.count("\n| 2, drawn |") == len(SCRIPT["EDGES"])


@pytest.mark.parametrize("torsion", [0.002, 0.04])
def test_its_round_cones_are_those_of_a_closed_form(torsion: float) -> None:
    """Two antipodal soft fingers: ε = min(μ_t / r, μ / √(2 + μ²)), moments over r."""
    space = wrench_space(*antipodal(0.05), SoftFinger(0.5, torsion, 8), length=0.05)
    low, high = SCRIPT["round_cones"](space, 0.02)
    expected = min(torsion / 0.05, 0.5 / np.sqrt(2.25))
    assert low * (1.0 - 1e-9) <= expected <= high * (1.0 + 1e-9)
    assert high - low <= 0.02 * high
