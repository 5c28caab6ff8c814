"""Hand files guessed from models: what is known of a hand is found again from its model alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
import yaml

from graspdsl.api.programs import examined
from graspdsl.diagnostics import DiagnosticError, has_errors
from graspdsl.hands.description_files import DescriptionFileError
from graspdsl.hands.descriptions import HERE, hands
from graspdsl.hands.fingertips import EllipsoidTip, SphereTip
from graspdsl.hands.guess import GuessedHand, guessed_hand
from graspdsl.hands.guess_file import hand_text, spec_text
from graspdsl.hands.hand_files import hand_in
from graspdsl.models.reading import model_in, read_model
from graspdsl.places.files import SpecFolder
from hands.models import changed

# One motor closes both fingers of this gripper; its pads are flat, and its palm faces along x.
GRIPPER = """\
<mujoco>
  <worldbody>
    <body name="base">
      <geom type="box" size="0.03 0.06 0.02"/>
      <body name="left" pos="0.03 0.01 0">
        <joint name="squeeze" type="slide" axis="0 1 0" range="0 0.04"/>
        <geom type="box" size="0.03 0.004 0.01" pos="0.03 0 0"/>
      </body>
      <body name="right" pos="0.03 -0.01 0">
        <joint name="other" type="slide" axis="0 -1 0" range="0 0.04"/>
        <geom type="box" size="0.03 0.004 0.01" pos="0.03 0 0"/>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="other" joint2="squeeze"/></equality>
</mujoco>
"""


@pytest.fixture(scope="module")
def gripper() -> GuessedHand:
    return guessed_hand(model_in(GRIPPER.encode(), SpecFolder(Path()), "gripper.xml"))


def test_the_barrett_hand_is_found_in_its_model() -> None:
    """Its fingers, load cells and fingertips, the sign and the lever of each joint, and where its palm is."""
    guess, known = guessed_hand(read_model(SpecFolder(HERE), "barrett.urdf")), hands()["barrett"]
    assert {contact.finger.host for contact in guess.contacts.values()} == {"tip-1", "tip-2", "tip-3"}
    assert guess.contacts["thumb"].finger.host == "tip-3"
    for contact in guess.contacts.values():
        mine = next(each for each in known.contacts.values() if each.link == contact.finger.host)
        assert contact.cell == mine.cell
        assert set(mine.finger) <= set(contact.closers)
        assert isinstance(contact.tip.shape, SphereTip)
        assert contact.tip.shape == mine.sphere
    assert all(guess.joints[name].closes == joint.closes for name, joint in known.joints.items())
    assert guess.joints["base-1"].weight == pytest.approx(known.joints["base-1"].weight, rel=0.5)
    assert guess.face.ahead == pytest.approx([0.0, 0.0, 1.0], abs=0.05)
    above = guess.face.place[2] + (guess.face.palm_surface or 0.0)
    assert above == pytest.approx(known.palm_surface, abs=0.003)


def test_a_gripper_of_one_motor(gripper: GuessedHand) -> None:
    """What follows the motor is coupled, down closes, the palm faces where the fingers point, pads are no balls."""
    assert {name: joint.closes for name, joint in gripper.joints.items()} == {"squeeze": -1}
    assert gripper.couplings == {"other": ("squeeze", 1.0, 0.0)}
    assert gripper.face.ahead == pytest.approx([1.0, 0.0, 0.0], abs=0.05)
    assert gripper.face.place[0] + (gripper.face.palm_surface or 0.0) == pytest.approx(0.03, abs=0.002)
    assert gripper.opening == pytest.approx(2 * (0.01 + 0.04 - 0.004), abs=0.006)
    for contact in gripper.contacts.values():
        shape = contact.tip.shape
        assert isinstance(shape, EllipsoidTip)
        assert np.sort(shape.semi_axes)[0] == pytest.approx(0.004, rel=0.25)


def test_fingertips_of_what_is_only_drawn(tmp_path: Path) -> None:
    """Where nothing of a finger touches, its looks are read, and tell its shape."""
    trimesh.creation.box(extents=(0.06, 0.008, 0.02)).export(tmp_path / "pad.stl")
    box = '<geom type="box" size="0.03 0.004 0.01" pos="0.03 0 0"/>'
    drawn = '<geom type="mesh" mesh="pad" pos="0.03 0 0" contype="0" conaffinity="0"/>'
    mass = '<inertial pos="0.03 0 0" mass="0.05" diaginertia="1e-5 1e-5 1e-5"/>'
    text = GRIPPER.replace(box, mass + drawn).replace("<worldbody>", '<asset><mesh file="pad.stl"/></asset><worldbody>')
    (tmp_path / "gripper.xml").write_text(text, encoding="utf-8")
    for contact in guessed_hand(read_model(SpecFolder(tmp_path), "gripper.xml")).contacts.values():
        shape = contact.tip.shape
        assert isinstance(shape, EllipsoidTip)
        assert np.sort(shape.semi_axes)[0] == pytest.approx(0.004, rel=0.25)


@pytest.mark.parametrize("change", [("", ""), ("squeeze", "on"), ('"right"', '"007"')], ids=["plain", "on", "007"])
def test_what_is_written_validates(change: tuple[str, str], tmp_path: Path) -> None:
    """Hand file and spec, with names that YAML would take for something else."""
    text = GRIPPER.replace(*change) if change[0] else GRIPPER
    (tmp_path / "gripper.xml").write_text(text, encoding="utf-8")
    guess = guessed_hand(read_model(SpecFolder(tmp_path), "gripper.xml"))
    (tmp_path / "mine.yaml").write_text(hand_text(guess, "mine", "mjcf", "gripper.xml", ""), encoding="utf-8")
    (tmp_path / "spec.yaml").write_text(spec_text(guess, "first", "mine.yaml", "bullet"), encoding="utf-8")
    _, examination = examined(tmp_path / "spec.yaml")
    assert not has_errors(examination.diagnostics), examination.diagnostics
    assert examination.program is not None
    hand = examination.program.robot.hand
    assert {contact.cell for contact in hand.contacts.values()} == {"finger-1:cell", "finger-2:cell"}
    assert hand.model.count("<collision>") == 1  # that of the palm: fingertips stand for those of the fingers


def test_what_is_not_known_is_asked_for(tmp_path: Path) -> None:
    """A palm without geometry has no surface: the file says so, and is refused by the name of what it lacks."""
    text = changed(GRIPPER, ('<geom type="box" size="0.03 0.06 0.02"/>', ""))
    (tmp_path / "gripper.xml").write_text(text, encoding="utf-8")
    guess = guessed_hand(read_model(SpecFolder(tmp_path), "gripper.xml"))
    (tmp_path / "mine.yaml").write_text(hand_text(guess, "mine", "mjcf", "gripper.xml", ""), encoding="utf-8")
    with pytest.raises(DescriptionFileError) as refused:
        hand_in(SpecFolder(tmp_path), "mine.yaml")
    (fault,) = refused.value.diagnostics
    assert fault.code == "to-do"
    assert fault.message.startswith("fill in palm_surface: m from palm_centre")
    assert fault.span is not None


def test_what_has_no_two_fingers_is_refused() -> None:
    text = changed(
        GRIPPER, ('<geom type="box" size="0.03 0.004 0.01" pos="0.03 0 0"/>\n      </body>\n    </body>', "")
    )
    text = text[: text.index("</worldbody>")] + "</body></body></worldbody></mujoco>"
    with pytest.raises(DiagnosticError) as refused:
        guessed_hand(model_in(text.encode(), SpecFolder(Path()), "gripper.xml"))
    assert [fault.code for fault in refused.value.diagnostics] == ["no-fingers"]


def test_joints_that_follow_one_another_in_a_circle_go_their_own_ways() -> None:
    again = '<joint joint1="squeeze" joint2="other"/></equality>'
    model = model_in(GRIPPER.replace("</equality>", again).encode(), SpecFolder(Path()), "gripper.xml")
    assert any("squeeze and other follow one another in a circle" in found.message for found in model.warnings)
    assert [*guessed_hand(model).joints] == ["squeeze", "other"]


def test_names_are_read_back_as_text(gripper: GuessedHand) -> None:
    for name in ("true", "123", "1e5"):
        assert yaml.safe_load(hand_text(gripper, name, "mjcf", "gripper.xml", ""))["hand"] == name
        assert yaml.safe_load(spec_text(gripper, name, "hand.yaml", "bullet"))["name"] == name
