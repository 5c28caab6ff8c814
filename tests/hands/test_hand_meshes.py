"""Mesh files of a hand: those the engine would leave out or fall over are refused."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from graspdsl.compiler.program import examine
from graspdsl.diagnostics import Severity
from graspdsl.hands.hand_files import HandFileError, hand_in
from graspdsl.hands.mesh_check import LARGEST
from graspdsl.places.files import SpecFolder
from graspdsl.worlds.bullet.engine import pybullet, silenced

from .models import HAND, SPEC, URDF, changed, write

FINGER = '<box size="0.01 0.01 0.04"/>'
BALL = '<sphere radius="0.011"/>'
BOX = trimesh.creation.box((0.02, 0.03, 0.05))
STL, TEXT, OBJ = (
    BOX.export(file_type="stl"),
    BOX.export(file_type="stl_ascii").encode(),
    BOX.export(file_type="obj").encode(),
)
NAN = struct.pack("<80sI", b"", 1) + struct.pack("<12fH", *[float("nan")] * 12, 0)
TABS = OBJ.replace(b" ", b"\t").replace(b"\n", b"\t\r\n")
REMARKS = b"# a box\n" + re.sub(rb"(?m)^(v .*)$", rb"  \1 # a corner", OBJ)

REFUSED = {
    "empty.stl": (b"", "unreadable-mesh", "empty.stl is no STL file"),
    "words.stl": (b"hello", "unreadable-mesh", "words.stl is no STL file"),
    "text.stl": (TEXT, "unreadable-mesh", "text.stl is STL in text"),
    "cut.stl": (STL[:-60], "unreadable-mesh", "of the 12 triangles that it announces it holds 10"),
    "long.stl": (STL + b"\0\0", "unreadable-mesh", "2 bytes more than the 12 triangles"),
    "longer.stl": (STL + bytes(120), "unreadable-mesh", "120 bytes more than the 12 triangles"),
    "nothing.stl": (struct.pack("<80sI", b"", 0), "empty-mesh", "nothing.stl holds no triangles"),
    "nan.stl": (NAN, "bad-mesh", "coordinates are no numbers"),
    "large.stl": (bytes(LARGEST + 1), "file-too-large", "large.stl is too large"),
    "empty.obj": (b"", "empty-mesh", "empty.obj holds no triangles"),
    "index.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "unreadable-mesh", "index.obj, line 4"),
    "before.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -4\n", "unreadable-mesh", "before.obj, line 4"),
    "nan.obj": (b"v 0 nan 0\nf 1 1 1\n", "unreadable-mesh", "nan.obj, line 1"),
    "line.obj": (b"v 0 0 0\nf 1 1\n", "unreadable-mesh", "line.obj, line 2"),
    "comment.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 # a\n", "unreadable-mesh", "line 4: a comment after a face"),
    "feed.obj": (b"v 0 0 0\nv 1 0\x0c0\nv 0 1 0\nf 1 2 3\n", "unreadable-mesh", "feed.obj, line 2"),
    "decimal.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1.0 2 3\n", "unreadable-mesh", "decimal.obj, line 4"),
    "part.dae": (b"<COLLADA/>", "unknown-mesh-format", "'part.dae'"),
}


def _urdf(shape: str, mesh: str) -> str:
    return changed(URDF, (shape, f'<mesh filename="{mesh}"/>'))


@pytest.mark.parametrize("name", REFUSED)
def test_a_bad_mesh_is_one_complaint(name: str, tmp_path: Path) -> None:
    content, code, said = REFUSED[name]
    (tmp_path / name).write_bytes(content)
    write(tmp_path, _urdf(FINGER, name))
    with pytest.raises(HandFileError) as caught:
        hand_in(SpecFolder(tmp_path), "hand.yaml")
    (fault,) = caught.value.diagnostics
    assert fault.code == code
    assert said in fault.message
    assert fault.hint


def test_a_drawing_in_collada_is_left_out_with_a_warning(tmp_path: Path) -> None:
    write(tmp_path, _urdf(BALL, "part.dae"))
    examination = examine(SPEC, "spec.yaml", (), tmp_path)
    (fault,) = examination.diagnostics
    assert (fault.code, fault.severity) == ("undrawn", Severity.WARNING)
    assert examination.program is not None
    assert "part.dae" not in examination.program.robot.models[1]


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
    with pytest.raises(HandFileError) as caught:
        hand_in(SpecFolder(root), "hand.yaml")
    (fault,) = caught.value.diagnostics
    assert fault.code == "file-not-found"
    assert fault.span is not None
    assert fault.span.line == 2


@pytest.mark.parametrize(
    ("name", "content"),
    [("part.stl", STL), ("PART.STL", STL), ("part.obj", OBJ), ("tabs.obj", TABS), ("remarks.obj", REMARKS)],
)
def test_the_engine_has_the_box_of_a_good_mesh(name: str, content: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    write(tmp_path, _urdf(FINGER, name))
    (tmp_path / "whole.urdf").write_text(hand_in(SpecFolder(tmp_path), "hand.yaml").hand.model, encoding="utf-8")
    engine = pybullet()
    client = engine.connect(engine.DIRECT)
    try:
        with silenced():
            body = engine.loadURDF(str(tmp_path / "whole.urdf"), useFixedBase=True, physicsClientId=client)
        links = [engine.getJointInfo(body, j, client)[12] for j in range(engine.getNumJoints(body, client))]
        low, high = engine.getAABB(body, links.index(b"finger"), client)
    finally:
        engine.disconnect(client)
    # The engine puts one margin on all sides.
    margins = np.subtract(high, low) - BOX.extents
    np.testing.assert_allclose(margins, margins[0], atol=1e-6)
    assert 0.0 <= margins[0] < BOX.extents.min()
