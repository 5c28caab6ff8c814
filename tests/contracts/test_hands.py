"""Every hand keeps each rule, and each rule is seen to be broken."""

from __future__ import annotations

import pytest

from graspdsl.contracts.hands import RULES
from graspdsl.contracts.rule import Rule
from graspdsl.hands.descriptions import Hand, Joint, hands
from graspdsl.hands.fingertips import SphereTip

from .breaking import broken
from .each import each_rule
from .folders import JAW, replaced


@each_rule(RULES, "start")
@pytest.mark.parametrize("hand", [*hands().values(), JAW], ids=lambda hand: hand.hand)
def test_it_keeps_the_rule(hand: Hand, rule: Rule[Hand]) -> None:
    assert list(rule(hand)) == []


def jaw(old: str, new: str) -> Hand:
    """The parallel jaw with another model."""
    return JAW.with_model(replaced(JAW.model, old, new))


THUMB = """<link name="thumb"><inertial><mass value="0.01"/>
<inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="thumb-turn" type="revolute"><parent link="palm"/><child link="thumb"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""
FAT = {name: contact.model_copy(update={"sphere": SphereTip(radius=0.05)}) for name, contact in JAW.contacts.items()}

NARROW = jaw("0.07 0.05", "0.012 0.05").model_copy(
    update={"postures": {"open": JAW.postures["open"], "closed": {"slide-left": 0.002, "slide-right": 0.002}}}
)

MUTANTS = [
    ("named", JAW.model_copy(update={"hand": "parallel jaw"})),
    ("told", JAW.model_copy(update={"about": ""})),
    ("model", JAW.model_copy(update={"joint_sets": {"slides": ("slide-left", "slide-up")}})),
    ("fingertips", JAW.model_copy(update={"contacts": FAT})),
    ("postures", JAW.model_copy(update={"postures": {"open": JAW.postures["open"]}}), "strength", "start"),
    (
        "motion",
        jaw("</robot>", THUMB).model_copy(update={"joints": {**JAW.joints, "thumb-turn": Joint(weight=1.0)}}),
    ),
    ("opens", NARROW, "start"),
    ("strength", jaw('effort="60.0"', 'effort="0.2"')),
    ("names", jaw('"jaw-left"', '"slide-1"')),
    ("start", jaw('<box size="0.06 0.16 0.05" />', '<box size="0.06 0.16 0.4" />')),
]


@pytest.mark.slow
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant[0])
def test_a_rule_is_seen_to_be_broken(mutant: tuple[str, Hand]) -> None:
    code, hand, *others = mutant
    assert broken(RULES, hand) == {f"contract-{name}" for name in (code, *others)}


def test_every_rule_is() -> None:
    assert {f"contract-{mutant[0]}" for mutant in MUTANTS} == set(RULES)
