"""What holds the grasps of a run, from records made by hand."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from graspdsl.compiler.program import Program, program_of
from graspdsl.report.balance import Holding, holding
from graspdsl.report.run_tables import balance_table
from graspdsl.report.summary import plain
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import Balance

from .hand_made import HandMade, evidence

TOWEL = Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml"
MASS = 0.5  # kg
NOTHING = (0.0,) * 6
WEIGHT = (0.0, 0.0, -4.905, 0.0, 0.0, 0.0)
HELD_UP = Balance((0.3, -0.4, 1.0, 0.0, 0.0, 0.01), NOTHING, (-0.3, 0.4, 3.905, 0.0, 0.0, -0.01), WEIGHT)
PUSHED = Balance((0.0, 1.0, -1.0, 0.0, 0.0, 0.0), NOTHING, (0.0, -0.5, 5.905, 0.0, 0.0, 0.0), WEIGHT)


def program(*overrides: str) -> Program:
    return program_of(TOWEL.read_text("utf-8"), TOWEL.name, overrides)


def found(*balances: Balance | None, overrides: tuple[str, ...] = ()) -> Holding:
    """What holds grasps that converged, of which these are the balances."""
    records = evidence(1, [HandMade() for _ in balances]).records
    known = [dataclasses.replace(record, balance=one) for record, one in zip(records, balances, strict=True)]
    lost = dataclasses.replace(known[0], outcome=Outcome.TIMEOUT, balance=PUSHED)
    return holding(program(*overrides), [*known, lost])


def test_what_the_contacts_leave_and_the_table_bears() -> None:
    one = found(HELD_UP, None)
    assert one.trials == 1
    assert list(one.parties) == ["contacts", "table", "gravity"]
    contacts, table = one.parties["contacts"], one.parties["table"]
    assert (contacts.across.median, contacts.up.median, contacts.moment.median) == pytest.approx((0.5, 1.0, 0.01))
    assert (table.across.median, table.up.median) == pytest.approx((0.5, 3.905))
    assert one.acceleration is not None
    assert one.alone is not None
    assert one.acceleration.median == pytest.approx(0.0, abs=1e-12)
    assert one.alone.aside.median == pytest.approx(0.5 / MASS)
    assert one.alone.falling.median == pytest.approx(3.905 / MASS)
    assert one.says == (
        "The contacts leave 0.5 N across and 1 N up on the object; the table holds against them with 0.5 N of "
        "friction, and bears 3.9 N where the weight is 4.91 N. Without the table the object would begin to move aside "
        "at 1 m/s² and to fall at 7.8 m/s²."
    )


def test_the_table_has_a_row_for_all_that_acts() -> None:
    table = balance_table(found(HELD_UP))
    assert [[cell.text for cell in row] for row in table.cells()] == [
        ["contacts of the fingertips", "0.500", "1.000", "10.0"],
        ["the table", "0.500", "3.905", "10.0"],
        ["gravity", "0.000", "-4.905", "0.0"],
        ["together: what is left over", "0.000", "0.000", "0.0"],
    ]
    assert table.note.startswith("The contacts leave 0.5 N across")
    assert balance_table(found(None)).rows == ()


def test_what_is_left_over_accelerates() -> None:
    """0.5 N are left across, of 0.5 kg: 1 m/s², as a median of two with none, half of that."""
    both = found(HELD_UP, PUSHED)
    assert both.acceleration is not None
    assert both.acceleration.median == pytest.approx(0.5)
    assert "0.75 N (0.55 to 0.95) across" in both.says


def test_what_floats_has_its_contacts_alone() -> None:
    afloat = found(Balance((0.03, 0.0, -0.04, 0.0, 0.0, 0.0), *[NOTHING] * 3), overrides=("scene.gravity=0",))
    assert afloat.says == (
        "The contacts leave 0.03 N across and 0.04 N down on the object, and no table holds it: it accelerates at "
        "0.1 m/s²."
    )


@pytest.mark.parametrize(("key", "told"), [("held", "held by the hand"), ("fixed", "fixed to the world")])
def test_what_is_fixed_is_not_said_to_balance(key: str, told: str) -> None:
    bound = found(
        Balance(NOTHING, NOTHING, NOTHING, WEIGHT), overrides=(f"scene.object={{like: towel-roll, {key}: true}}",)
    )
    assert bound.acceleration is None
    left = "less than 0.001 N across and 4.9 N down"
    assert bound.says.startswith(f"The object is {told}: that bears what is left over, {left}.")


def test_of_no_grasp_nothing_is_said() -> None:
    nothing = found(None)
    assert (nothing.trials, nothing.says, plain(nothing)["together"]) == (0, "", None)
