"""What the engine makes of a model that was checked: its joints, masses and axes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graspdsl.hands.descriptions import Robot, mounts
from graspdsl.hands.hand_files import FoundHand, hand_in
from graspdsl.places.files import SpecFolder
from graspdsl.worlds.bullet.engine import pybullet
from graspdsl.worlds.bullet.hand import BulletHand

from .models import HAND, URDF, changed, with_links, write

INERTIAL = (
    '<inertial><mass value="0.01"/><inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial>'
)


@contextmanager
def _in_engine(found: FoundHand) -> Iterator[tuple[Any, int, BulletHand]]:
    robot = Robot(hand=found.hand, mount=mounts()["gantry"])
    engine = pybullet()
    client = engine.connect(engine.DIRECT)
    try:
        pose = np.array([0.0, 0.0, 0.5]), np.array([0.0, 0.0, 0.0, 1.0])
        yield engine, client, BulletHand(engine, client, robot, *pose, 0.4)
    finally:
        engine.disconnect(client)


@pytest.mark.slow
def test_a_long_model_may_stand_on_one_line(tmp_path: Path) -> None:
    """The engine cuts long lines, in the midst of a number."""
    write(tmp_path, with_links(90).replace("\n", " "))
    found = hand_in(SpecFolder(tmp_path), "hand.yaml")
    assert "\n" not in found.hand.model
    with _in_engine(found) as (_, _, hand):
        assert "l89" in hand.link_index


def test_a_link_that_says_nothing_of_its_mass_has_that_of_its_geometry(tmp_path: Path) -> None:
    write(tmp_path, changed(URDF, (INERTIAL, "")))
    found = hand_in(SpecFolder(tmp_path), "hand.yaml")
    assert [warning.code for warning in found.warnings] == ["weighed"]
    assert "tip without <inertial> weigh what their geometry does as water, 4.19 g in all" in found.warnings[0].message
    with _in_engine(found) as (engine, client, hand):
        masses = {name: engine.getDynamicsInfo(hand.body, i, client)[0] for name, i in hand.link_index.items()}
    water = 1000.0 * 4.0 / 3.0 * np.pi * 0.01**3
    assert (masses["tip"], masses["finger"]) == (pytest.approx(water), pytest.approx(0.1))


def test_an_axis_of_any_length_is_a_direction(tmp_path: Path) -> None:
    write(tmp_path, changed(URDF, ('<axis xyz="0 1 0"/>', '<axis xyz="0 3 4"/>')), HAND)
    with _in_engine(hand_in(SpecFolder(tmp_path), "hand.yaml")) as (engine, client, hand):
        axis = engine.getJointInfo(hand.body, hand.joint_index["bend"], client)[13]
    np.testing.assert_allclose(axis, [0.0, 0.6, 0.8], atol=1e-12)


def test_what_the_rules_do_not_know_does_not_reach_the_engine(tmp_path: Path) -> None:
    more = '<gazebo reference="tip"/><transmission/><link name="a" wild="nan"><sensor/></link>'
    joint = '<joint name="c" type="fixed"><parent link="palm"/><child link="a"/><safety_controller k="nan"/></joint>'
    write(tmp_path, changed(URDF, ("</robot>", f"{more}{joint}</robot>")))
    model = hand_in(SpecFolder(tmp_path), "hand.yaml").hand.model
    assert not any(word in model for word in ("gazebo", "transmission", "wild", "sensor", "safety", "nan"))
