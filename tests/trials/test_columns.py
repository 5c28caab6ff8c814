"""Records as columns: every number of a record has its column, its unit, and the value that it has there."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from graspdsl.compiler.program import Program, program_of
from graspdsl.trials.columns import columns_of
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.priorities import CAUSES, Disturbance, Largest
from graspdsl.trials.record import Balance, RejectedStart, TrialRecord

ROOT = Path(__file__).parents[2]
TOWEL = ROOT / "specs" / "towel_roll_two_contacts.yaml"
GRADED = ("evaluate=[force-closure, ferrari-canny]",)


def record(number: int, **given: object) -> TrialRecord:
    """A record with a value of its own in each field."""
    made: dict[str, object] = {
        field.name: float(place) for place, field in enumerate(dataclasses.fields(TrialRecord), 1)
    }
    made |= {
        "number": number,
        "identity": f"id-{number}",
        "outcome": Outcome.CONVERGED,
        "detail": "",
        "start": {"roll": 0.1, "height": 0.2, "spread-1": 0.3},
        "rejected": (RejectedStart({"roll": 0.0}, "table"),) * 2,
        "contact_forces": (0.4, 0.5, 0.6),
        "touching": (True, False, True),
        "balance": Balance(*(tuple(10.0 * party + part for part in range(6)) for party in range(4))),
        "point_error": (0.01, 0.02),
        "normal_error": (0.03, 0.04),
        "priorities": (
            Disturbance(1, "φ_f", 9, Largest(2e-6, 5, 0.1, CAUSES[0]), Largest(0.3, 7, 0.14, CAUSES[4]), 900.0),
        ),
        "quality": {
            "force-closure": {"closed": True, "margin": {"value": 0.5, "reason": ""}},
            "ferrari-canny": {"epsilon": {"value": 0.7, "reason": ""}, "volume": {"value": None, "reason": "flat"}},
        },
    }
    return TrialRecord(**{**made, **given})


@pytest.fixture(scope="module")
def program() -> Program:
    """A program whose grasps are graded."""
    return program_of(TOWEL.read_text("utf-8"), TOWEL.name, GRADED)


def test_every_field_has_a_column_with_its_values(program: Program) -> None:
    records = [record(0), record(2, outcome=Outcome.TIMEOUT, detail="too slow", ticks_to_converge=None)]
    columns = columns_of(program, records)
    assert {name.partition(".")[0] for name in columns} == {field.name for field in dataclasses.fields(TrialRecord)}
    parted = {"start", "contact_forces", "touching", "point_error", "normal_error", "priorities", "balance", "quality"}
    for name in {field.name for field in dataclasses.fields(TrialRecord)} - parted - {"rejected", "ticks_to_converge"}:
        assert columns[name].values.tolist() == [getattr(one, name) for one in records]
    assert columns["rejected"].values.tolist() == [2, 2]
    np.testing.assert_array_equal(columns["ticks_to_converge"].values, [records[0].ticks_to_converge, math.nan])
    assert columns["outcome"].values.tolist() == ["converged", "timeout"]
    assert columns["detail"].values.tolist() == ["", "too slow"]


def test_parts_have_columns(program: Program) -> None:
    columns = columns_of(
        program, [record(0), record(1, start={}, contact_forces=(), touching=(), quality={}, balance=None)]
    )
    parts = {name: column.values.tolist() for name, column in columns.items() if "." in name}
    nothing = math.nan
    expected = {
        "start.roll": [0.1, nothing],
        "start.height": [0.2, nothing],
        "start.spread-1": [0.3, nothing],
        "contact_forces.finger-3": [0.4, nothing],
        "contact_forces.finger-1": [0.5, nothing],
        "contact_forces.finger-2": [0.6, nothing],
        "touching.finger-3": [1.0, nothing],
        "touching.finger-1": [0.0, nothing],
        "touching.finger-2": [1.0, nothing],
        "point_error.p50": [0.01, 0.01],
        "point_error.p95": [0.02, 0.02],
        "normal_error.p50": [0.03, 0.03],
        "normal_error.p95": [0.04, 0.04],
        **{
            f"balance.{party}.{part}": [10.0 * row + place, nothing]
            for row, party in enumerate(("contacts", "links", "table", "gravity"))
            for place, part in enumerate(("fx", "fy", "fz", "mx", "my", "mz"))
        },
        "priorities.1.φ_fr.predicted": [nothing, nothing],
        "priorities.1.φ_fr.observed": [nothing, nothing],
        "priorities.1.φ_f.predicted": [2e-6, 2e-6],
        "priorities.1.φ_f.observed": [0.3, 0.3],
        "quality.force-closure.closed": [1.0, nothing],
        "quality.ferrari-canny.epsilon": [0.7, nothing],
        "quality.force-closure.margin": [0.5, nothing],
        "quality.ferrari-canny.shortfall": [nothing, nothing],
        "quality.ferrari-canny.volume": [nothing, nothing],
    }
    assert parts.keys() == expected.keys()
    for name, values in expected.items():
        np.testing.assert_array_equal(parts[name], values)


def test_every_number_has_a_unit(program: Program) -> None:
    columns = columns_of(program, [record(0)])
    assert {name for name, column in columns.items() if not column.unit} == {"identity", "outcome", "detail"}
    expected = {"start.roll": "rad", "start.height": "m", "start.spread-1": "rad", "contact_forces.finger-1": "N"}
    expected |= {"balance.contacts.fz": "N", "balance.table.mx": "N·m"}
    expected |= {"priorities.1.φ_f.predicted": "m", "priorities.1.φ_f.observed": "N"}
    assert {name: columns[name].unit for name in expected} == expected


def test_where_phases_control_other_contacts_forces_go_by_place() -> None:
    one = 'program.0.run="π_close|{γ1, γ2} {γ1, γ2}"'
    program = program_of(TOWEL.read_text("utf-8"), TOWEL.name, (one,))
    columns = columns_of(program, [record(0, contact_forces=(0.4, 0.5)), record(1)])
    assert [name for name in columns if name.startswith("contact_forces")] == [
        f"contact_forces.{place}" for place in (1, 2, 3)
    ]
    np.testing.assert_array_equal(columns["contact_forces.3"].values, [math.nan, 0.6])


def test_no_trials_make_empty_columns(program: Program) -> None:
    columns = columns_of(program, [])
    assert {column.values.shape for column in columns.values()} == {(0,)}
    assert columns["outcome"].values.dtype.kind == "U"
    assert columns["ticks"].values.dtype.kind == "i"
