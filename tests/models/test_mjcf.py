"""Models in MJCF: every body where MuJoCo itself and Bullet have it, of the masses that MuJoCo gives it."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from graspdsl.diagnostics import DiagnosticError, Severity
from graspdsl.models.joint_kinds import FIXED
from graspdsl.models.model import Frame, Model
from graspdsl.models.reading import model_in, read_model
from graspdsl.models.urdf_text import urdf_text
from graspdsl.places.files import SpecFolder
from graspdsl.worlds.bullet.engine import pybullet, silenced

NOWHERE = SpecFolder(Path("/nowhere"))
HAND = """\
<mujoco model="strange"><compiler angle="degree" eulerseq="zyx" autolimits="true"/>
<option timestep="0.01"/><visual><headlight ambient="1 1 1"/></visual>
<default><geom density="700"/><joint axis="0 1 0" damping="0.1"/>
 <default class="look"><geom contype="0" conaffinity="0" group="2" density="0"/></default>
 <default class="knuckle"><joint range="-20 80"/><geom type="capsule" size="0.006"/></default></default>
<worldbody><light pos="0 0 3"/><geom type="plane" size="1 1 0.1"/><camera name="c" pos="1 1 1"/>
 <body name="ball" pos="0.3 0 0.1"><freejoint/><geom size="0.03"/></body>
 <body name="palm" pos="0.1 0.2 0.3" euler="20 30 -40"><freejoint/>
  <geom type="box" size="0.03 0.02 0.01" pos="0 0 0.01"/><geom class="look" type="sphere" size="0.04"/>
  <site name="s" pos="0 0 0.02"/>
  <body pos="0.02 0.01 0.03" axisangle="1 1 0 40" childclass="knuckle">
   <joint name="bend"/><geom fromto="0 0 0 0.01 0.02 0.04"/>
   <body name="tip" pos="0.01 0.02 0.04" xyaxes="0 1 0 -1 0 0.3">
    <joint pos="0 0 -0.01" axis="1 0 0.5" ref="15"/>
    <geom name="pad" type="ellipsoid" size="0.008 0.009 0.012" euler="10 0 0"/></body></body>
  <frame pos="-0.02 0 0.03" euler="0 0 30">
   <body name="thumb" zaxis="0.1 -0.2 1">
    <inertial pos="0 0 0.01" mass="0.05" fullinertia="2e-5 3e-5 3e-5 1e-6 0 2e-6"/>
    <joint name="swing" axis="1 0 0" range="-30 30"/><joint name="twist" axis="0 0 1" pos="0.002 0 0" range="-40 50"/>
    <joint name="reach" type="slide" axis="0 0 1" range="0 0.02"/>
    <geom type="cylinder" size="0.006 0.02"/></body></frame>
 </body></worldbody>
<equality><joint joint1="twist" joint2="swing" polycoef="0.1 -0.5 0 0 0"/></equality>
<actuator><position joint="bend" kp="3" ctrlrange="-1 1" forcerange="-1.5 1.5"/>
 <motor joint="swing" gear="2" ctrlrange="-3 3"/></actuator>
<sensor><framepos objtype="site" objname="s"/></sensor><keyframe><key ctrl="0 0"/></keyframe>
</mujoco>
"""


def _model(text: str, root: str = "") -> Model:
    return model_in(text.encode(), NOWHERE, "x.xml", root)


def _frames(text: str, places: dict[str, float]) -> dict[str, Frame]:
    """Where MuJoCo has the bodies of a text, whose joints are at places."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for name, place in places.items():
        data.joint(name).qpos[0] = place
    mujoco.mj_kinematics(model, data)
    bodies = [model.body(number) for number in range(model.nbody)]
    return {body.name: Frame(data.xpos[body.id].copy(), data.xmat[body.id].reshape(3, 3)) for body in bodies}


def _in_bullet(model: Model, places: dict[str, float], folder: Path) -> dict[str, Frame]:
    """Where Bullet has the links of the text of a model, in the frame of its root."""
    (folder / "model.urdf").write_text(urdf_text(model), encoding="utf-8")
    engine = pybullet()
    client = engine.connect(engine.DIRECT)
    try:
        with silenced():
            body = engine.loadURDF(str(folder / "model.urdf"), useFixedBase=True, physicsClientId=client)
        infos = [engine.getJointInfo(body, joint, client) for joint in range(engine.getNumJoints(body, client))]
        for info in infos:
            engine.resetJointState(body, info[0], places.get(info[1].decode(), 0.0), physicsClientId=client)
        found = {}
        for info in infos:
            state = engine.getLinkState(body, info[0], computeForwardKinematics=True, physicsClientId=client)
            turned = np.array(engine.getMatrixFromQuaternion(state[5])).reshape(3, 3)
            found[info[12].decode()] = Frame(np.array(state[4]), turned)
    finally:
        engine.disconnect(client)
    return found


@pytest.mark.parametrize("seed", range(4))
def test_links_are_where_mujoco_has_them(seed: int, tmp_path: Path) -> None:
    """In Bullet too, whatever joints, frames and references the file has."""
    model = _model(HAND)
    draw = np.random.default_rng(seed)
    moving = [name for name, joint in model.joints.items() if joint.kind != FIXED]
    assert moving == ["bend", "tip-joint", "swing", "twist", "reach"]
    places = {name: draw.uniform(*(model.joints[name].limits or (-0.3, 0.3))) for name in moving}
    named = HAND.replace('<body pos="0.02', '<body name="body-1" pos="0.02').replace(
        '<joint pos="0 0 -0.01"', '<joint name="tip-joint" pos="0 0 -0.01"'
    )
    expected, found = _frames(named, places), _in_bullet(model, places, tmp_path)
    palm = expected["palm"].inverse()
    for name in ("body-1", "tip", "thumb"):
        own = palm.then(expected[name])
        np.testing.assert_allclose(found[name].place, own.place, atol=1e-6)
        np.testing.assert_allclose(found[name].rotation, own.rotation, atol=1e-6)


def test_masses_are_those_of_mujoco() -> None:
    model, given = _model(HAND), mujoco.MjModel.from_xml_string(HAND)
    for name, parts in (("palm", ["palm"]), ("tip", ["tip", "tip-at-tip-joint"])):
        assert sum(model.links[part].mass for part in parts) == pytest.approx(float(given.body(name).mass[0]))
    thumb = [link for name, link in model.links.items() if name.startswith("thumb")]
    assert sum(link.mass for link in thumb) == pytest.approx(0.05)
    moments = sum(np.linalg.eigvalsh(link.inertia) for link in thumb)
    np.testing.assert_allclose(np.sort(moments), np.sort(given.body("thumb").inertia), rtol=1e-6)


def test_what_the_file_says_of_joints_and_geoms() -> None:
    model = _model(HAND)
    assert (model.root, "ball" in model.links) == ("palm", False)
    np.testing.assert_allclose(model.joints["bend"].limits or (), np.radians([-20, 80]))
    assert model.joints["bend"].damping == 0.1
    assert [model.joints[name].effort for name in ("bend", "swing", "reach")] == [1.5, 6.0, 0.0]
    mimic = model.joints["twist"].mimic
    assert mimic is not None
    assert (mimic.joint, mimic.multiplier, mimic.offset) == ("swing", -0.5, 0.1)
    (pad,) = model.links["tip"].solids
    assert (pad.kind, pad.sizes, pad.touches, pad.seen) == ("ellipsoid", (0.008, 0.009, 0.012), True, True)
    assert [(solid.kind, solid.touches, solid.seen) for solid in model.links["palm"].solids] == [
        ("box", True, False),
        ("sphere", False, True),
    ]


def test_a_model_that_is_read_again_is_the_same() -> None:
    once = _model(HAND)
    again = model_in(urdf_text(once).encode(), SpecFolder(Path("/")), "/x.urdf")
    assert (list(again.links), list(again.joints)) == (list(once.links), list(once.joints))
    for name, link in once.links.items():
        np.testing.assert_allclose(again.links[name].inertia, link.inertia, atol=1e-15)
        np.testing.assert_allclose(again.links[name].centre, link.centre, atol=1e-12)
    for name, joint in once.joints.items():
        np.testing.assert_allclose(again.joints[name].frame.rotation, joint.frame.rotation, atol=1e-11)
        np.testing.assert_allclose(again.joints[name].frame.place, joint.frame.place, atol=1e-11)
        assert again.joints[name].limits == joint.limits


TWO = (
    '<body name="{0}"><geom size="0.01"/>'
    '<body name="{0}f"><joint name="{0}j" range="0 90"/><geom size="0.01"/></body></body>'
)
WORLD = "<mujoco><worldbody>{}</worldbody>{}</mujoco>"


def test_of_several_robots_a_root_names_one() -> None:
    text = WORLD.format(TWO.format("a") + TWO.format("b"), "")
    with pytest.raises(DiagnosticError) as caught:
        _model(text)
    (fault,) = caught.value.diagnostics
    assert (fault.code, "a and b" in fault.message) == ("no-root", True)
    assert list(_model(text, "b").links) == ["b", "bf"]
    assert list(_model(text, "world").joints) == ["a-fixed", "aj", "b-fixed", "bj"]
    driven = text.replace("</mujoco>", '<actuator><motor joint="bj"/></actuator></mujoco>')
    assert _model(driven).root == "b"  # the other is a thing of the scene


def test_an_outermost_body_with_joints_hangs_on_a_base() -> None:
    model = _model(WORLD.format('<body name="a"><joint name="j" range="0 90"/><geom size="0.01"/></body>', ""))
    assert (model.root, model.joints["j"].parent, model.joints["j"].child) == ("a-base", "a-base", "a")


CHAIN = (
    '<body name="p"><geom size=".01"/><body name="a"><joint name="j" range="0 90"/><geom size=".01"/>'
    '<body name="b"><joint name="k" range="0 90"/><geom size=".01"/></body></body></body>'
)
JOINTS = '<joint joint="j" coef="{}"/><joint joint="k" coef="{}"/>'
FIXED_TENDON = '<tendon><fixed name="t">{}</fixed></tendon>'
PULLED = '<actuator><motor tendon="t" ctrlrange="-2 2"/></actuator>'
HELD = '<equality><tendon tendon1="t" polycoef="0.2 0 0 0 0"/></equality>'
FOLLOWING = {
    "pulled as one": (FIXED_TENDON.format(JOINTS.format(1, 1)) + PULLED, ("j", 1.0, 0.0), ["tendon-coupled"]),
    "pulled against": (FIXED_TENDON.format(JOINTS.format(1, -0.5)) + PULLED, ("j", -0.5, 0.0), ["tendon-coupled"]),
    "held": (FIXED_TENDON.format(JOINTS.format(1, -2)) + HELD, ("j", 0.5, -0.1), []),
    "pulled and held": (
        FIXED_TENDON.format(JOINTS.format(0.5, 0.5)) + PULLED + '<equality><joint joint1="k" joint2="j"/></equality>',
        ("j", 1.0, 0.0),
        [],
    ),
    "a spring": (FIXED_TENDON.format(JOINTS.format(1, 1)), None, []),
    "by a curve": ('<equality><joint joint1="k" joint2="j" polycoef="0 1 1 0 0"/></equality>', None, ["left-out"]),
    "held nowhere": ('<equality><joint joint1="k" polycoef="0 1 0 0 0"/></equality>', None, ["left-out"]),
    "not active": ('<equality><joint joint1="k" joint2="j" active="false"/></equality>', None, []),
    "a loop without motors": (
        '<equality><connect body1="b" body2="p" anchor="0 0 0"/></equality>',
        None,
        ["left-out"],
    ),
}


@pytest.mark.parametrize("name", FOLLOWING)
def test_joints_that_follow(name: str) -> None:
    more, expected, codes = FOLLOWING[name]
    model = _model(WORLD.format(CHAIN, more))
    mimic = model.joints["k"].mimic
    assert (None if mimic is None else (mimic.joint, mimic.multiplier, mimic.offset)) == expected
    assert [found.code for found in model.warnings if found.code != "no-effort"] == codes
    assert all(found.severity is Severity.WARNING for found in model.warnings)


def test_joints_of_a_loop_follow_its_driven_joint_as_they_do_when_it_moves() -> None:
    """A parallelogram: the rocker turns as the crank does, and the coupler turns back by as much."""
    bar = '<geom type="capsule" fromto="0 0 0 {}" size=".002" contype="0" conaffinity="0"/>'
    coupler = f'<body name="c" pos="0 0 .05"><joint name="k" axis="0 1 0"/>{bar.format(".04 0 0")}</body>'
    crank = f'<body name="a"><joint name="j" axis="0 1 0" range="0 60"/>{bar.format("0 0 .05")}{coupler}</body>'
    rocker = f'<body name="r" pos=".04 0 0"><joint name="l" axis="0 1 0"/>{bar.format("0 0 .05")}</body>'
    base = f'<body name="p"><geom size=".01"/>{crank}{rocker}</body>'
    loop = '<equality><connect body1="c" body2="r" anchor=".04 0 0"/></equality>'
    model = _model(WORLD.format(base, loop + '<actuator><motor joint="j" ctrlrange="-1 1"/></actuator>'))
    followed = {name: joint.mimic for name, joint in model.joints.items() if joint.mimic is not None}
    assert {name: mimic.joint for name, mimic in followed.items()} == {"k": "j", "l": "j"}
    for name, ratio in (("k", -1.0), ("l", 1.0)):
        assert followed[name].multiplier == pytest.approx(ratio, abs=1e-3)
        assert followed[name].offset == pytest.approx(0.0, abs=1e-3)
    assert [found.code for found in model.warnings] == ["loop-coupled"] * 2


BODY = '<mujoco>\n<worldbody>\n<body name="a"><geom size=".01"/>\n{}\n</body></worldbody>{}</mujoco>'
REFUSED = {
    "a number that is none": ('<geom size=".01" pos="0 nan 0"/>', "", "not-a-number", "x.xml:4:1: the pos of <geom>"),
    "a word": ('<geom size="big"/>', "", "bad-model", "x.xml:4:1: bad format in attribute 'size'"),
    "a kind": ('<geom type="cone" size="1"/>', "", "bad-model", "x.xml:4:1: invalid keyword: 'cone'"),
    "an element": ("<wheel/>", "", "bad-model", "x.xml:4:1: Schema violation: unrecognized element"),
    "a class": ('<geom class="no" size=".1"/>', "", "bad-model", "x.xml:4:1: unknown default class name 'no'"),
    "a name twice": ('<body name="a"/>', "", "bad-model", "x.xml:4:1: repeated name 'a' in body"),
    "another model": (
        '<attach model="m" prefix="p"/>',
        '<asset><model name="m" file="x.xml"/></asset>',
        "not-a-body",
        "x.xml:4:1: what another model has is not attached",
    ),
    "a mass of copies": (
        '<replicate count="100" offset="1 0 0"><replicate count="20" offset="0 1 0"><geom size=".01"/></replicate>'
        "</replicate>",
        "",
        "file-too-large",
        "x.xml:4:39: <replicate> makes 2000 copies",
    ),
    "a ball": (
        '<body name="b"><joint name="j" type="ball"/><geom size=".01"/></body>',
        "",
        "unknown-joint-type",
        ":4:16",
    ),
    "limits": (
        '<body><joint name="j" range="2 1"/><geom size=".01"/></body>',
        "",
        "out-of-range",
        "leave no room: 2 to 1",
    ),
    "a mesh": (
        '<geom type="mesh" mesh="m"/>',
        '<asset><mesh name="m" file="m.stl"/></asset>',
        "file-not-found",
        ":4:1",
    ),
    "no mesh": ('<geom type="mesh" mesh="m"/>', "", "bad-model", "x.xml:4:1: mesh 'm' not found"),
    "mass": ('<inertial pos="0 0 0" mass="-1" diaginertia="1 1 1"/>', "", "out-of-range", "the mass of a is negative"),
    "millimetres": ('<geom size=".01" pos="20 0 0"/>', "", "out-of-range", "lengths are in metres"),
    "a cloth": ('<flexcomp name="f" type="grid" count="2 2 1" spacing="1 1 1"/>', "", "not-a-body", "x.xml:4:1"),
    "a tendon": (
        '<site name="x"/><body name="b"><joint name="j"/><geom size=".01"/><site name="y" pos="0 0 .1"/></body>',
        '<tendon><spatial name="t"><site site="x"/><site site="y"/></spatial></tendon>' + PULLED,
        "tendon",
        "the tendon t runs through space and is pulled",
    ),
    "an include": ('<include file="no.xml"/>', "", "file-not-found", "no.xml"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused_has_its_place(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    inside, after, code, said = REFUSED[name]
    with pytest.raises(DiagnosticError) as caught:
        _model(BODY.format(inside, after))
    (fault,) = caught.value.diagnostics
    assert fault.code == code
    assert said in f"{fault.message} {fault.hint}"
    assert capfd.readouterr() == ("", "")


def test_includes_are_read_in_their_place_and_told_of_by_their_file(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "finger.xml").write_text(
        '<mujocoinclude>\n<body name="f"><joint name="j" range="0 90"/>\n<geom size=".01"/></body></mujocoinclude>'
    )
    (tmp_path / "hand.xml").write_text(
        WORLD.format('<body name="p"><geom size=".01"/><include file="parts/finger.xml"/></body>', "")
    )
    model = read_model(SpecFolder(tmp_path), "hand.xml")
    assert model.links["f"].where == "parts/finger.xml:2:1"
    (tmp_path / "parts" / "finger.xml").write_text(
        '<mujocoinclude>\n<include file="parts/finger.xml"/></mujocoinclude>'
    )
    with pytest.raises(DiagnosticError) as caught:
        read_model(SpecFolder(tmp_path), "hand.xml")
    assert caught.value.diagnostics[0].code == "wrong-include"


def test_what_moves_without_mass_is_given_a_little() -> None:
    model = _model(
        WORLD.format(CHAIN.replace('<body name="b"', '<body name="b" gravcomp="0"'), "").replace(
            '"0 90"/><geom size=".01"/></body>', '"0 90"/><geom size=".01" mass="0"/></body>'
        )
    )
    assert model.links["b"].mass == 1e-3
    assert np.linalg.eigvalsh(model.links["b"].inertia)[0] > 0.0
    (warning,) = (found for found in model.warnings if found.code == "no-mass")
    assert "b move and have no mass: 1 g is given" in warning.message
