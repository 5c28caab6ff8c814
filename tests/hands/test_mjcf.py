"""Hands described in MJCF: every link where the file says, in the engine too."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.hands.hand_files import hand_in
from graspdsl.places.files import SpecFolder
from graspdsl.worlds.bullet.engine import pybullet

INERTIAL = '<inertial pos="0 0 0.01" mass="0.1" diaginertia="1e-4 2e-4 3e-4"/>'
PINCER = f"""\
<mujoco model="pincer"><compiler angle="radian"/>
<default><joint axis="0 1 0"/><default class="slow"><joint range="-0.5 1.5"/></default></default>
<worldbody><body name="palm">{INERTIAL}<geom type="box" size="0.03 0.02 0.01"/>
 <body name="left" pos="0.02 0.01 0.03" quat="0.9553365 0.1477601 0.1477601 0.2089643">{INERTIAL}
  <joint name="bend" type="hinge" class="slow" pos="0 0 -0.01"/>
  <geom type="capsule" fromto="0 0 0 0 0 0.05" size="0.006"/>
  <body name="tip" pos="0 0.005 0.06" quat="0.9238795 0 0.3826834 0">{INERTIAL}
   <joint name="slide" type="slide" axis="0 0 1" range="0 0.02"/><geom type="sphere" size="0.01"/></body></body>
</body></worldbody></mujoco>
"""
HAND = """\
hand: pincer
mjcf: pincer.xml
joints: {bend: {weight: 10.0, closes: 1}, slide: {weight: 1.0}}
contacts: {pad: {link: tip, sphere: {radius: 0.01}}}
"""


@pytest.mark.parametrize(("bend", "slide"), [(0.0, 0.0), (1.1, 0.015), (-0.4, 0.003)])
def test_links_are_where_the_file_says(tmp_path: Path, bend: float, slide: float) -> None:
    """The tip's centre of mass, as the engine has it and worked out by hand."""
    (tmp_path / "pincer.xml").write_text(PINCER, encoding="utf-8")
    (tmp_path / "hand.yaml").write_text(HAND, encoding="utf-8")
    (tmp_path / "pincer.urdf").write_text(hand_in(SpecFolder(tmp_path), "hand.yaml").hand.model, encoding="utf-8")
    pivot = np.array([0.0, 0.0, -0.01])
    left = Rotation.from_quat([0.9553365, 0.1477601, 0.1477601, 0.2089643], scalar_first=True)
    turned = Rotation.from_rotvec([0.0, bend, 0.0])
    tip = Rotation.from_quat([0.9238795, 0.0, 0.3826834, 0.0], scalar_first=True)
    in_left = np.array([0.0, 0.005, 0.06]) + tip.apply([0.0, 0.0, 0.01 + slide])
    expected = np.array([0.02, 0.01, 0.03]) + left.apply(pivot + turned.apply(in_left - pivot))
    engine = pybullet()
    client = engine.connect(engine.DIRECT)
    try:
        body = engine.loadURDF(str(tmp_path / "pincer.urdf"), useFixedBase=True, physicsClientId=client)
        infos = {engine.getJointInfo(body, i, client)[1].decode(): i for i in range(engine.getNumJoints(body, client))}
        for name, place in (("bend", bend), ("slide", slide)):
            engine.resetJointState(body, infos[name], place, 0.0, client)
        state = engine.getLinkState(body, infos["slide"], computeForwardKinematics=True, physicsClientId=client)
        base, _ = engine.getBasePositionAndOrientation(body, client)
    finally:
        engine.disconnect(client)
    np.testing.assert_allclose(np.array(state[0]) - np.array(base) + [0.0, 0.0, 0.01], expected, atol=1e-6)


def test_limits_and_geoms(tmp_path: Path) -> None:
    (tmp_path / "pincer.xml").write_text(PINCER, encoding="utf-8")
    (tmp_path / "hand.yaml").write_text(HAND, encoding="utf-8")
    found = hand_in(SpecFolder(tmp_path), "hand.yaml")
    tree = ElementTree.fromstring(found.hand.model)
    assert found.hand.postures["closed"] == {"bend": 1.5, "slide": 0.0}
    assert [len(link.findall("collision")) for link in tree.findall("link")] == [1, 3, 1]
