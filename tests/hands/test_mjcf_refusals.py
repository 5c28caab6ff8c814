"""What would change a hand and has no place in it is refused by name, at its line and column."""

from __future__ import annotations

import pytest

from graspdsl.diagnostics import DiagnosticError
from graspdsl.hands.robot_model import robot_model

INERTIAL = '<inertial pos="0 0 0" mass="0.1" diaginertia="1e-4 2e-4 2.5e-4"/>'
JOINT = ("ref", "stiffness")
COMPILER = ("boundmass", "boundinertia", "settotalmass", "coordinate", "inertiafromgeom", "balanceinertia")
INERTIALS = {
    '<inertial pos="0 0 0" diaginertia="1 1 1"/>': "no mass",
    '<inertial pos="0 0 0" mass="0" diaginertia="1 1 1"/><joint/>': "positive",
    '<inertial pos="0 0 0" mass="1" diaginertia="1 1 3"/>': "larger than the others",
    '<inertial pos="0 0 0" mass="1"/>': "0 inertias",
    '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1" fullinertia="1 1 1 0 0 0"/>': "2 inertias",
    '<inertial pos="0 0 0" mass="1" euler="0 0 9" fullinertia="1 1 1 0 0 0"/>': "fullinertia and is turned",
    INERTIAL * 2: "2 <inertial>",
    "<geom size='0.1'/>": "no <inertial>, and geoms that weigh",
    "<geom size='0.1' contype='0' conaffinity='0'/>": "no <inertial>, and geoms that weigh",
    "<geom size='0.1' mass='0'/><frame><geom size='0.1' density='2'/></frame>": "no <inertial>, and geoms that weigh",
    "<geom size='0.1' mass='2' density='0'/>": "no <inertial>, and geoms that weigh",
    "<joint/>": "moves and has no <inertial>",
}
IN_BODY = {
    '<geom type="mesh" mesh="a"/>': "mesh",
    '<geom mesh="a"/>': "its mesh is not read",
    '<geom type="ellipsoid" size="1 1 1"/>': "a geom of type 'ellipsoid' is not read: only sphere",
    '<geom size="big"/>': "its size is 'big'",
    '<geom size="nan"/>': "its size is 'nan'",
    "<geom/>": "its size is ''",
    '<geom size="0_1"/>': "its size is '0_1'",
    '<geom size="1" contype="1.5"/>': "its contype is '1.5'",
    '<geom size="1" conaffinity="4294967296"/>': "its conaffinity is '4294967296'",
    '<geom type="capsule" size="0.1"/>': "its size is '0.1'",
    '<geom size="-1"/>': "not positive",
    '<geom size="1" fromto="0 0 0 0 0 1"/>': "a sphere has no fromto",
    '<geom type="box" size="1" pos="0 0 0" fromto="0 0 0 0 0 1"/>': "a pos and a fromto",
    '<geom type="box" size="1" fromto="0 0 0 0 0 0"/>': "its fromto gives no direction",
    '<geom size="1" quat="1 0 0 0" euler="0 0 0"/>': "turned by quat and euler",
    '<geom size="1" quat="0 0 0 0"/>': "its quat is zero",
    '<geom size="1" axisangle="0 0 0 9"/>': "its axisangle gives no direction",
    '<geom size="1" xyaxes="1 0 0 2 0 0"/>': "its xyaxes gives no direction",
    '<geom size="1" surfacevel="1 0 0"/>': "its surfacevel is not read",
    '<geom size="1" class="none"/>': "no class of defaults 'none'",
    '<geom size="1"><plugin/></geom>': "<plugin> in <geom> is not read",
    '<joint name="a"/><joint name="b"/>': "2 joints",
    '<joint type="ball"/>': "neither a hinge nor a slide",
    '<joint axis="0 0 0"/>': "its axis gives no direction",
    '<joint limited="yes"/>': "its limited is 'yes'",
    '<joint limited="true"/>': "it is limited and has no range",
    '<joint limited="true" range="0 0"/>': "leaves no room: 0.0 0.0",
    '<joint actuatorfrclimited="true"/>': "it is actuatorfrclimited and has no actuatorfrcrange",
    '<joint range="2 1"/>': "leaves no room",
    '<joint damping="-1"/>': "its damping is negative",
    '<joint armature="-1"/>': "its armature is negative",
    '<joint frictionloss="-1"/>': "its frictionloss is negative",
    '<joint armature="much"/>': "its armature is 'much'",
    '<joint actuatorfrcrange="-1 2"/>': "not as strong either way",
    '<joint springdamper="1 1"/>': "its springdamper is not read",
    "<freejoint/>": "<freejoint> in <body> is not read",
    "<composite/>": "<composite> in <body> is not read",
    '<include file="b.xml"/>': "<include> in <body> is not read",
    "<body/>": "no name",
    f'<body name="a">{INERTIAL}</body>': "another body has this name",
    f'<body name="c" childclass="none">{INERTIAL}</body>': "no class of defaults 'none'",
    '<frame pos="1"/>': "its pos is '1'",
    "<frame><replicate/></frame>": "<replicate> in <frame> is not read",
} | {f'<joint {key}="0.1"/>': f"{key}='0.1' would change the hand" for key in JOINT}
BEFORE = {f'<compiler {key}="true"/>': f"{key}='true' would change the hand" for key in COMPILER} | {
    '<compiler angle="gradian"/>': "its angle is 'gradian'",
    '<compiler eulerseq="xy"/>': "its eulerseq is 'xy'",
    '<compiler speed="1"/>': "its speed is not read",
    '<compiler autolimits="false"/><default><joint range="0 1"/></default>': "does not say whether it is limited",
    '<default class="mine"/>': "the outermost class of defaults is called 'mine'",
    "<default><default/></default>": "a class has no name",
    '<default><default class="a"/><default class="a"/></default>': "a class of defaults 'a' already",
    '<default><joint stiffness="1"/></default>': "stiffness='1' would change the hand",
    '<include file="b.xml"/>': "<include> in <mujoco> is not read",
    "<deformable/>": "<deformable> in <mujoco> is not read",
    "<equality><connect/></equality>": "<connect> in <equality> is not read",
    "<contact><pair/></contact>": "<pair> in <contact> is not read",
    '<contact><exclude body1="a" body2="d"/></contact>': "a and d are more than 2 joints apart",
    '<contact><exclude body1="a" body2="z"/></contact>': "no such pair of bodies: a and z",
    '<contact><exclude body1="world" body2="z"/></contact>': "no such pair of bodies: world and z",
    '<default><geom euler="0 0 9"/><default class="q"><geom quat="1 0 0 0"/></default></default>': "a quat and its",
    '<worldbody><geom type="box" size="1 1 1"/></worldbody>': "belongs to the world",
    f'<worldbody><body name="z">{INERTIAL}</body></worldbody>': "the world has 2 bodies",
}

HUGE = {
    f'<body name="e" {turn}>{INERTIAL}</body>': f"its {turn.partition('=')[0]} is"
    for turn in (
        *('quat="1e300 1e300 0 0"', 'euler="1e308 1e308 0"', 'axisangle="0 0 1 1e308"', 'axisangle="1e308 1e308 0 1"'),
        *('xyaxes="1e308 0 0 1e308 1e308 0"', 'zaxis="1e308 1e308 1e308"', 'pos="0 0 1.1e6"', 'pos="1e400 0 0"'),
    )
} | {
    '<geom type="capsule" size=".01" fromto="1e308 0 0 -1e308 0 0"/>': "its fromto is",
    '<geom type="box" size="1e308 1e308 1e308"/>': "its size is",
    '<joint axis="1e200 1e200 1e200"/>': "its axis is",
    '<joint range="-1e308 1e308"/>': "its range is",
    '<joint damping="1e308"/>': "its damping is",
    '<body name="e"><inertial mass="1e308" diaginertia="1 1 1"/></body>': "its mass is",
    '<body name="e"><inertial mass="1" diaginertia="1e308 1e308 1e308"/></body>': "its diaginertia is",
    '<body name="e"><inertial mass="1" fullinertia="1e308 1e308 1e308 1e308 0 0"/></body>': "its fullinertia is",
}


def complaint(text: str) -> str:
    """The one thing that is said of a file."""
    with pytest.raises(DiagnosticError) as caught:
        robot_model(text.encode(), "x.xml", "")
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "not-in-mjcf"
    return diagnostic.message


def within(inside: str, before: str = "") -> str:
    """A file of two lines, the second of which holds what is in the inner body."""
    deep = f'<body name="c2">{INERTIAL}<body name="d">{INERTIAL}</body></body>'
    outer = f'<body name="a">{INERTIAL}<body name="b">\n{inside}{deep}</body></body>'
    return f"<mujoco>{before}<worldbody>{outer}</worldbody></mujoco>"


@pytest.mark.parametrize(("inside", "words"), IN_BODY.items(), ids=IN_BODY)
def test_in_a_body(inside: str, words: str) -> None:
    message = complaint(within(INERTIAL + inside))
    assert words in message
    assert message.startswith(("x.xml:1:", "x.xml:2:"))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("inside", "words"), HUGE.items(), ids=HUGE)
def test_numbers_are_bounded_before_geometry_is_made_of_them(inside: str, words: str) -> None:
    assert words in complaint(within(INERTIAL + inside))


@pytest.mark.parametrize(("inside", "words"), INERTIALS.items(), ids=INERTIALS)
def test_inertias(inside: str, words: str) -> None:
    assert words in complaint(within(inside))


@pytest.mark.parametrize(("before", "words"), BEFORE.items(), ids=BEFORE)
def test_before_the_bodies(before: str, words: str) -> None:
    assert words in complaint(within(INERTIAL + "<joint/>", before))


@pytest.mark.parametrize("key", ["euler", "axisangle", "xyaxes", "zaxis"])
def test_a_quaternion_is_not_mixed_with_another_turn_of_its_class(key: str) -> None:
    """MuJoCo 3.1.6 turns the geom as the class says, 4.0.0 as the geom does; the other way round they agree."""
    before = f'<default><default class="k"><geom type="box" size="1 1 1" {key}="0 0 1"/></default></default>'
    message = complaint(within(f'{INERTIAL}<geom class="k" quat="1 0 0 0"/>', before))
    assert message.startswith(f"x.xml:2:{len(INERTIAL) + 1}: ")
    assert f"a quat and its class a {key}" in message


LATER = {
    '<joint name="j" damping="20000"/>': ("<joint", "the joint j: expected a number from 0 to 10000 as the damping"),
    '<joint name="j" range="-9000 9000"/>': ("<joint", "the joint j: expected a number from -100 to 100 (rad or m)"),
    '<geom type="sphere" size="11"/>': ("<geom", "the link b: expected a number above 0, up to 10 (m) as the radius"),
    '<geom type="sphere" size="1" pos="0 0 11"/>': ("<geom", "the link b: expected three numbers from -10 to 10 (m)"),
    '<body name="e" pos="11 0 0"/>': (
        "<body",
        "the joint e-fixed: expected three numbers from -10 to 10 (m) as the xyz",
    ),
    '<body name="e"><inertial mass="101" diaginertia="1 1 1"/></body>': ("<inertial", "the link e: expected a number"),
}


@pytest.mark.parametrize("inside", LATER)
def test_what_is_found_later_has_the_place_of_its_element(inside: str) -> None:
    at, words = LATER[inside]
    with pytest.raises(DiagnosticError) as caught:
        robot_model(within(INERTIAL + inside).encode(), "x.xml", "")
    column = len(INERTIAL) + inside.index(at) + 1
    for fault in caught.value.diagnostics:
        assert fault.message.startswith(f"x.xml:2:{column}: {words}")


def test_the_place_is_that_of_the_element() -> None:
    assert complaint(within(INERTIAL + "<freejoint/>")).startswith(f"x.xml:2:{len(INERTIAL) + 1}: ")


@pytest.mark.parametrize("joint", ['<joint name="j"/>', '<joint type="free"/>'])
def test_the_outermost_body_has_no_joint(joint: str) -> None:
    text = f'<mujoco><worldbody><body name="a">{INERTIAL}{joint}</body></worldbody></mujoco>'
    assert "the outermost body has a joint" in complaint(text)


def test_two_joints_have_two_names() -> None:
    inner = f'<body name="c">{INERTIAL}<joint name="j"/></body>'
    assert "another joint has this name" in complaint(within(f'{INERTIAL}<joint name="j"/>{inner}'))


def test_a_hint_says_what_would_be_read() -> None:
    with pytest.raises(DiagnosticError) as caught:
        robot_model(within(INERTIAL + '<joint stiffness="0.1"/>').encode(), "x.xml", "")
    assert caught.value.diagnostics[0].hint == 'write stiffness="0", or describe the hand in URDF'
