"""Mesh files of a hand, in every format; those that hold no solid are refused."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from graspdsl.angles import turned_by_angles
from graspdsl.hands.description_files import DescriptionFileError
from graspdsl.hands.descriptions import Robot, mounts
from graspdsl.hands.hand_files import hand_in
from graspdsl.models.reading import read_model
from graspdsl.places.files import SpecFolder
from graspdsl.worlds.bullet.engine import pybullet
from graspdsl.worlds.bullet.hand import BulletHand

from .models import HAND, URDF, changed, write

FINGER = '<box size="0.01 0.01 0.04"/>'
BOX = trimesh.creation.box((0.02, 0.03, 0.05))
STL, OBJ = BOX.export(file_type="stl"), BOX.export(file_type="obj").encode()
NAN = struct.pack("<80sI", b"", 1) + struct.pack("<12fH", *[float("nan")] * 12, 0)
TABS = OBJ.replace(b" ", b"\t").replace(b"\n", b"\t\r\n")
REMARKS = b"# a box\n" + re.sub(rb"(?m)^(v .*)$", rb"  \1 # a corner", OBJ)

REFUSED = {
    "empty.stl": (b"", "empty-mesh", "empty.stl"),
    "words.stl": (b"hello", "unreadable-mesh", "words.stl is no STL file"),
    "cut.stl": (STL[:-60], "unreadable-mesh", "cut.stl"),
    "nothing.stl": (struct.pack("<80sI", b"", 0), "empty-mesh", "nothing.stl holds no triangles"),
    "nan.stl": (NAN, "bad-mesh", "coordinates are no numbers"),
    "empty.obj": (b"", "empty-mesh", "empty.obj is empty"),
    "index.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "unreadable-mesh", "index.obj"),
    "nan.obj": (b"v 0 nan 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "bad-mesh", "nan.obj"),
    "line.obj": (b"v 0 0 0\nf 1 1\n", "empty-mesh", "line.obj"),
    "part.dae": (b"<COLLADA/>", "unreadable-mesh", "part.dae"),
    "part.glb": (b"glTF", "unreadable-mesh", "part.glb"),
    "flat.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "bad-model", "mesh"),
}


def _urdf(shape: str, mesh: str) -> str:
    return changed(URDF, (shape, f'<mesh filename="{mesh}"/>'))


@pytest.mark.parametrize("name", REFUSED)
def test_a_bad_mesh_is_one_complaint(name: str, tmp_path: Path) -> None:
    content, code, said = REFUSED[name]
    (tmp_path / name).write_bytes(content)
    write(tmp_path, _urdf(FINGER, name))
    with pytest.raises(DescriptionFileError) as caught:
        hand_in(SpecFolder(tmp_path), "hand.yaml")
    (fault,) = caught.value.diagnostics
    assert fault.code == code
    assert said in fault.message
    assert fault.hint


def test_a_hand_in_a_package_of_ros(tmp_path: Path) -> None:
    """The hand file at the root of the package, model and meshes in folders of it."""
    root = tmp_path / "robotiq"
    for folder in ("urdf", "meshes"):
        (root / folder).mkdir(parents=True)
    (root / "meshes" / "a.stl").write_bytes(STL)
    (root / "urdf" / "two.urdf").write_text(_urdf(FINGER, "package://robotiq/meshes/a.stl"), encoding="utf-8")
    (root / "hand.yaml").write_text(changed(HAND, ("two.urdf", "urdf/two.urdf")), encoding="utf-8")
    for folder, name in ((root, "hand.yaml"), (tmp_path, "robotiq/hand.yaml")):
        assert f'filename="{root.resolve() / "meshes" / "a.stl"}"' in hand_in(SpecFolder(folder), name).hand.model
    (root / "meshes" / "a.stl").unlink()
    with pytest.raises(DescriptionFileError) as caught:
        hand_in(SpecFolder(root), "hand.yaml")
    (fault,) = caught.value.diagnostics
    assert fault.code == "file-not-found"
    assert fault.span is not None
    assert fault.span.line == 2


FORMATS = {
    "part.stl": STL,
    "PART.STL": STL,
    "text.stl": BOX.export(file_type="stl_ascii").encode(),
    "part.obj": OBJ,
    "tabs.obj": TABS,
    "remarks.obj": REMARKS,
    "part.ply": BOX.export(file_type="ply"),
    "part.glb": BOX.export(file_type="glb"),
    "part.dae": BOX.export(file_type="dae"),
    "centimetres.dae": BOX.copy()
    .apply_scale(100.0)
    .export(file_type="dae")
    .replace(b"<asset>", b'<asset><unit meter="0.01"/>'),
}


@pytest.mark.parametrize("name", FORMATS)
def test_a_box_of_every_format_is_that_box(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(FORMATS[name])
    write(tmp_path, _urdf(FINGER, name))
    (solid,) = read_model(SpecFolder(tmp_path), "two.urdf").links["finger"].solids
    assert solid.mesh is not None
    np.testing.assert_allclose(np.ptp(solid.mesh.corners, axis=0), BOX.extents, rtol=1e-6)


@pytest.mark.parametrize("name", ["part.dae", "text.stl", "remarks.obj"])
def test_the_engine_has_the_box_of_a_mesh(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(FORMATS[name])
    write(tmp_path, _urdf(FINGER, name))
    robot = Robot(hand=hand_in(SpecFolder(tmp_path), "hand.yaml").hand, mount=mounts()["gantry"])
    engine = pybullet()
    client = engine.connect(engine.DIRECT)
    try:
        hand = BulletHand(engine, client, robot, np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), 0.4)
        low, high = engine.getAABB(hand.body, hand.link_index["finger"], client)
    finally:
        engine.disconnect(client)
    # The engine puts one margin on all sides.
    margins = np.subtract(high, low) - BOX.extents
    np.testing.assert_allclose(margins, margins[0], atol=1e-6)
    assert 0.0 <= margins[0] < BOX.extents.min()


def test_a_mesh_is_where_a_reference_puts_it(tmp_path: Path) -> None:
    (tmp_path / "part.stl").write_bytes(STL)
    mesh = '<mesh file="part.stl" scale="2 2 2" refpos="0.1 0.2 0.3" refquat="1 0.3 0.2 0.1"/>'
    geom = '<geom type="mesh" mesh="part" pos="0.3 0.1 0" euler="10 20 30"/>'
    text = f'<mujoco><asset>{mesh}</asset><worldbody><body name="a">{geom}</body></worldbody></mujoco>'
    (tmp_path / "hand.xml").write_text(text)
    (solid,) = read_model(SpecFolder(tmp_path), "hand.xml").links["a"].solids
    given = mujoco.MjModel.from_xml_string(text, {"part.stl": STL})
    data = mujoco.MjData(given)
    mujoco.mj_kinematics(given, data)
    expected = given.mesh_vert @ data.geom_xmat[0].reshape(3, 3).T + data.geom_xpos[0]
    assert solid.mesh is not None
    found = solid.mesh.corners @ solid.frame.rotation.T + solid.frame.place
    apart = np.linalg.norm(found[:, None] - expected[None], axis=-1)
    assert apart.min(axis=1).max() < 1e-6


def test_a_mesh_is_where_its_file_has_it(tmp_path: Path) -> None:
    """The compiler moves meshes to their centres of mass and turns them: in the model they are as they were."""
    moved = BOX.copy()
    moved.apply_transform(trimesh.transformations.rotation_matrix(0.7, [1, 2, 3], [0.1, 0, 0]))
    (tmp_path / "part.stl").write_bytes(moved.export(file_type="stl"))
    place = '<origin xyz="0.01 0.02 0.03" rpy="0.3 -0.2 0.9"/>'
    urdf = _urdf(FINGER, "part.stl").replace('<origin xyz="0 0 0.02"/><geometry>', f"{place}<geometry>")
    write(tmp_path, urdf)
    (solid,) = read_model(SpecFolder(tmp_path), "two.urdf").links["finger"].solids
    np.testing.assert_allclose(solid.frame.place, [0.01, 0.02, 0.03], atol=1e-7)
    np.testing.assert_allclose(solid.frame.rotation, turned_by_angles((0.3, -0.2, 0.9)), atol=1e-6)
