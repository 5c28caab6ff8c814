"""All faults of a model and of its hand file are told at once, each once, and none that only follows from another."""

from __future__ import annotations

from pathlib import Path

import pytest

from graspdsl.diagnostics import DiagnosticError
from graspdsl.hands.hand_files import HandFileError, hand_in
from graspdsl.hands.robot_model import robot_model
from graspdsl.places.files import SpecFolder

from .models import HAND, URDF, changed, write

INERTIAL = '<inertial pos="0 0 0" mass="0.1" diaginertia="1e-4 2e-4 2.5e-4"/>'
MJCF = f"""\
<mujoco><compiler speed="1"/><default><joint springdamper="1 1"/></default><deformable/>
<worldbody><geom type="box" size="1 1 1"/><body name="a">{INERTIAL}<geom type="mesh" mesh="m"/>
<body name="b"><inertial mass="1" diaginertia="1 1 3"/><joint name="j" range="2 1"/><geom type="mesh" mesh="n"/>
<body name="c"><joint name="k"/><joint name="z"/><geom size="big"/><composite/>
<body>{INERTIAL}<joint name="k" stiffness="3" ref="2"/><geom size="20"/>
<body name="d"><inertial mass="0.1" diaginertia="1e-9 1e-9 1e-9"/><joint name="m" damping="-1"/></body>
</body></body></body></body></worldbody></mujoco>
"""
SAID = (
    "x.xml:1:9: <compiler>: its speed is not read",
    "x.xml:1:76: <deformable> in <mujoco> is not read",
    "x.xml:2:12: <geom>: it belongs to the world and not to the hand",
    "<geom>: its mesh is not read; and so of 1 more",
    "<joint> j: its springdamper is not read; and so of 2 more",
    "x.xml:3:16: <inertial>: one moment of inertia is larger than the others together",
    "x.xml:4:1: <body> c: the body has 2 joints",
    "x.xml:4:1: <body> c: the body moves and has no <inertial>",
    "x.xml:4:50: <geom>: its size is 'big'",
    "x.xml:4:68: <composite> in <body> is not read",
    "x.xml:5:1: <body>: a body has no name",
    "<joint> k: stiffness='3' would change the hand and is not read",
    "<joint> k: ref='2' would change the hand and is not read",
    "<joint> k: another joint has this name",
    "the link body-3: expected a number above 0, up to 10 (m) as the radius of <sphere>, found '20.0'",
)


def test_all_faults_of_a_mjcf() -> None:
    with pytest.raises(DiagnosticError) as caught:
        robot_model(MJCF.encode(), "x.xml", "")
    messages = [fault.message for fault in caught.value.diagnostics]
    assert [words for words in SAID if not any(words in message for message in messages)] == []
    assert len(messages) == len(SAID)


def test_all_faults_of_a_urdf_its_meshes_and_the_hand_file(tmp_path: Path) -> None:
    urdf = URDF
    for change in (
        ('<inertia ixx="1e-6" iyy="1e-6"', '<inertia ixx="3e-6" iyy="1e-6"'),  # of the tip
        (
            '<inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>\n    <coll',
            "</inertial>\n    <coll",
        ),
        ('<mass value="0.5"/>', '<mass value="-1"/>'),  # of the palm
        ('<box size="0.01 0.01 0.04"/>', '<mesh filename="no.stl"/>'),
        ('<axis xyz="0 -1 0"/>', '<axis xyz="0 0 0"/>'),  # of the thumb
    ):
        urdf = changed(urdf, change)
    hand = changed(HAND, ("palm: palm", "palm: plam")).replace("cell: cell", "cell: sell")
    write(tmp_path, urdf, hand)
    with pytest.raises(HandFileError) as caught:
        hand_in(SpecFolder(tmp_path), "hand.yaml")
    codes = sorted(fault.code for fault in caught.value.diagnostics)
    assert codes == [
        "file-not-found",
        "missing-element",
        "out-of-range",
        "unknown-joint",
        "unknown-link",
        "wrong-inertia",
        "zero-axis",
    ]


def test_all_inertias_and_what_hangs_on_sound_ones() -> None:
    """Of four fingers: one without mass, two with wrong inertias, one whose inertia is about another axis."""
    link = '<link name="{}"><inertial><mass value="{}"/><inertia {}/></inertial></link>'
    joint = (
        '<joint name="j{0}" type="revolute"><parent link="palm"/><child link="{0}"/><axis xyz="0 0 1"/>'
        '<limit lower="0" upper="1" effort="1" velocity="1"/></joint>'
    )
    fingers = {
        "a": ("0", 'ixx="0" iyy="0" izz="0"'),
        "b": ("1", 'ixx="1" iyy="1" izz="3"'),
        "c": ("1", 'ixx="1" iyy="1" izz="1" ixy="2"'),
        "d": ("1", 'ixx="1" iyy="1" izz="0"'),
    }
    inside = "".join(link.format(name, *said) + joint.format(name) for name, said in fingers.items())
    with pytest.raises(DiagnosticError) as caught:
        robot_model(f'<robot name="r"><link name="palm"/>{inside}</robot>'.encode(), "r.urdf", "")
    said = "\n".join(fault.message for fault in caught.value.diagnostics)
    assert len(caught.value.diagnostics) == 4
    for words in (
        "the joint ja moves links without mass",
        "the link b: its principal moments of inertia",
        "the link c: its principal moments of inertia",
        "the joint jd turns links without inertia about its axis",
    ):
        assert words in said


def test_faults_of_elements_are_told_with_those_of_the_tree() -> None:
    urdf = changed(
        changed(URDF, ("</robot>", '<link name="stray"/></robot>')), ('<mass value="0.5"/>', '<mass value="-1"/>')
    )
    with pytest.raises(DiagnosticError) as caught:
        robot_model(urdf.encode(), "two.urdf", "")
    assert [fault.code for fault in caught.value.diagnostics] == ["no-root", "out-of-range"]
