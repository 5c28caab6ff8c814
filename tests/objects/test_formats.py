"""The same object in every format that is read; bodies of MJCF against what MuJoCo itself makes of them."""

from __future__ import annotations

import struct
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from graspdsl.compiler.object_check import body_in
from graspdsl.compiler.program import examine
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.objects.shapes import Body
from graspdsl.places.files import SpecFolder
from graspdsl.spec.scene import InlineObject

from .parts import without

ROOT = Path(__file__).parents[2]
SIZES = (0.0625, 0.09375, 0.125)  # m, which four bytes hold exactly


def _wedge() -> trimesh.Trimesh:
    """A box without one of its corners, somewhere: no two of its axes are alike."""
    corners = trimesh.creation.box(SIZES).vertices
    wedge = trimesh.convex.convex_hull(corners[np.argsort(corners.sum(axis=1))[:-1]])
    return wedge.apply_translation((0.25, 0.5, 0.75))


def _read(folder: Path, **thing: object) -> Body:
    return body_in(SpecFolder(folder), InlineObject.model_validate(thing), lambda _: None)


def _refused(folder: Path, **thing: object) -> tuple[Diagnostic, ...]:
    with pytest.raises(DiagnosticError) as caught:
        _read(folder, **thing)
    return tuple(caught.value.diagnostics)


def _msh(mesh: trimesh.Trimesh) -> bytes:
    corners, faces = np.asarray(mesh.vertices, "<f4"), np.asarray(mesh.faces, "<i4")
    return struct.pack("<4i", len(corners), 0, 0, len(faces)) + corners.tobytes() + faces.tobytes()


def _written(folder: Path) -> dict[str, dict[str, object]]:
    """The wedge in files of every kind, and how a spec names each."""
    mesh, things = _wedge(), dict[str, dict[str, object]]()
    for kind in ("stl", "ply", "obj", "glb", "off", "dae"):
        mesh.export(folder / f"part.{kind}")
        things[kind] = {"mesh": {"file": f"part.{kind}"}}
    (folder / "part.msh").write_bytes(_msh(mesh))
    things["msh"] = {"mesh": {"file": "part.msh"}}
    large = mesh.copy().apply_scale(100.0).export(file_type="dae").decode()
    (folder / "cm.dae").write_text(large.replace("<up_axis>", '<unit name="centimetre" meter="0.01"/><up_axis>'))
    things["dae in cm"] = {"mesh": {"file": "cm.dae"}}
    collision = (
        '<collision><origin xyz="1 0 0" rpy="0 0 0"/><geometry><mesh filename="part.obj"/></geometry></collision>'
    )
    (folder / "part.urdf").write_text(f'<robot name="a"><link name="b">{collision}</link></robot>')
    things["urdf"] = {"urdf": "part.urdf"}
    (folder / "part.xml").write_text(
        '<mujoco><asset><mesh name="m" file="part.stl"/></asset><worldbody><body name="b" pos="1 2 3">'
        '<freejoint/><geom type="mesh" mesh="m" pos="0 0 1"/></body></worldbody></mujoco>'
    )
    things["mjcf"] = {"mjcf": "part.xml"}
    return things


def test_the_same_object_is_the_same_body_in_every_format(tmp_path: Path) -> None:
    things, mesh = _written(tmp_path), _wedge()
    middle = mesh.bounds.mean(axis=0)
    directions = np.random.default_rng(2).normal(size=(30, 3))
    for kind, thing in things.items():
        body = _read(tmp_path, **thing, mass=0.4)
        solid, size = body.shape.solid, max(SIZES)
        np.testing.assert_allclose(body.shape.extent, mesh.extents, atol=1e-6 * size, err_msg=kind)
        np.testing.assert_allclose(solid.centre, mesh.center_mass - middle, atol=1e-6 * size, err_msg=kind)
        expected = mesh.moment_inertia * 0.4 / mesh.volume
        np.testing.assert_allclose(solid.inertia(0.4), expected, atol=1e-6 * np.trace(expected), err_msg=kind)
        for direction in directions:
            reach = ((mesh.vertices - middle) @ direction).max()
            assert body.shape.support(direction) == pytest.approx(reach, abs=1e-6), kind


def test_parts_of_a_scene_are_put_where_its_nodes_are(tmp_path: Path) -> None:
    """A box in a node that is turned and moved, and the same one in a node inside of it, beside the other there."""
    scene, turn = trimesh.Scene(), trimesh.transformations.euler_matrix(0.0, 0.0, np.pi / 2)
    turn[:3, 3] = (5.0, 6.0, 7.0)
    aside = trimesh.transformations.translation_matrix((0.0, 0.5, 0.0))
    box = trimesh.creation.box(SIZES)
    scene.add_geometry(box, node_name="outer", transform=turn)
    scene.add_geometry(box.copy(), node_name="inner", parent_node_name="outer", transform=aside)
    scene.export(tmp_path / "scene.glb")
    body = _read(tmp_path, mesh={"file": "scene.glb", "convex": "hull"})
    np.testing.assert_allclose(body.shape.extent, (0.5 + SIZES[1], SIZES[0], SIZES[2]), atol=1e-6)
    assert body.shape.solid.volume == pytest.approx(2 * np.prod(SIZES), rel=1e-5)


BODIES = """<mujoco model="kitchen">
  <compiler angle="radian" meshdir="meshes"/>
  <default>
    <geom density="800"/>
    <default class="heavy"><geom density="2700" size="0.02 0.03 0.04" type="box"/></default>
  </default>
  <asset><mesh name="wedge" file="part.stl"/></asset>
  <include file="more.xml"/>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <body name="bar" pos="1 0 0">
      <joint name="slides" type="slide" axis="1 0 0"/>
      <geom class="heavy"/>
      <geom type="capsule" size="0.015" fromto="0 0 0.055 0.02 0.01 0.2"/>
      <geom type="sphere" size="0.5" contype="0" conaffinity="0" mass="0"/>
      <body name="end" pos="0 0 -0.1" euler="0.4 0.3 0">
        <geom type="ellipsoid" size="0.02 0.03 0.04"/>
        <geom type="cylinder" size="0.01 0.02" pos="0.06 0 0"/>
        <geom type="mesh" mesh="wedge" pos="0 0.2 0" euler="0 0 1"/>
      </body>
    </body>
    <body name="door"><geom class="heavy"/><body><joint name="hinge"/><geom class="heavy" pos="0.1 0 0"/></body></body>
    <body name="ghost"><geom class="heavy" contype="0" conaffinity="0"/></body>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="module")
def kitchen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("kitchen")
    (folder / "meshes").mkdir()
    _wedge().export(folder / "meshes" / "part.stl")
    (folder / "kitchen.xml").write_text(BODIES)
    (folder / "more.xml").write_text(
        '<mujoco><worldbody><body name="cup"><freejoint/><geom type="cylinder" size="0.03 0.05" mass="0.2"/></body>'
        "</worldbody></mujoco>"
    )
    return folder


def test_a_body_is_what_mujoco_makes_of_it(kitchen: Path) -> None:
    """The density is even in each of these, and not in all: where there is one, their inertias are the same."""
    thing = _read(kitchen, mjcf={"file": "kitchen.xml", "body": "end"})
    model = mujoco.MjModel.from_xml_path(str(kitchen / "kitchen.xml"))
    body = model.body("end")
    assert thing.mass == pytest.approx(float(body.mass[0]), rel=1e-6)
    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, body.iquat)
    inertia = axes.reshape(3, 3) @ np.diag(body.inertia) @ axes.reshape(3, 3).T
    np.testing.assert_allclose(thing.shape.solid.inertia(thing.mass), inertia, atol=2e-6 * np.trace(inertia))
    assert thing.name == "end"


def test_what_is_fixed_to_a_body_belongs_to_it_and_what_moves_all_of_it_does_not_matter(kitchen: Path) -> None:
    thing = _read(kitchen, mjcf={"file": "kitchen.xml", "body": "bar"})
    model = mujoco.MjModel.from_xml_path(str(kitchen / "kitchen.xml"))
    assert thing.mass == pytest.approx(float(model.body("bar").subtreemass[0]), rel=1e-6)


def test_a_stated_mass_and_an_included_body(kitchen: Path) -> None:
    cup = _read(kitchen, mjcf={"file": "kitchen.xml", "body": "cup"})
    assert cup.mass == pytest.approx(0.2)
    np.testing.assert_allclose(cup.shape.extent, (0.06, 0.06, 0.1), atol=1e-12)
    assert _read(kitchen, mjcf={"file": "kitchen.xml", "body": "cup"}, mass=0.7).mass == 0.7


@pytest.mark.parametrize(
    ("body", "code", "said"),
    [
        ("door", "moving-joint", "kitchen.xml:22:50: the joint hinge is continuous, where an object is one rigid body"),
        ("ghost", "no-collisions", "kitchen.xml is no object: nothing of it touches"),
        ("cub", "unknown-root", "there is no body 'cub' in the model"),
    ],
)
def test_what_is_no_object(body: str, code: str, said: str, kitchen: Path) -> None:
    (fault,) = _refused(kitchen, mjcf={"file": "kitchen.xml", "body": body})
    assert (fault.code, fault.message) == (code, said)
    assert body != "cub" or "cup" in str(fault.hint)


def test_one_of_several_bodies_has_to_be_named(kitchen: Path) -> None:
    text = "<mujoco><worldbody>{}</worldbody></mujoco>"
    box = "<body name='{}'><geom type='box' size='0.03 0.03 0.03'/></body>"
    (kitchen / "two.xml").write_text(text.format(box.format("a") + box.format("b")))
    (fault,) = _refused(kitchen, mjcf="two.xml")
    assert fault.message == "two.xml: the world has 2 bodies, where an object is one: a and b"
    assert fault.hint == "name one of them: mjcf: {file: two.xml, body: …}; body: world for all that is fixed"
    (kitchen / "one.xml").write_text(text.format(box.format("a")))
    assert _read(kitchen, mjcf="one.xml").name == "one"


def test_a_fault_of_a_model_is_told_where_the_spec_names_it(kitchen: Path) -> None:
    text = (ROOT / "specs" / "towel_roll_two_contacts.yaml").read_text("utf-8")
    (kitchen / "bad.xml").write_text("<mujoco><worldbody><body><geom size='a'/></body></worldbody></mujoco>")
    spec = text.replace("object: towel-roll\n", "object: {mjcf: {file: bad.xml}}\n")
    (fault,) = examine(spec, "spec.yaml", (), kitchen).diagnostics
    assert "bad.xml:1:" in fault.message
    assert fault.span is not None
    assert spec.split("\n")[fault.span.line - 1][fault.span.column - 1 :].startswith("bad.xml}")


@pytest.mark.parametrize(
    ("name", "content", "code"),
    [
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 1\n", "unreadable-mesh"),
        ("a.glb", b"glTF\x02\0\0\0", "unreadable-mesh"),
        ("a.dae", b"<COLLADA/>", "unreadable-mesh"),
        ("a.off", b"OFF\n", "unreadable-mesh"),
        ("a.msh", b"\x05\0\0\0" * 4, "unreadable-mesh"),
        ("b.msh", b"\x05", "unreadable-mesh"),
        ("a.3mf", b"x", "unknown-mesh-format"),
    ],
)
def test_what_is_no_file_of_its_kind_is_one_complaint(name: str, content: bytes, code: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    assert [fault.code for fault in _refused(tmp_path, mesh={"file": name})] == [code]


def test_an_open_mesh_of_any_format_is_told_of(tmp_path: Path) -> None:
    without(_wedge(), 1).export(tmp_path / "open.ply")
    told: list[Diagnostic] = []
    body_in(SpecFolder(tmp_path), InlineObject.model_validate({"mesh": {"file": "open.ply"}}), told.append)
    assert [fault.code for fault in told] == ["mesh-not-watertight"]
