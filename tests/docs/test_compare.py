"""The page that sets controllers side by side: what its script says is the same is the same, and all else is not."""

from __future__ import annotations

import runpy
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
MADE = runpy.run_path(str(DOCS / "render_compare.py"))
PAGE = (DOCS / "compare.md").read_text("utf-8")
FEW = ("program.0.limit=2",)


def told(lines: list[str]) -> dict[int, list[int]]:
    """By the number of a controller, those that a table says are the same."""
    found: dict[int, list[int]] = {}
    for line in lines:
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 9 and cells[0].isdecimal():
            found[int(cells[0])] = [int(number) for number in cells[-1].split(", ") if number.isdecimal()]
    return found


@pytest.mark.slow
@pytest.mark.parametrize("moving", MADE["MOVING"].values(), ids=MADE["MOVING"])
def test_what_is_said_to_be_the_same_is_so(moving: str, tmp_path: Path) -> None:
    """A small part of the page, at a seed of its own: contacts at every tick, against what the table says."""
    settings = MADE["overrides"]((1.0, 1.2, 1.5), moving, 2, 8123)
    runs = list(MADE["ran"](tmp_path, (*settings, *FEW)))
    said = told(MADE["case"](runs))
    assert set(said) == set(range(1, 8))
    for one, other in combinations(said, 2):
        ways = [[runs[place - 1].folder.trajectory(number)["points"] for number in range(2)] for place in (one, other)]
        same = all(a.shape == b.shape and np.allclose(a, b, atol=1e-8, rtol=0.0) for a, b in zip(*ways, strict=True))
        assert (other in said[one]) == same == (one in said[other])
    assert (said[1] == [2, 6]) == (moving == "{γ1, γ2, γ3}")


def test_the_page_has_every_controller_in_every_case() -> None:
    cases = PAGE.split("\n## ")[1:-1]
    assert len(cases) == 4
    for case in cases:
        said = told(case.splitlines())
        assert len(said) == len(MADE["CONTROLLERS"])
        assert (said[1] == [2, 6]) == ("fixed" not in case)
