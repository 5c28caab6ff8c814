"""What is listed of the tables: whole, with a line each, and no line forgotten."""

from __future__ import annotations

import pytest

from graspdsl.compiler.program import examine_expression
from graspdsl.hands.descriptions import hands, mounts
from graspdsl.notation.parser import parse_expression
from graspdsl.notation.printer import to_ascii
from graspdsl.reference import grammar
from graspdsl.reference.keys import Key, parts
from graspdsl.reference.kinds import KINDS
from graspdsl.spec.monitors import OUTCOMES

NAMED = [(part.place, key) for part in parts() for key in part.keys if key.values]


@pytest.mark.parametrize("kind", KINDS)
def test_rows_of_a_kind_have_the_same_columns_and_a_name_once(kind: str) -> None:
    rows = KINDS[kind].rows()
    assert len({tuple(row) for row in rows}) == 1
    assert {*KINDS[kind].wide} <= {*rows[0]}
    names = [next(iter(row.values())) for row in rows]
    assert len({*names}) == len(names)
    assert all(names)


@pytest.mark.parametrize(("place", "key"), NAMED, ids=lambda each: getattr(each, "name", each))
def test_every_value_that_a_key_may_have_has_its_line(place: str, key: Key) -> None:
    del place
    assert [name for name, line in key.values.items() if not line] == []


def test_values_are_found_with_their_lines() -> None:
    values = {f"{place}.{key.name}": key.values for place, key in NAMED}
    assert list(values["control.displacement"]) == ["sliding", "probing"]
    assert values["trials.start.approach"]["top"] == "from above"
    assert values["monitors.palm"]["stop"] == "at once"
    assert values["trials.grid.parameter"]["roll"].startswith("rotation (rad)")


def test_all_contacts_and_joint_sets_are_listed() -> None:
    rows = {row["name"]: row for kind in ("hands", "mounts") for row in KINDS[kind].rows()}
    for name, hand in hands().items():
        assert rows[name]["contacts"].split(", ") == [*hand.contacts]
    for name, robot in {**hands(), **mounts()}.items():
        assert rows[name]["joint sets"].split(", ") == [*robot.joint_sets] or not robot.joint_sets
        assert all(joint in rows[name]["joints"] for joint in robot.joints)


def test_worlds_that_lack_edges_are_not_those_of_what_has_them() -> None:
    rows = {row["name"]: row["worlds"] for kind in ("objects", "shapes") for row in KINDS[kind].rows()}
    assert (rows["box"], rows["ball"]) == ("bullet, mujoco", "bullet, mujoco, floating")


def test_outcomes_tell_their_monitors() -> None:
    rows = {row["name"]: row for row in KINDS["outcomes"].rows()}
    assert [*rows] == [*OUTCOMES]
    assert (rows["toppled"]["monitor"], rows["timeout"]["monitor"]) == ("lean", "")


@pytest.mark.parametrize("formula", grammar.EXAMPLES)
def test_examples_of_formulas_are_sound_and_spelt_both_ways(formula: str) -> None:
    tree = parse_expression(formula)
    assert parse_expression(to_ascii(tree)) == tree
    examine_expression(formula)


def test_rules_are_those_of_the_parser() -> None:
    found = {rule.name: rule.ebnf for rule in grammar.rules()}
    assert found["chain"] == "term | term (SUBJECT_TO term)+"
    assert found["abbreviation"] == 'ABBREVIATION ("|" arguments arguments reference?)?'
    assert found["scaled"] == "(NUMBER | name)? sensor"
    assert found["POTENTIAL"].startswith('("φ" | "phi")')
    named = {word.strip("()?*+") for text in found.values() if not text.startswith("/") for word in text.split()}
    assert {word for word in named if word.isidentifier()} <= {*found}
