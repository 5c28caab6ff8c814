"""Several joints of one body in the engine: a chain of links, over which neighbours still never touch."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from graspdsl.hands.descriptions import Robot, mounts
from graspdsl.hands.hand_files import hand_in
from graspdsl.places.files import SpecFolder
from graspdsl.worlds.bullet.engine import pybullet
from graspdsl.worlds.bullet.hand import BulletHand

MODEL = """\
<mujoco><worldbody><body name="palm"><geom type="box" size=".03 .03 .01"/>
<body name="finger" pos="0.02 0 .01">
<joint name="x" axis="1 0 0" range="-30 30"/><joint name="y" axis="0 1 0" range="0 60"/>
<joint name="z" axis="0 0 1" range="-30 30"/><geom type="capsule" fromto="0 0 0 0 0 .04" size=".008"/>
<body name="tip" pos="0 0 .05"><geom size=".008"/></body></body></body></worldbody>
<default><motor ctrlrange="-2 2"/></default>
<actuator><motor joint="x"/><motor joint="y"/><motor joint="z"/></actuator></mujoco>
"""
HAND = """\
hand: ball
mjcf: ball.xml
joints: {x: {weight: 10.0}, y: {weight: 10.0, closes: 1}, z: {weight: 10.0}}
contacts: {pad: {link: tip, sphere: {radius: 0.008}}}
"""


def test_links_that_overlap_over_a_chain_of_joints_do_not_push(tmp_path: Path) -> None:
    (tmp_path / "ball.xml").write_text(MODEL, encoding="utf-8")
    (tmp_path / "hand.yaml").write_text(HAND, encoding="utf-8")
    found = hand_in(SpecFolder(tmp_path), "hand.yaml")
    assert found.warnings == ()
    engine = pybullet()
    client = engine.connect(engine.DIRECT)
    try:
        robot = Robot(hand=found.hand, mount=mounts()["gantry"])
        hand = BulletHand(engine, client, robot, np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), 0.4)
        engine.performCollisionDetection(client)
        assert len(engine.getContactPoints(hand.body, hand.body, physicsClientId=client)) == 0
        ends = hand.link_index["palm"], hand.link_index["finger"]
        assert engine.getClosestPoints(hand.body, hand.body, 0.0, *ends, physicsClientId=client)[0][8] < 0.0
    finally:
        engine.disconnect(client)
