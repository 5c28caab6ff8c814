"""The Barrett hand as the engine holds it, against published numbers."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import joint_limits
from graspdsl.worlds.bullet.hand import BulletHand, rotation_matrix
from graspdsl.worlds.rigid.assembly import joined
from graspdsl.worlds.rigid.neighbours import links_of_hand

from .scenes import JOINTS, ROBOT, lone_hand

FK = json.loads((Path(__file__).parent / "data" / "barrett_fk.json").read_text("utf-8"))
TIP = np.array([0.05, 0.0, 0.0])  # m, in the distal frame
SPHERE = np.array([0.0465, -0.002, 0.0])
HUNDREDTH = 1e-5  # m


def posture(spread: float, *bases: float) -> Array:
    """Joints of the hand, the mount at zero."""
    fingers = {"spread-1": spread, **{f"base-{i}": base for i, base in enumerate(bases, 1)}}
    return np.array([fingers.get(name, 0.0) for name in JOINTS])


def frame(engine: Any, client: int, hand: BulletHand, link: str) -> tuple[Array, Array]:
    """Origin and rotation of a link's frame."""
    state = engine.getLinkState(hand.body, hand.link_index[link], computeForwardKinematics=True, physicsClientId=client)
    return np.array(state[4]), rotation_matrix(state[5])


def test_the_table_is_whole() -> None:
    assert len(FK["rows"]) == 24


def test_forward_kinematics() -> None:
    with lone_hand() as (engine, client, hand):
        for row in FK["rows"]:
            hand.place(posture(row["spread"], *[row["base"]] * 3))
            palm_origin, palm = frame(engine, client, hand, "palm")
            origin, rotation = frame(engine, client, hand, f"distal-{row['finger']}")
            for point, expected in ((TIP, row["tip"]), (SPHERE, row["sphere"])):
                found = palm.T @ (origin + rotation @ point - palm_origin)
                assert np.linalg.norm(found - expected) < HUNDREDTH, row
            assert np.abs(palm.T @ rotation - row["distal_rotation"]).max() < 2e-6, row
            tip_origin, tip_rotation = hand.tip_frames()[row["finger"] - 1]
            centre = tip_origin + tip_rotation @ hand.tips[row["finger"] - 1].centre
            assert np.linalg.norm(palm.T @ (centre - palm_origin) - row["sphere"]) < HUNDREDTH, row


def test_the_hand_stands_where_its_mounting_face_is_put() -> None:
    position, rotation = np.array([0.3, -0.2, 0.5]), Rotation.from_quat([0.5, -0.5, 0.1, 0.7]).as_matrix()
    with lone_hand(position, rotation) as (engine, client, hand):
        hand.place(posture(0.0, 0.0, 0.0, 0.0))
        origin, found = frame(engine, client, hand, "palm")
    assert np.allclose(origin, position, atol=1e-9)
    assert np.allclose(found, rotation, atol=1e-9)


def test_couplings() -> None:
    with lone_hand() as (_, _, hand):
        hand.place(posture(0.7, 0.3, 0.9, 1.8))
        angle = dict(zip(hand.movable_names, hand.all_joints(), strict=True))
    assert angle["spread-1"] == angle["spread-2"] == pytest.approx(0.7)
    for finger, base in ((1, 0.3), (2, 0.9), (3, 1.8)):
        assert angle[f"base-{finger}"] == pytest.approx(base)
        assert angle[f"distal-{finger}"] == pytest.approx(base / 3)


def test_joint_limits() -> None:
    limits = {"spread": np.pi, "base": 2.443, "distal": 0.838}
    with lone_hand() as (engine, client, hand):
        for name in hand.movable_names:
            kind = name.split("-")[0]
            if kind in limits:
                info = engine.getJointInfo(hand.body, hand.joint_index[name], client)
                assert info[8:10] == pytest.approx((0.0, limits[kind]), abs=1e-6), name
    lower, upper = joint_limits(ROBOT)
    assert lower[6:] == (0.0,) * 4
    assert upper[6:] == pytest.approx((np.pi, 2.443, 2.443, 2.443), abs=1e-6)


def test_masses() -> None:
    own = links_of_hand(joined(ROBOT), ROBOT)
    with lone_hand() as (engine, client, hand):
        mass = {name: engine.getDynamicsInfo(hand.body, hand.link_index[name], client)[0] for name in own}
    assert mass["palm"] == pytest.approx(0.506)
    for finger in "123":
        assert mass[f"medial-{finger}"] == pytest.approx(0.062)
        assert mass[f"distal-{finger}"] + mass[f"tip-{finger}"] == pytest.approx(0.041)
    assert mass["proximal-1"] == mass["proximal-2"] == pytest.approx(0.141)
    assert 1.05 < sum(mass.values()) < 1.2


def touching_pairs(engine: Any, client: int, hand: BulletHand) -> set[tuple[str, str]]:
    """Links of the hand that press on each other."""
    engine.performCollisionDetection(client)
    contacts = engine.getContactPoints(hand.body, hand.body, physicsClientId=client)
    return {(hand.link_names.get(c[3], ""), hand.link_names.get(c[4], "")) for c in contacts if c[8] < 0.0}


def test_the_empty_hand_does_not_touch_itself() -> None:
    with lone_hand() as (engine, client, hand):
        flexions = np.linspace(0.0, 1.4, 5)
        for spread, first, third in itertools.product(np.linspace(0.0, np.pi, 5), flexions, flexions):
            hand.place(posture(spread, first, first, third))
            assert not touching_pairs(engine, client, hand), (spread, first, third)


def test_the_empty_hand_closes_without_touching_itself() -> None:
    with lone_hand() as (engine, client, hand):
        for first, third in itertools.product(np.linspace(0.0, 2.443, 7), repeat=2):
            hand.place(posture(0.0, first, first, third))
            assert not touching_pairs(engine, client, hand), (first, third)


def test_fingers_that_cross_do_touch() -> None:
    with lone_hand() as (engine, client, hand):
        hand.place(posture(1.05, 2.04, 2.04, 0.0))
        assert ("tip-1", "tip-2") in touching_pairs(engine, client, hand)
