"""Starts asked for against starts kept."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest

from graspdsl.report.start_selection import starts_of as starts
from graspdsl.report.summary import plain
from graspdsl.spec.trials import Trials
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import RejectedStart, TrialRecord


def record(number: int, start: dict[str, float], rejected: tuple[RejectedStart, ...] = ()) -> TrialRecord:
    nothing = {name: math.nan for name, kind in TrialRecord.__annotations__.items() if kind == "float"}
    counts = {"ticks": 0, "ticks_to_converge": None, "samples": 0, "world_s": 0.0}
    none = (math.nan, math.nan)
    return TrialRecord(
        **{**nothing, **counts, "number": number, "identity": "", "outcome": Outcome.TIMEOUT, "detail": ""},
        start=start,
        rejected=rejected,
        contact_forces=(),
        point_error=none,
        normal_error=none,
    )


def starts_of(asked: Trials, records: Sequence[TrialRecord]) -> Any:
    """What became of starts, as JSON has it."""
    return plain(starts(asked, records))


def trials(**start: object) -> Trials:
    return Trials.model_validate({"start": start})


def test_quantiles_are_those_of_the_distribution_that_is_asked_for() -> None:
    asked = trials(
        roll={"normal": [0.1, 0.2]}, height={"uniform": [0.06, 0.16]}, yaw={"choice": [0.0, 1.0, 2.0, 3.0]}, offset=0.01
    )
    found = starts_of(asked, [])["parameters"]
    assert found["height"]["asked"] == pytest.approx([0.065, 0.11, 0.155])
    normal = NormalDist(0.1, 0.2)
    assert found["roll"]["asked"] == pytest.approx([normal.inv_cdf(share) for share in (0.05, 0.5, 0.95)])
    assert found["yaw"]["asked"] == [0.0, 1.0, 3.0]
    assert "offset" not in found
    assert found["height"]["kept"] is None


def test_what_is_kept_is_told_with_what_was_not() -> None:
    """Heights drawn evenly over 0 to 1 m, of which the lower half cannot be taken up."""
    random = np.random.default_rng(3)
    records = []
    for number in range(300):
        drawn = [float(random.uniform())]
        while drawn[-1] < 0.5:
            drawn.append(float(random.uniform()))
        rejected = tuple(RejectedStart({"height": height}, "too low") for height in drawn[:-1])
        records.append(record(number, {"height": drawn[-1]}, rejected))
    found = starts_of(trials(height={"uniform": [0.0, 1.0]}), records)
    assert found["kept"] == 300
    assert found["rejected"] == {"too low": found["draws"] - 300}
    assert 500 < found["draws"] < 700
    assert found["parameters"]["height"]["asked"] == pytest.approx([0.05, 0.5, 0.95])
    assert found["parameters"]["height"]["kept"] == pytest.approx([0.525, 0.75, 0.975], abs=0.03)


def test_on_a_grid_its_cells_are_asked_for() -> None:
    grid = Trials.model_validate(
        {"count": 4, "grid": [{"parameter": "roll", "low": 0.0, "high": 4.0, "cells": 4}], "start": {"height": 0.1}}
    )
    found = starts_of(grid, [record(number, {"roll": number + 0.5}) for number in range(4)])["parameters"]
    assert found["roll"]["asked"] == found["roll"]["kept"]
    assert set(found) == {"roll"}
