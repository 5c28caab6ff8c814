"""Joints of a model that follow others, that have no limits or no room, and those that are no part of the hand."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graspdsl.diagnostics import DiagnosticError, Severity
from graspdsl.hands.description_files import DescriptionFileError
from graspdsl.hands.descriptions import Robot, joint_limits, mounts
from graspdsl.hands.hand_files import hand_in
from graspdsl.models.urdf import MOST_LINKS
from graspdsl.models.urdf_text import urdf_text
from graspdsl.places.files import SpecFolder
from graspdsl.worlds.bullet.engine import pybullet, silenced

from .models import HAND, URDF, changed, model_of, with_links, write

TARGET = 0.5
TICKS = 240
THUMB_LIMIT = '<axis xyz="0 -1 0"/><limit lower="-0.5" upper="1" effort="1" velocity="2"/>'
THUMB = '<joint name="thumb-bend" type="revolute">'
COUPLED = HAND.replace("  thumb-bend: {weight: 10.0, closes: 1}\n", "").replace("[bend, thumb-bend]", "[bend]")
ONE_FINGER = "\n".join(line for line in COUPLED.split("\n") if not line.startswith("  thumb:"))
FOLLOWS = "couplings:\n  thumb-bend: {{follows: bend, ratio: {}}}\n"
RATIO = 0.75


def _urdf(thumb: str, kind: str = "revolute") -> str:
    """The small hand whose thumb's joint is of another kind and says other things."""
    return changed(changed(URDF, (THUMB_LIMIT, thumb)), (THUMB, THUMB.replace("revolute", kind)))


def _complaints(folder: Path, urdf: str, hand: str) -> list[tuple[str, str]]:
    write(folder, urdf, hand)
    try:
        hand_in(SpecFolder(folder), "hand.yaml")
    except DescriptionFileError as error:
        errors = (fault for fault in error.diagnostics if fault.severity is Severity.ERROR)
        return [(fault.code, f"{fault.message} {fault.hint}") for fault in errors]
    return []


@contextmanager
def _loaded(urdf: str, folder: Path) -> Iterator[tuple[Any, int, int, dict[str, int]]]:
    """A model in the engine, and the numbers of its joints."""
    (folder / "model.urdf").write_text(urdf, encoding="utf-8")
    engine = pybullet()
    client = engine.connect(engine.DIRECT)
    try:
        with silenced():
            flags = engine.URDF_USE_INERTIA_FROM_FILE
            body = engine.loadURDF(str(folder / "model.urdf"), useFixedBase=True, flags=flags, physicsClientId=client)
        infos = [engine.getJointInfo(body, joint, client) for joint in range(engine.getNumJoints(body, client))]
        yield engine, client, body, {info[1].decode(): info[0] for info in infos}
    finally:
        engine.disconnect(client)


CONTINUOUS = (
    '<axis xyz="0 -1 0"/>',
    '<axis xyz="0 -1 0"/><limit effort="1" velocity="2"/>',
    '<axis xyz="0 -1 0"/><limit lower="2" upper="-2" effort="1" velocity="2"/>',
)


@pytest.mark.parametrize("thumb", CONTINUOUS)
def test_a_continuous_joint_may_follow_and_moves(thumb: str, tmp_path: Path) -> None:
    urdf = _urdf(thumb, "continuous")
    assert _complaints(tmp_path, urdf, COUPLED + FOLLOWS.format(RATIO)) == []
    with _loaded(urdf_text(model_of(urdf)), tmp_path) as (engine, client, body, at):
        joint = at["thumb-bend"]
        engine.setJointMotorControl2(
            body, joint, engine.POSITION_CONTROL, targetPosition=TARGET, force=1.0, physicsClientId=client
        )
        for _ in range(TICKS):
            engine.stepSimulation(client)
        assert engine.getJointState(body, joint, client)[0] == pytest.approx(TARGET, abs=1e-2)


def test_a_finger_of_followers_is_moved_by_the_joint_they_follow(tmp_path: Path) -> None:
    write(tmp_path, _urdf(CONTINUOUS[0], "continuous"), COUPLED + FOLLOWS.format(RATIO))
    assert hand_in(SpecFolder(tmp_path), "hand.yaml").hand.contacts["thumb"].finger == ("bend",)


def test_a_continuous_joint_is_not_driven(tmp_path: Path) -> None:
    ((code, said),) = _complaints(tmp_path, _urdf(CONTINUOUS[1], "continuous"), HAND)
    assert (code, "thumb-bend has no limits" in said) == ("joint-without-limits", True)


def test_a_slide_without_limits_is_not_led(tmp_path: Path) -> None:
    ((code, _),) = _complaints(tmp_path, _urdf(CONTINUOUS[0], "prismatic"), COUPLED + FOLLOWS.format(RATIO))
    assert code == "joint-without-limits"


MIMIC = '{}<mimic joint="{}" multiplier="{}" offset="{}"/>'
AGREED = (("bend", 0.75, 0.0, 0.75), ("bend", -0.4, 1e-9, -0.4), ("bend", 0.3333, 0.0, 0.33333))
DENIED = (
    ("bend", -1.0, 0.0, 1.0, "thumb-bend is -1 times bend, found 1"),
    ("bend", 0.5, 0.1, 0.5, "thumb-bend is at 0.1 where bend is 0, found 0"),
    ("other", 0.5, 0.0, 0.5, "thumb-bend mimics other in the model, and follows bend here"),
)


@pytest.mark.parametrize(("leader", "multiplier", "offset", "ratio"), AGREED)
def test_a_coupling_may_say_what_the_model_says(
    leader: str, multiplier: float, offset: float, ratio: float, tmp_path: Path
) -> None:
    urdf = _urdf(MIMIC.format(CONTINUOUS[0], leader, multiplier, offset), "continuous")
    assert _complaints(tmp_path, urdf, COUPLED + FOLLOWS.format(ratio)) == []
    assert "mimic" not in hand_in(SpecFolder(tmp_path), "hand.yaml").hand.model


@pytest.mark.parametrize(("leader", "multiplier", "offset", "ratio", "said"), DENIED)
def test_a_coupling_that_denies_what_the_model_says_is_one_complaint(
    leader: str, multiplier: float, offset: float, ratio: float, said: str, tmp_path: Path
) -> None:
    urdf = _urdf(MIMIC.format(CONTINUOUS[0], leader, multiplier, offset), "continuous")
    ((code, message),) = _complaints(tmp_path, urdf, COUPLED + FOLLOWS.format(ratio))
    assert code == "wrong-coupling"
    assert said in message


ADOPTED = ((-0.4, 0.25), (0.5, -0.1))


@pytest.mark.parametrize(("multiplier", "offset"), ADOPTED)
def test_what_a_file_says_nothing_of_follows_as_its_model_says(
    multiplier: float, offset: float, tmp_path: Path
) -> None:
    """The tip of the thumb is where the engine has it in the file's own model with the thumb led as it says."""
    mimic = MIMIC.format(THUMB_LIMIT, "bend", multiplier, offset)
    write(tmp_path, _urdf(mimic), COUPLED)
    hand = hand_in(SpecFolder(tmp_path), "hand.yaml").hand
    assert (hand.couplings["thumb-bend"].follows, hand.couplings["thumb-bend"].ratio) == ("bend", multiplier)
    assert hand.contacts["thumb"].finger == ("bend",)
    poses = []
    for model, thumb in ((_urdf(mimic), multiplier * 0.6 + offset), (hand.model, multiplier * 0.6)):
        with _loaded(model, tmp_path) as (engine, client, body, at):
            engine.resetJointState(body, at["thumb-bend"], thumb, physicsClientId=client)
            state = engine.getLinkState(body, at["thumb-bend"], computeForwardKinematics=True, physicsClientId=client)
            low, high = engine.getJointInfo(body, at["thumb-bend"], client)[8:10]
            assert low <= thumb <= high
            poses.append(np.concatenate(state[4:6]))
    np.testing.assert_allclose(*poses, atol=1e-6)


@pytest.mark.parametrize(("ratio", "code"), [(1.02, "clipped-range"), (1.2, "wrong-coupling")])
def test_a_range_that_is_slightly_too_wide_is_clipped(ratio: float, code: str, tmp_path: Path) -> None:
    write(tmp_path, URDF, COUPLED + FOLLOWS.format(ratio))
    if code == "wrong-coupling":
        with pytest.raises(DescriptionFileError) as caught:
            hand_in(SpecFolder(tmp_path), "hand.yaml")
        assert [fault.code for fault in caught.value.diagnostics] == [code]
        return
    found = hand_in(SpecFolder(tmp_path), "hand.yaml")
    assert [warning.code for warning in found.warnings] == [code]
    assert joint_limits(Robot(hand=found.hand, mount=mounts()["gantry"]))[1][-1] == pytest.approx(1.0 / ratio)
    assert found.hand.postures["closed"]["bend"] == pytest.approx(1.0 / ratio)


def test_limits_that_a_mimic_contradicts_are_passed_over(tmp_path: Path) -> None:
    write(tmp_path, _urdf(MIMIC.format(THUMB_LIMIT, "bend", -1.0, 0.0)), COUPLED)
    found = hand_in(SpecFolder(tmp_path), "hand.yaml")
    assert [warning.code for warning in found.warnings] == ["mimic-beyond-limits"]
    with _loaded(found.hand.model, tmp_path) as (engine, client, body, at):
        assert engine.getJointInfo(body, at["thumb-bend"], client)[8:10] == (-1.0, 0.5)


def test_mimicry_is_followed_through_other_joints_and_either_way(tmp_path: Path) -> None:
    """The driven joint mimics one that the file couples to it: the ratio is one over the multiplier."""
    bend = '<axis xyz="0 1 0"/>'
    urdf = changed(_urdf(CONTINUOUS[0], "continuous"), (bend, MIMIC.format(bend, "thumb-bend", "4", "0")))
    assert _complaints(tmp_path, urdf, COUPLED + FOLLOWS.format(0.25)) == []
    ((code, said),) = _complaints(tmp_path, urdf, COUPLED + FOLLOWS.format(4.0))
    assert (code, "thumb-bend is 0.25 times bend, found 4" in said) == ("wrong-coupling", True)


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_a_joint_without_room_is_fixed_where_it_is(kind: str, tmp_path: Path) -> None:
    place = 0.3
    limit = f'<limit lower="{place}" upper="{place}" effort="1" velocity="1"/>'
    origin = '<origin xyz="-0.03 0 0"/>'
    urdf = _urdf(f'<axis xyz="0.6 0 0.8"/>{limit}', kind)
    urdf = changed(urdf, (origin, '<origin xyz="-0.03 0.01 0.02" rpy="0.4 -0.7 1.1"/>'))
    assert _complaints(tmp_path, urdf, ONE_FINGER) == []
    ((code, said),) = _complaints(tmp_path, urdf, HAND)
    assert (code, "its limits are both 0.3" in said) == ("joint-not-movable", True)
    poses = []
    for model in (urdf, urdf_text(model_of(urdf))):
        with _loaded(model, tmp_path) as (engine, client, body, at):
            engine.resetJointState(body, at["thumb-bend"], place, physicsClientId=client)
            state = engine.getLinkState(body, at["thumb-bend"], computeForwardKinematics=True, physicsClientId=client)
            poses.append((engine.getJointInfo(body, at["thumb-bend"], client)[2], state[4], state[5]))
    (_, position, quaternion), (fixed, place_found, turn_found) = poses
    assert fixed == engine.JOINT_FIXED
    np.testing.assert_allclose(place_found, position, atol=1e-6)
    assert abs(np.dot(turn_found, quaternion)) == pytest.approx(1.0, abs=1e-6)


def _course(urdf: str, folder: Path) -> list[float]:
    """Where a joint that was pushed goes, with no motor on it."""
    with _loaded(urdf, folder) as (engine, client, body, at):
        joint = at["bend"]
        engine.setJointMotorControl2(body, joint, engine.VELOCITY_CONTROL, force=0.0, physicsClientId=client)
        engine.resetJointState(body, joint, 0.0, 1.0, physicsClientId=client)
        places = []
        for _ in range(TICKS // 2):
            engine.stepSimulation(client)
            places.append(engine.getJointState(body, joint, client)[0])
        return places


def test_friction_of_joints_has_no_effect_and_is_one_warning(tmp_path: Path) -> None:
    ends = ('velocity="2"/></joint>\n  <link name="tip">', 'velocity="2"/></joint>\n</robot>')
    urdf = URDF
    for end in ends:
        urdf = changed(urdf, (end, end.replace("</joint>", '<dynamics friction="0.5"/></joint>')))
    write(tmp_path, urdf, HAND)
    (warning,) = hand_in(SpecFolder(tmp_path), "hand.yaml").warnings
    assert (warning.code, "bend and thumb-bend has no effect" in warning.message) == ("no-effect", True)
    course = _course(urdf, tmp_path)
    assert course == _course(URDF, tmp_path)
    assert course[-1] > course[0] > 0.0
    damped = changed(URDF, (ends[0], ends[0].replace("</joint>", '<dynamics damping="0.5"/></joint>')))
    assert _course(damped, tmp_path)[-1] < course[-1]


def test_limits_in_degrees_are_a_warning(tmp_path: Path) -> None:
    limits = 'lower="-0.5" upper="1" effort="1" velocity="2"/></joint>\n  <link name="tip">'
    for wide, count in (('lower="-6.283186" upper="6.283186"', 0), ('lower="-63" upper="80"', 1)):
        write(tmp_path, changed(URDF, (limits, limits.replace('lower="-0.5" upper="1"', wide))), HAND)
        warnings = hand_in(SpecFolder(tmp_path), "hand.yaml").warnings
        assert [warning.code for warning in warnings] == ["beyond-a-turn"] * count
    assert "bend turns from -63 to 80 rad" in warnings[0].message
    assert "lower=-1.1 upper=1.396" in (warnings[0].hint or "")


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_kinds_of_joints_above_the_root_are_nothing_to_the_hand(kind: str, tmp_path: Path) -> None:
    above = f'<link name="world"/><joint name="v" type="{kind}"><parent link="world"/><child link="palm"/></joint>'
    urdf = changed(URDF, ("</robot>", f"{above}</robot>"))
    assert _complaints(tmp_path, urdf, HAND) == []
    ((code, said),) = _complaints(tmp_path, urdf, HAND.replace("root: palm\n", "root: world\n"))
    assert (code, repr(kind) in said) == ("unknown-joint-type", True)


@pytest.mark.parametrize(("root", "hint"), [("", "name the link the hand begins with"), ("palm", "nearer to")])
def test_the_hint_of_too_many_links_knows_of_the_root(root: str, hint: str) -> None:
    with pytest.raises(DiagnosticError) as caught:
        model_of(with_links(MOST_LINKS), root)
    (fault,) = caught.value.diagnostics
    assert hint in (fault.hint or "")
