"""Jacobians and strength of fingertips from descriptions alone, against the engine's."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graspdsl.angles import turned_by_angles
from graspdsl.arrays import Array
from graspdsl.compiler.program import program_of
from graspdsl.hands.descriptions import Robot, joint_limits, mounts, robot
from graspdsl.hands.fingertip_motion import FingertipMotion
from graspdsl.hands.hand_files import hand_in
from graspdsl.places.files import SpecFolder
from graspdsl.trials.setup import trial_loop
from graspdsl.worlds.bullet.engine import pybullet, silenced
from graspdsl.worlds.bullet.hand import BulletHand

from .models import HAND, URDF, changed, write

SPEC = Path(__file__).resolve().parents[2] / "specs" / "chapter" / "close.yaml"


@pytest.mark.parametrize("hand", ["barrett", "trio"])
@pytest.mark.parametrize("mount", ["gantry", "wam"])
def test_jacobians_are_those_of_the_engine(hand: str, mount: str) -> None:
    engine, whole = pybullet(), robot(hand, mount)
    with silenced():
        client = engine.connect(engine.DIRECT)
    known = BulletHand(engine, client, whole, np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), 0.4)
    for seed in range(3):
        joints = np.random.default_rng(seed).uniform(0.1, 0.5, len(whole.joints))
        known.place(joints)
        everywhere = known.all_joints()
        engines = [known.jacobians(tip, tip.centre, everywhere) for tip in known.tips]
        for turning, found in enumerate(FingertipMotion(whole).jacobians(joints)):
            np.testing.assert_allclose(found, [pair[turning] for pair in engines], atol=1e-12)
    engine.disconnect(client)


@pytest.mark.parametrize("mount", ["gantry", "wam"])
def test_links_are_where_the_engine_has_them(mount: str) -> None:
    """To its single precision; the Jacobians of any of their points to double."""
    engine, whole = pybullet(), robot("trio", mount)
    with silenced():
        client = engine.connect(engine.DIRECT)
    known = BulletHand(engine, client, whole, np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), 0.4)
    joints, place = np.random.default_rng(4).uniform(0.1, 0.5, len(whole.joints)), np.array([0.01, -0.02, 0.03])
    known.place(joints)
    links = FingertipMotion(whole).links(joints)
    for link, tip, (origin, rotation) in zip(links, known.tips, known.tip_frames(), strict=True):
        np.testing.assert_allclose(link.origin, origin, rtol=0.0, atol=1e-6)
        np.testing.assert_allclose(link.rotation, rotation, rtol=0.0, atol=1e-6)
        engines = known.jacobians(tip, place, known.all_joints())
        for found, known_one in zip(link.jacobians(place), engines, strict=True):
            np.testing.assert_allclose(found, known_one, rtol=0.0, atol=1e-12)
    engine.disconnect(client)


def test_a_palm_may_face_any_way_in_the_frame_of_the_root(tmp_path: Path) -> None:
    """The small hand on a link that is turned and elsewhere: told where its palm faces, it moves as it did."""
    turned, place = turned_by_angles((0.4, -0.7, 1.1)), np.array([0.1, -0.2, 0.3])
    joint = (
        '<joint name="on" type="fixed"><parent link="forearm"/><child link="palm"/><origin xyz="{}" rpy="{}"/></joint>'
    )
    on = joint.format(" ".join(map(str, place)), "0.4 -0.7 1.1")
    robots = []
    for root, urdf, more in (
        ("palm", URDF, ""),
        (
            "forearm",
            changed(URDF, ("</robot>", f'<link name="forearm"/>{on}</robot>')),
            f"palm_normal: {(2 * turned[:, 2]).tolist()}\npalm_across: {(turned[:, 0] + turned[:, 2]).tolist()}\n"
            f"palm_centre: {place.tolist()}\n",
        ),
    ):
        write(tmp_path, urdf, changed(HAND, ("root: palm", f"root: {root}")) + more)
        robots.append(Robot(hand=hand_in(SpecFolder(tmp_path), "hand.yaml").hand, mount=mounts()["gantry"]))
    joints = np.linspace(0.1, 0.8, len(robots[0].joints))
    one, other = (FingertipMotion(robot) for robot in robots)
    np.testing.assert_allclose(one.centres(joints), other.centres(joints), atol=1e-9)
    assert one.reach() == pytest.approx(other.reach())
    assert robots[1].hand.palm == "palm"


def test_strength_is_effort_over_lever() -> None:
    """The base joint's 2 N·m of a Barrett finger, at its shortest lever on the way to closed: 85.5 mm."""
    for press in FingertipMotion(robot("barrett", "gantry")).strongest():
        assert press is not None
        assert press.force == pytest.approx(press.effort / press.lever)
        assert press.joint.startswith("base-")
        assert press.force == pytest.approx(23.4, abs=0.1)


def forces(asked: float) -> Array:
    """The forces of the fingers at the end of a trial that asks for them, on an object that stays."""
    overrides = (
        "scene.object={like: towel-roll, fixed: true}",
        f"parameters.κ_f={asked}",
        "trials.start={roll: 0.2, height: 0.1}",
        "monitors={link: off, palm: off}",
        "program.0.until.hold=5",
    )
    loop = trial_loop(program_of(SPEC.read_text("utf-8"), "close", overrides))
    return np.array(loop.run(0, 2006).record.contact_forces)


@pytest.mark.slow
def test_no_finger_of_the_engine_presses_with_more() -> None:
    """Within it what is asked for is reached; beyond it the fingers stall."""
    np.testing.assert_allclose(forces(10.0), 10.0, rtol=0.01)
    assert forces(50.0).max() < 23.4


@pytest.mark.parametrize("turning", [False, True])
def test_largest_singular_value_ends_at_what_is_enough(turning: bool) -> None:
    motion = FingertipMotion(robot("barrett", "gantry"))
    largest = motion.largest_singular_value(turning, np.inf)
    assert 0.1 < motion.largest_singular_value(turning, 0.1) <= largest
    assert largest == pytest.approx(13.8 if turning else 1.58, rel=0.01)


FK = json.loads((SPEC.parents[2] / "tests" / "worlds" / "data" / "barrett_fk.json").read_text("utf-8"))["rows"]


@pytest.mark.parametrize("mount", ["gantry", "wam"])
@pytest.mark.parametrize("row", FK)
def test_fingertips_are_where_published_numbers_have_them(row: dict[str, Any], mount: str) -> None:
    whole = robot("barrett", mount)
    places = {"spread-1": row["spread"], **{f"base-{finger}": row["base"] for finger in (1, 2, 3)}}
    joints = np.array([places.get(name, 0.3) for name in whole.joints])  # wherever the mount stands
    found = FingertipMotion(whole).centres(joints)[row["finger"] - 1]
    assert np.linalg.norm(found - row["sphere"]) < 1e-5


def test_how_wide_the_hand_opens() -> None:
    """Antipodal grasps of round objects, of which the widest has 177 mm by published numbers."""
    motion = FingertipMotion(robot("barrett", "gantry"))
    gaps = motion.openings()
    for diameter in (0.065, 0.10, 0.14, 0.16):
        assert any(gap >= diameter and ahead >= diameter / 2 for gap, ahead in gaps)
    for diameter in (0.182, 0.25):
        assert not any(gap >= diameter and ahead >= diameter / 2 for gap, ahead in gaps)
    assert 0.10 < motion.reach() < 0.16


@pytest.mark.parametrize("hand", ["barrett", "trio"])
def test_no_fingertip_gets_beyond_the_span(hand: str) -> None:
    whole = robot(hand, "gantry")
    motion, (lower, upper) = FingertipMotion(whole), map(np.array, joint_limits(whole))
    joints = np.random.default_rng(1).uniform(lower, upper, (2000, len(lower)))
    farthest = float(np.linalg.norm(motion.centres(joints), axis=-1).max())
    assert 0.7 * motion.span() < farthest < motion.span()
