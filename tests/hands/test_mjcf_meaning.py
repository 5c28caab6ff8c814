"""What a MJCF file says of frames, angles, limits, inertias and defaults, each worked out by hand."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.diagnostics import Severity
from graspdsl.hands.robot_model import RobotModel, robot_model

INERTIAL = '<inertial pos="0 0 0.01" mass="0.1" diaginertia="1e-4 2e-4 2.5e-4"/>'
HALF = np.sqrt(0.5)


def model(inside: str, before: str = "") -> RobotModel:
    """A palm with something in it."""
    body = f'<body name="palm">{INERTIAL}{inside}</body>'
    return robot_model(f"<mujoco>{before}<worldbody>{body}</worldbody></mujoco>".encode(), "x.xml", "")


def found(tree: ElementTree.Element, path: str) -> ElementTree.Element:
    element = tree.find(path)
    assert element is not None
    return element


def numbers(element: ElementTree.Element, key: str) -> Array:
    return np.array([float(word) for word in element.get(key, "").split()])


def turn(element: ElementTree.Element) -> Array:
    """The rotation (3, 3) of an element's origin."""
    matrix: Array = Rotation.from_euler("xyz", numbers(found(element, "origin"), "rpy")).as_matrix()
    return matrix


def place(element: ElementTree.Element) -> Array:
    return numbers(found(element, "origin"), "xyz")


def about(axis: int, degrees: float) -> Array:
    """The rotation (3, 3) about a coordinate axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    u, v = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[u, u], matrix[u, v], matrix[v, u], matrix[v, v] = c, -s, s, c
    return matrix


X, Y, Z = 0, 1, 2
TURNS = {
    'quat="2 2 0 0"': about(X, 90.0),
    'euler="30 -20 50"': about(X, 30.0) @ about(Y, -20.0) @ about(Z, 50.0),
    'euler="30 90 50"': about(X, 30.0) @ about(Y, 90.0) @ about(Z, 50.0),
    'axisangle="0 0 3 90"': about(Z, 90.0),
    'xyaxes="1 1 0 0 1 0"': np.array([[HALF, -HALF, 0.0], [HALF, HALF, 0.0], [0.0, 0.0, 1.0]]),
    'zaxis="0 5 0"': about(X, -90.0),
    'zaxis="1 0 1"': about(Y, 45.0),
    'zaxis="0 0 -1"': about(X, 180.0),
    'zaxis="0 0 1"': np.eye(3),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("text", "expected"), TURNS.items(), ids=TURNS)
def test_every_way_to_turn_a_body_and_a_geom(text: str, expected: Array) -> None:
    body = f'<body name="b" pos="1 2 3" {text}>{INERTIAL}</body>'
    tree = model(f'{body}<geom type="box" size="1 2 3" {text}/>').tree
    np.testing.assert_allclose(turn(found(tree, "joint")), expected, atol=1e-8)
    np.testing.assert_allclose(turn(found(tree, "link/collision")), expected, atol=1e-8)
    np.testing.assert_allclose(place(found(tree, "joint")), [1.0, 2.0, 3.0])


def test_small_letters_turn_about_turned_axes_and_capitals_about_fixed_ones() -> None:
    inside = f'<body name="b" euler="0.3 -0.2 0.5">{INERTIAL}</body>'
    angles = np.degrees([0.3, -0.2, 0.5])
    x, y, z = about(X, angles[0]), about(Y, angles[1]), about(Z, angles[2])
    for sequence, expected in (("xyz", x @ y @ z), ("XYZ", z @ y @ x), ("xYz", y @ x @ z)):
        before = f'<compiler angle="radian"/><compiler eulerseq="{sequence}"/>'
        np.testing.assert_allclose(turn(found(model(inside, before).tree, "joint")), expected, atol=1e-8)


def test_frames_move_bodies_joints_geoms_and_inertias() -> None:
    inner = (
        '<frame pos="0 0.1 0" euler="0 0 90"><joint name="j" pos="0.02 0 0" axis="1 0 0"/>'
        f'<geom type="box" size="1 2 3" pos="0.3 0 0"/>{INERTIAL}<body name="c" pos="0.5 0 0">{INERTIAL}</body></frame>'
    )
    tree = model(f'<frame pos="1 0 0" euler="90 0 0"><body name="b" pos="0 0 2">{inner}</body></frame>').tree
    first, second = tree.findall("joint")
    pivot = np.array([0.0, 0.12, 0.0])  # in b: the frame's origin, and 0.02 along its x axis, which is y
    np.testing.assert_allclose(turn(first), about(X, 90.0), atol=1e-9)
    np.testing.assert_allclose(place(first), [1.0, -2.0, 0.12], atol=1e-9)
    np.testing.assert_allclose(numbers(found(first, "axis"), "xyz"), [0.0, 1.0, 0.0], atol=1e-9)
    link = found(tree, "link[@name='b']")
    np.testing.assert_allclose(place(found(link, "collision")), [0.0, 0.4, 0.0] - pivot, atol=1e-9)
    np.testing.assert_allclose(place(found(link, "inertial")), [0.0, 0.1, 0.01] - pivot, atol=1e-9)
    np.testing.assert_allclose(place(second), [0.0, 0.6, 0.0] - pivot, atol=1e-9)
    np.testing.assert_allclose(turn(second), about(Z, 90.0), atol=1e-9)


def test_a_full_inertia_keeps_its_tensor() -> None:
    inertial = '<inertial pos="0 0 0" mass="0.2" fullinertia="3e-4 2e-4 2.5e-4 5e-5 -4e-5 3e-5"/>'
    link = found(model(f'<body name="b">{inertial}</body>').tree, "link[@name='b']/inertial")
    axes, inertia = turn(link), found(link, "inertia")
    moments = np.diag([float(inertia.get(key, "")) for key in ("ixx", "iyy", "izz")])
    expected = [[3e-4, 5e-5, -4e-5], [5e-5, 2e-4, 3e-5], [-4e-5, 3e-5, 2.5e-4]]
    np.testing.assert_allclose(axes @ moments @ axes.T, expected, atol=1e-11)
    assert [float(inertia.get(key, "")) for key in ("ixy", "ixz", "iyz")] == [0.0, 0.0, 0.0]


ON, OFF = '<compiler autolimits="true"/>', '<compiler autolimits="false"/>'
LIMITS = (
    ("", 'range="-90 180"', (-np.pi / 2, np.pi)),
    (ON, 'range="0 90" limited="auto"', (0.0, np.pi / 2)),
    ("", 'range="0 90" limited="false"', None),
    ("", 'range="0 0" limited="false"', None),
    ("", 'range="0 0"', None),
    ("", "", None),
    (OFF, "", None),
    (OFF, 'range="0 90" limited="true"', (0.0, np.pi / 2)),
    (OFF + ON, 'range="0 90"', (0.0, np.pi / 2)),
    ("", 'type="slide" range="0 0.5"', (0.0, 0.5)),
    ('<compiler angle="radian"/>', 'range="0 0.5"', (0.0, 0.5)),
)


@pytest.mark.parametrize(("before", "joint", "expected"), LIMITS)
def test_limits_count_where_they_are_on(before: str, joint: str, expected: tuple[float, float] | None) -> None:
    hinge = model(f'<body name="b">{INERTIAL}<joint name="j" {joint}/></body>', before).joints["j"]
    assert (hinge.limits is None) == (expected is None)
    if expected is not None:
        np.testing.assert_allclose(hinge.limits, expected, atol=1e-8)


def test_a_joint_has_a_unit_axis_damping_and_strength() -> None:
    joint = '<joint name="j" type="slide" axis="0 3 4" range="0 1" damping="0.7" actuatorfrcrange="-2.5 2.5"/>'
    found_model = model(f'<body name="b">{INERTIAL}{joint}</body>')
    made = found(found_model.tree, "joint")
    np.testing.assert_allclose(numbers(found(made, "axis"), "xyz"), [0.0, 0.6, 0.8])
    assert found(made, "dynamics").get("damping") == "0.7"
    assert found(made, "limit").get("effort") == "2.5"


DEFAULTS = """\
<default class="main"><joint damping="1"/><geom size="0.01 0.02 0.03" euler="0 0 90"/>
<default class="a"><joint damping="2"/><default class="b"><geom type="box"/></default></default>
<default class="c"><joint damping="3"/></default></default><default><joint range="0 1"/></default>"""
DAMPING = (
    ("<body {}>{}</body>", "", 1.0),
    ("<body {}>{}</body>", "class='a'", 2.0),
    ("<body {} childclass='a'>{}</body>", "", 2.0),
    ("<body {} childclass='a'>{}</body>", "class='c'", 3.0),
    ("<frame childclass='b'><body {}>{}</body></frame>", "", 2.0),
    ("<body {} childclass='a'><frame childclass='c'>{}</frame></body>", "", 3.0),
    ("<frame childclass='a'><body {} childclass='main'>{}</body></frame>", "", 1.0),
)


@pytest.mark.parametrize(("around", "own", "expected"), DAMPING)
def test_classes_of_defaults_go_to_what_is_in_a_body_or_frame(around: str, own: str, expected: float) -> None:
    inside = around.format("name='b'", f"{INERTIAL}<joint name='j' {own}/>")
    found_model = model(inside, DEFAULTS)
    assert numbers(found(found_model.tree, "joint/dynamics"), "damping") == expected
    # The second outermost <default> is more of the first, and comes after the classes that began as that.
    assert (found_model.joints["j"].limits is not None) == (expected == 1.0)


def test_a_geom_keeps_of_its_defaults_what_it_does_not_say() -> None:
    link = found(model("<geom class='b' size='0.05' zaxis='0 0 -1'/><geom class='b'/>", DEFAULTS).tree, "link")
    first, second = link.findall("collision")
    np.testing.assert_allclose(numbers(found(first, "geometry/box"), "size"), [0.1, 0.04, 0.06])
    np.testing.assert_allclose(turn(first), about(X, 180.0), atol=1e-9)
    np.testing.assert_allclose(turn(second), about(Z, 90.0), atol=1e-9)


@pytest.mark.parametrize(
    ("before", "inside"),
    [
        ("", ""),
        ("", '<site name="s"/><geom size="0.01" mass="0"/>'),
        ("", '<geom size="0.01" density="0"/>'),
        ("", '<geom size="0.01" mass="0" density="5"/>'),
        ('<default><geom mass="0"/></default>', '<frame><geom size="0.01"/></frame>'),
        ('<compiler inertiafromgeom="false"/>', '<geom size="0.01"/>'),
    ],
)
def test_a_fixed_body_may_be_without_mass(before: str, inside: str) -> None:
    found_model = model(f'<body name="b">{INERTIAL}<joint name="j"/><body name="tip">{inside}</body></body>', before)
    for link, mass in (("tip", 0.0), ("b", 0.1)):
        assert float(found(found_model.tree, f"link[@name='{link}']/inertial/mass").get("value", "")) == mass


def test_geoms_between_two_points() -> None:
    ends = np.array([0.0, 0.0, 0.01]), np.array([0.03, 0.04, 0.13])
    text = " ".join(str(end) for end in np.concatenate(ends))
    geoms = "".join(f'<geom type="{kind}" size="0.01" fromto="{text}"/>' for kind in ("box", "capsule", "cylinder"))
    box, tube, one, other, cylinder = found(model(geoms).tree, "link").findall("collision")
    np.testing.assert_allclose(numbers(found(box, "geometry/box"), "size"), [0.02, 0.02, 0.13])
    for part in (box, tube, cylinder):
        np.testing.assert_allclose(place(part), (ends[0] + ends[1]) / 2, atol=1e-9)
        np.testing.assert_allclose(turn(part)[:, 2], (ends[0] - ends[1]) / 0.13, atol=1e-8)
        # The least turn leaves the axis across z and the direction, here (4, -3, 0) / 5, where it was.
        np.testing.assert_allclose(turn(part) @ [0.8, -0.6, 0.0], [0.8, -0.6, 0.0], atol=1e-8)
    np.testing.assert_allclose([place(one), place(other)], ends, atol=1e-9)


@pytest.mark.parametrize(
    ("masks", "touches"),
    [((1, 1), 1), ((0, 1), 1), ((3, 0), 1), ((0, 0), 0), ((2, 2), 0), ((2**31 - 1, 0), 1), ((-(2**31), -2), 0)],
)
def test_a_geom_touches_what_its_masks_let_it(masks: tuple[int, int], touches: int) -> None:
    link = found(model(f'<geom size="0.1" contype="{masks[0]}" conaffinity="{masks[1]}"/>').tree, "link")
    assert (len(link.findall("collision")), len(link.findall("visual"))) == (touches, 1)


def test_what_changes_nothing_is_left_out() -> None:
    before = (
        '<compiler coordinate="local" meshdir="a" inertiafromgeom="auto" boundmass="0.0" fusestatic="true"/>'
        '<option timestep="0.001"/><visual/><asset><material name="m"/></asset><actuator><motor joint="j"/></actuator>'
        '<contact><exclude body1="palm" body2="c"/>'
        '<exclude body1="world" body2="c"/></contact><equality><joint joint1="j"/></equality>'
    )
    inside = (
        f'<body name="b" gravcomp="0">{INERTIAL}<joint name="j" armature="0" stiffness="0.0" springref="3"/>'
        f'<geom size="0.1" rgba="1 0 0 1" material="m" friction="2" condim="4"/><site name="s"/>'
        f'<body name="c">{INERTIAL}<camera/><light/></body></body>'
    )
    with_all, plain = model(inside, before), model(f'<body name="b">{INERTIAL}<joint name="j"/></body>')
    assert with_all.links == ("palm", "b", "c")
    assert with_all.joints["j"] == plain.joints["j"]


def test_what_joints_are_built_without_is_said_once_of_each_kind() -> None:
    chain = (
        f'<body name="b">{INERTIAL}<joint name="j"/><body name="c">{INERTIAL}<joint name="k" armature="0.02"/>'
        f'<body name="d">\n{INERTIAL}<joint name="l" armature="0.03" frictionloss="0"/></body></body></body>'
    )
    found_model = model(chain, '<default><joint frictionloss="0.5"/></default>')
    plain = model(re.sub(r' (armature|frictionloss)="[^"]*"', "", chain))
    armature, friction, _ = found_model.warnings
    assert [warning.code for warning in found_model.warnings] == ["left-out-of-joints"] * 2 + ["no-effort"]
    assert {warning.severity for warning in found_model.warnings} == {Severity.WARNING}
    assert armature.message.startswith(f"x.xml:2:{len(INERTIAL) + 1}: <joint> l: its armature, 0.03, is left out, ")
    assert "<joint> j: its frictionloss, 0.5, is left out, and that of other joints (1): " in friction.message
    assert [warning.code for warning in plain.warnings] == ["no-effort"]
    assert found_model.with_meshes({}) == plain.with_meshes({})
