"""Every mount keeps each rule, and each rule is seen to be broken."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.contracts.mounts import RULES
from graspdsl.contracts.rule import Rule
from graspdsl.diagnostics import DiagnosticError
from graspdsl.hands.descriptions import Mount, Robot, hands, mounts
from graspdsl.hands.mount_files import mounts_in
from graspdsl.spec.sensing import LoadCell
from graspdsl.worlds.real_hand import Reading, RealHand

from .breaking import broken
from .each import each_rule
from .folders import PORTAL, replaced, written_plate

ROLLED = Rotation.from_euler("xyz", [0.0, 0.5, 0.0]).as_matrix()


@each_rule(RULES, "start")
@pytest.mark.parametrize("mount", [*mounts().values(), PORTAL], ids=lambda mount: mount.mount)
def test_it_keeps_the_rule(mount: Mount, rule: Rule[Mount]) -> None:
    assert list(rule(mount)) == []


def portal(old: str, new: str) -> Mount:
    """The portal with another model."""
    return PORTAL.with_model(replaced(PORTAL.model, old, new))


MUTANTS = [
    ("named", PORTAL.model_copy(update={"mount": "a portal"})),
    ("told", PORTAL.model_copy(update={"about": ""})),
    ("model", PORTAL.model_copy(update={"joint_sets": {"rails": ("rail-x", "rail-w")}})),
    ("carries", PORTAL.model_copy(update={"face": "quill"}), "model"),
    ("zero", portal('lower="-0.2"', 'lower="0.1"'), "start"),
    ("names", portal('"carriage-x"', '"tip-1"')),
    ("start", portal('effort="300.0"', 'effort="0.01"')),
]


@pytest.mark.slow
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant[0])
def test_a_rule_is_seen_to_be_broken(mutant: tuple[str, Mount]) -> None:
    code, mount, *others = mutant
    assert broken(RULES, mount) == {f"contract-{name}" for name in (code, *others)}


@pytest.mark.slow
@pytest.mark.parametrize("base", ["", "base: {position: [0.3, 0.0, 0.2], rpy: [0.0, 0.5, 0.0]}\n"])
def test_one_without_joints_keeps_the_rules(base: str, tmp_path: Path) -> None:
    assert broken(RULES, mounts_in(written_plate(tmp_path, base=base))["plate"]) == set()


def test_a_face_that_is_the_root_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DiagnosticError, match="the face foot is the root of the model") as refused:
        mounts_in(written_plate(tmp_path, face="foot"))
    [fault] = refused.value.diagnostics
    assert (fault.code, fault.message[:14]) == ("face-is-root", "plate.yaml:4:7")


def test_a_hand_on_one_without_joints_stands_on_its_base(tmp_path: Path) -> None:
    """Its fingertips are where they are from the root of the hand, which is at the base."""
    base = "base: {position: [0.3, 0.0, 0.2], rpy: [0.0, 0.5, 0.0]}\n"
    mount = mounts_in(written_plate(tmp_path, base=base))["plate"]
    seen = []
    for on, moving, pose in (
        (mount, 0, ()),
        (mounts()["gantry"], len(mounts()["gantry"].joints), (np.array([0.3, 0.0, 0.2]), ROLLED)),
    ):
        hand = RealHand(Robot(hand=hands()["barrett"], mount=on), LoadCell(), *pose)
        joints = np.zeros(moving + len(hands()["barrett"].joints))
        hand.tare([Reading(0.0, joints, np.zeros((3, 6)))])
        seen.append(hand.observe(Reading(1.0, joints, np.zeros((3, 6)))))
    assert np.allclose(seen[0].points, seen[1].points, atol=1e-12)
    assert seen[0].joints.shape == (len(hands()["barrett"].joints),)


def test_every_rule_is() -> None:
    assert {f"contract-{mutant[0]}" for mutant in MUTANTS} == set(RULES)
