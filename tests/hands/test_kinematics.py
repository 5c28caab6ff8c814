"""Forward kinematics without an engine, against published numbers of the Barrett hand."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from graspdsl.hands.descriptions import robot
from graspdsl.hands.kinematics import fingertips_at, openings_of, reach_of

FK = json.loads((Path(__file__).parents[1] / "worlds" / "data" / "barrett_fk.json").read_text("utf-8"))["rows"]
BARRETT = robot("barrett", "gantry")


@pytest.mark.parametrize("row", FK)
def test_fingertips_are_where_the_table_has_them(row: dict[str, float]) -> None:
    joints = {"spread-1": row["spread"], **{f"base-{finger}": row["base"] for finger in (1, 2, 3)}}
    found = fingertips_at(BARRETT, joints)[int(row["finger"]) - 1]
    assert np.linalg.norm(found - row["sphere"]) < 1e-5


def test_how_wide_the_hand_opens() -> None:
    """Antipodal grasps of round objects, widest 177 mm (diameter: base joint and gap to the palm are published)."""
    gaps = openings_of(BARRETT)
    for diameter in (0.065, 0.10, 0.14, 0.16):
        assert any(gap >= diameter and ahead >= diameter / 2 for gap, ahead in gaps)
    for diameter in (0.182, 0.25):
        assert not any(gap >= diameter and ahead >= diameter / 2 for gap, ahead in gaps)
    assert 0.15 < reach_of(BARRETT) < 0.25
