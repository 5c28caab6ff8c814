"""Objects from STL, OBJ and URDF files: where they are, what they weigh, what is wrong with them."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import trimesh

from graspdsl.compiler.object_check import body_in
from graspdsl.compiler.program import examine, program_of
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity
from graspdsl.objects.compound import Compound
from graspdsl.objects.mesh_files import mesh_of_file
from graspdsl.objects.shape import convex_parts, shaded
from graspdsl.objects.shapes import Body
from graspdsl.objects.triangles import TriangleMesh
from graspdsl.places.files import SpecFolder
from graspdsl.spec.scene import InlineObject

from .parts import URDF, cylinder, ring, without, write

SPEC = (Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml").read_text("utf-8")


def _spec(thing: str) -> str:
    return SPEC.replace("  object: towel-roll\n", f"  object: {thing}\n")


def _body(thing: InlineObject, folder: Path) -> Body:
    return body_in(SpecFolder(folder), thing, lambda _: None)


def _mesh(folder: Path, mesh: trimesh.Trimesh, name: str = "part.stl", **fields: object) -> Body:
    write(mesh, folder / name)
    return _body(InlineObject.model_validate({"mesh": {"file": name, **fields}, "mass": 0.5}), folder)


@pytest.mark.parametrize("name", ["part.stl", "part.obj"])
@pytest.mark.parametrize("make", [cylinder, ring])
def test_a_mesh_is_placed_by_its_bounding_box_and_weighs_what_trimesh_says(
    make: Callable[[], trimesh.Trimesh], name: str, tmp_path: Path
) -> None:
    mesh = make()
    body = _mesh(tmp_path, mesh, name)
    solid = body.shape.solid
    np.testing.assert_allclose(body.shape.extent, mesh.extents, atol=1e-6)
    np.testing.assert_allclose(solid.centre, mesh.center_mass - mesh.bounds.mean(axis=0), atol=1e-6)
    assert solid.volume == pytest.approx(mesh.volume, rel=1e-5)
    expected = mesh.moment_inertia * 0.5 / mesh.volume
    np.testing.assert_allclose(solid.inertia(0.5), expected, atol=1e-4 * np.trace(expected))
    for axis in np.eye(3):
        assert body.shape.support(axis) == pytest.approx(body.shape.support(-axis), abs=1e-6)


def test_the_file_may_be_in_other_units(tmp_path: Path) -> None:
    body = _mesh(tmp_path, cylinder().apply_scale(1000.0), scale=0.001)
    np.testing.assert_allclose(body.shape.extent, (0.09, 0.09, 0.18), atol=1e-4)


def test_density_makes_the_mass(tmp_path: Path) -> None:
    write(trimesh.creation.box((0.1, 0.2, 0.3)), tmp_path / "part.stl")
    thing = InlineObject.model_validate({"mesh": {"file": "part.stl", "density": 500.0}})
    assert _body(thing, tmp_path).mass == pytest.approx(0.006 * 500.0, rel=1e-6)


def test_a_mesh_turned_inside_out_is_turned_back(tmp_path: Path) -> None:
    mesh = cylinder()
    volume = mesh.volume
    mesh.invert()
    assert _mesh(tmp_path, mesh).shape.solid.volume == pytest.approx(volume, rel=1e-5)


def test_the_longest_side_of_a_mesh_is_its_major_axis(tmp_path: Path) -> None:
    assert _mesh(tmp_path, trimesh.creation.box((0.2, 0.1, 0.1))).major_axis == (1.0, 0.0, 0.0)
    assert _mesh(tmp_path, trimesh.creation.box((0.1, 0.1, 0.1))).major_axis == (0.0, 0.0, 1.0)


@pytest.mark.slow
def test_a_mesh_that_is_not_convex_collides_as_parts(tmp_path: Path) -> None:
    hollow, solid = _mesh(tmp_path, ring()), _mesh(tmp_path, cylinder())
    assert len(convex_parts(hollow.shape)) > 5
    assert len(convex_parts(solid.shape)) == 1
    assert len(convex_parts(_mesh(tmp_path, ring(), convex="hull").shape)) == 1
    parts = [hull.vertices for hull in convex_parts(hollow.shape)]
    # Hardly any of them reaches into the hole, and together they are as large as the ring.
    assert np.hypot(*np.concatenate(parts)[:, :2].T).min() > 0.027
    np.testing.assert_allclose(np.ptp(np.concatenate(parts), axis=0), hollow.shape.extent, atol=1.5e-3)
    assert [part.tobytes() for part in parts] == [hull.vertices.tobytes() for hull in convex_parts(hollow.shape)]


def test_a_hull_of_very_many_corners_is_thinned_out(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(subdivisions=5, radius=0.05)
    shape = _mesh(tmp_path, ball).shape
    assert isinstance(shape, TriangleMesh)
    assert len(shape.hull) < 2000 < len(ball.vertices)
    random = np.random.default_rng(0)
    for direction in random.normal(size=(200, 3)):
        assert shape.support(direction / np.linalg.norm(direction)) == pytest.approx(0.05, abs=2e-4)


def test_edges_of_a_mesh_are_sharp_and_its_curves_smooth(tmp_path: Path) -> None:
    (part,) = shaded(_mesh(tmp_path, cylinder()).shape)
    side = np.abs(part.normals[:, 2]) < 0.5
    np.testing.assert_allclose(part.normals[~side, 2] ** 2, 1.0, atol=1e-6)
    radial = part.vertices[side, :2] / np.linalg.norm(part.vertices[side, :2], axis=1, keepdims=True)
    assert ((part.normals[side, :2] * radial).sum(axis=1) > np.cos(np.radians(3.0))).all()


def test_a_urdf_is_one_body_about_its_bounding_box(tmp_path: Path) -> None:
    write(trimesh.creation.box((0.1, 0.1, 0.1)), tmp_path / "shade.stl")
    (tmp_path / "lamp.urdf").write_text(URDF.format(mesh="shade.stl"))
    body = _body(InlineObject.model_validate({"urdf": "lamp.urdf"}), tmp_path)
    assert isinstance(body.shape, Compound)
    assert body.mass == 0.3  # as the file says; its inertia of a ton is not believed
    volumes = 0.12 * 0.10 * 0.10, np.pi * 0.02**2 * 0.08, 0.05**3
    solid = body.shape.solid
    assert solid.volume == pytest.approx(sum(volumes), rel=1e-6)
    assert body.shape.extent[2] == pytest.approx(0.12 + 0.05 + 0.025)
    heights = 0.05, 0.12, 0.17
    middle = np.dot(volumes, heights) / sum(volumes) - body.shape.extent[2] / 2
    np.testing.assert_allclose(solid.centre, [0.0, 0.0, middle], atol=1e-6)
    for axis in np.eye(3):
        assert body.shape.support(axis) == pytest.approx(body.shape.support(-axis), abs=1e-9)


def test_a_package_is_a_folder_about_the_urdf(tmp_path: Path) -> None:
    (tmp_path / "lamp" / "urdf").mkdir(parents=True)
    (tmp_path / "lamp" / "meshes").mkdir()
    write(trimesh.creation.box((0.1, 0.1, 0.1)), tmp_path / "lamp" / "meshes" / "shade.stl")
    (tmp_path / "lamp" / "urdf" / "lamp.urdf").write_text(URDF.format(mesh="package://lamp/meshes/shade.stl"))
    program = program_of(_spec("{urdf: lamp/urdf/lamp.urdf, mass: 0.4}"), "spec.yaml", folder=tmp_path)
    assert program.body.mass == 0.4
    assert [str(file.kept_as) for file in program.files] == ["lamp/urdf/lamp.urdf", "lamp/meshes/shade.stl"]


ONE_LINK = "<robot><link name='a'><collision><geometry>{}</geometry></collision></link></robot>"
BOX = "<collision><geometry><box size='0.1 0.1 0.1'/></geometry></collision>"
JOINT = "<joint name='j' type='{}'><parent link='a'/><child link='{}'/></joint>"
URDFS = {
    "moving": f"<robot><link name='a'>{BOX}</link><link name='b'/>{JOINT.format('revolute', 'b')}</robot>",
    "circle": f"<robot><link name='a'>{BOX}</link><link name='b'/>{JOINT.format('fixed', 'a')}</robot>",
    "apart": f"<robot><link name='a'>{BOX}</link><link name='b'/></robot>",
    "bare": "<robot><link name='a'/></robot>",
    "other": "<html/>",
    "broken": "<robot><link",
    "entities": "<!DOCTYPE r [<!ENTITY a 'b'>]><robot>&a;</robot>",
    "negative": ONE_LINK.format("<sphere radius='-1'/>"),
    "speck": ONE_LINK.format("<box size='1e-9 1e-9 1e-9'/>"),
    "words": ONE_LINK.format("<box size='a b c'/>"),
    "infinite": ONE_LINK.format("<sphere radius='inf'/>"),
}


def _folder(path: Path) -> Path:
    """A folder with the files of the cases, and one beside it."""
    folder = path / "spec"
    (folder / "folder.stl").mkdir(parents=True)
    for place in (folder, path):
        write(cylinder(), place / "part.stl")
    write(cylinder().apply_scale(1000.0), folder / "millimetres.stl")
    write(cylinder().apply_scale(0.001), folder / "tiny.stl")
    write(cylinder().apply_scale(0.0001), folder / "speck.stl")
    write(without(cylinder(), 3), folder / "holes.stl")
    whole = (folder / "part.stl").read_bytes()
    texts = {
        "empty.stl": b"",
        "nothing.stl": b"solid nothing\nendsolid nothing\n",
        "text.stl": b"This is a letter, not a mesh.\n" * 10,
        "cut.stl": whole[: len(whole) // 2],
        "many.stl": b"\0" * 80 + struct.pack("<I", 600_000) + b"\0" * 50 * 600_000,
        "nan.stl": whole[:96] + struct.pack("<f", float("nan")) + whole[100:],
        "flat.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3\n",
        "lines.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 1 2\nf 2 3 2\n",
        "plane.obj": b"v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n",
        "short.obj": b"v 0 0 0\nv 1 0 0\nv 0 1\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n",
        "huge.obj": b"v 1e308 0 0\nv -1e308 0 0\nv 0 1e308 0\nv 0 0 1e308\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n",
        "points.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\n",
        "index.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
        "binary.obj": b"\xff\xfe\x00" * 100,
        "part.step": b"ISO-10303-21;",
        "outside.urdf": URDF.format(mesh="../part.stl").encode(),
        "absolute.urdf": URDF.format(mesh=path / "part.stl").encode(),
    }
    for name, content in texts.items():
        (folder / name).write_bytes(content)
    for name, text in URDFS.items():
        (folder / f"{name}.urdf").write_text(text)
    (folder / "loop.stl").symlink_to("loop.stl")
    (folder / "out.stl").symlink_to(path / "part.stl")
    (folder / "in.stl").symlink_to("part.stl")
    os.mkfifo(folder / "pipe.stl")
    with (folder / "enormous.stl").open("wb") as file:
        file.truncate(65 * 1024 * 1024)
    return folder


@dataclass(frozen=True)
class Case:
    """A file, and what is said of it."""

    file: str
    code: str
    said: str
    severity: Severity = Severity.ERROR

    @property
    def thing(self) -> str:
        return f"{{urdf: {self.file}}}" if self.file.endswith(".urdf") else f"{{mesh: {{file: {self.file}}}}}"


CASES = (
    Case("missing.stl", "file-not-found", "there is no file missing.stl"),
    Case("folder.stl", "is-a-directory", "folder.stl is a directory, not a file"),
    Case("pipe.stl", "not-a-file", "pipe.stl is not a regular file"),
    Case("enormous.stl", "file-too-large", "enormous.stl is too large: 68157440 bytes"),
    Case("many.stl", "file-too-large", "many.stl has 600000 triangles, where a mesh may have 500000"),
    Case("../part.stl", "outside-of-folder", "../part.stl leads out of the folder of the spec"),
    Case("../spec/part.stl", "outside-of-folder", "../spec/part.stl leads out of the folder of the spec"),
    Case("out.stl", "outside-of-folder", "out.stl leads out of the folder of the spec"),
    Case("loop.stl", "link-loop", "loop.stl is a symbolic link that leads back to itself"),
    Case("empty.stl", "empty-mesh", "empty.stl is empty"),
    Case("nothing.stl", "empty-mesh", "nothing.stl holds no triangles"),
    Case("text.stl", "unreadable-mesh", "text.stl is no STL file"),
    Case("cut.stl", "unreadable-mesh", "cut.stl is cut short: of the 256 triangles that it announces it holds 127"),
    Case("index.obj", "unreadable-mesh", "index.obj cannot be read as OBJ"),
    Case("binary.obj", "unreadable-mesh", "binary.obj is no OBJ file: it is not text"),
    Case("part.step", "unknown-mesh-format", "is no file of triangles that can be read"),
    Case("nan.stl", "bad-mesh", "nan.stl has corners whose coordinates are no numbers"),
    Case("plane.obj", "bad-mesh", "plane.obj has corners of 2 coordinates"),
    Case("short.obj", "bad-mesh", "short.obj has corners of 2 coordinates"),
    Case("huge.obj", "bad-mesh", "huge.obj is inf m long"),
    Case("points.obj", "empty-mesh", "points.obj holds no triangles"),
    Case("flat.obj", "flat-mesh", "flat.obj is flat: it encloses no volume"),
    Case("lines.obj", "flat-mesh", "lines.obj is flat: its triangles are lines"),
    Case("millimetres.stl", "object-size", "millimetres.stl is 180 m long", Severity.WARNING),
    Case("tiny.stl", "object-size", "tiny.stl is 0.00018 m long", Severity.WARNING),
    Case("speck.urdf", "object-size", "the box is 1e-09 m thick"),
    Case("speck.stl", "object-size", "speck.stl is 1.8e-05 m long"),
    Case("holes.stl", "mesh-not-watertight", "holes.stl has holes: it is not watertight", Severity.WARNING),
    Case("moving.urdf", "moving-joint", "moving.urdf:1:115: the joint j is continuous, where an object is one rigid"),
    Case("circle.urdf", "joint-cycle", "the joints form a cycle: a hang on one another"),
    Case("apart.urdf", "no-root", "2 links have no parent"),
    Case("bare.urdf", "no-collisions", "bare.urdf is no object: nothing of it touches"),
    Case("other.urdf", "not-a-model", "its root is <html>, neither <robot> nor <mujoco>"),
    Case("broken.urdf", "bad-xml", "broken.urdf is no XML: line 1"),
    Case("entities.urdf", "bad-xml", "the file declares a document type"),
    Case("negative.urdf", "out-of-range", "the radius of <sphere> is negative: -1"),
    Case("words.urdf", "not-a-number", "expected three numbers as the size of <box>"),
    Case("infinite.urdf", "not-a-number", "expected a number as the radius of <sphere>, found 'inf'"),
    Case("outside.urdf", "outside-of-folder", "../part.stl leads out of the folder of the spec"),
    Case("absolute.urdf", "outside-of-folder", "absolute.urdf names a file outside of the folder of the spec"),
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return _folder(tmp_path_factory.mktemp("files"))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.file)
def test_each_fault_of_a_file_is_one_complaint_at_its_name(case: Case, folder: Path) -> None:
    text = _spec(case.thing)
    examination = examine(text, "spec.yaml", (), folder)
    (found,) = examination.diagnostics
    assert isinstance(found, Diagnostic)
    assert (found.code, found.severity) == (case.code, case.severity)
    assert case.said in found.message
    assert found.span is not None
    line = text.split("\n")[found.span.line - 1]
    assert line[found.span.column - 1 : found.span.end_column - 1] == case.file
    assert (examination.program is None) == (case.severity is Severity.ERROR)


ODD = {
    "nothing": (None, "empty-mesh"),
    "empty scene": (trimesh.Scene(), "empty-mesh"),
    "points": (trimesh.PointCloud(np.eye(3)), "empty-mesh"),
    "path": (trimesh.load_path(np.eye(3)), "empty-mesh"),
    "plane": (trimesh.Trimesh(np.zeros((3, 2)), [[0, 1, 2]], process=False), "bad-mesh"),
    "no corners": (trimesh.Trimesh(np.zeros((0, 3)), [[0, 1, 2]], process=False), "bad-mesh"),
    "too few corners": (trimesh.Trimesh(np.eye(3), [[0, 1, 7]], process=False), "bad-mesh"),
    "corners before the first": (trimesh.Trimesh(np.eye(3), [[0, 1, -7]], process=False), "bad-mesh"),
    "no numbers": (trimesh.Trimesh(np.full((3, 3), np.nan), [[0, 1, 2]], process=False), "bad-mesh"),
    "scene of them": (trimesh.Scene([trimesh.Trimesh(np.eye(3), [[0, 1, 2]], process=False)]), "flat-mesh"),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", ODD)
def test_whatever_the_mesh_library_makes_of_a_file_is_one_complaint(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    loaded, code = ODD[kind]
    monkeypatch.setattr(trimesh, "load", lambda *_, **__: loaded)
    with pytest.raises(DiagnosticError) as caught:
        mesh_of_file("part.obj", b"v 0 0 0\n", 1.0, None, lambda _: None)
    assert [fault.code for fault in caught.value.diagnostics] == [code]


def test_all_faults_of_a_urdf_are_told_at_once(tmp_path: Path) -> None:
    parts = ("<sphere radius='-1'/>", "<cone/>", "<box size='a'/>", "<box size='1 1 1'/>")
    collisions = "".join(f"<collision><geometry>{part}</geometry></collision>" for part in parts)
    mass = "<inertial><mass value='much'/><inertia ixx='1' iyy='1' izz='1'/></inertial>"
    joint = JOINT.format("hinged", "b")
    text = f"<robot><link name='a'>{collisions}{mass}</link><link name='b'/>{joint}</robot>"
    (tmp_path / "part.urdf").write_text(text)
    found = examine(_spec("{urdf: part.urdf}"), "spec.yaml", (), tmp_path).diagnostics
    said = "\n".join(fault.message for fault in found)
    assert len(found) == 5
    for words in ("radius of <sphere>", "<cone>", "size of <box>", "value of <mass>", "hinged"):
        assert words in said


def test_a_file_in_millimetres_is_told_the_scale(folder: Path) -> None:
    (found,) = examine(_spec("{mesh: {file: millimetres.stl}}"), "spec.yaml", (), folder).diagnostics
    assert found.hint == "if its file is in millimetres, write scale: 0.001"


@pytest.mark.parametrize("file", ["part.stl", "in.stl"])
def test_a_watertight_mesh_is_fine(file: str, folder: Path) -> None:
    examination = examine(_spec(f"{{mesh: {{file: {file}}}}}"), "spec.yaml", (), folder)
    assert examination.diagnostics == ()
    assert examination.program is not None


def test_an_absolute_path_may_be_anywhere(folder: Path) -> None:
    program = program_of(_spec(f"{{mesh: {{file: {folder.parent / 'part.stl'}}}}}"), "spec.yaml", folder=folder)
    assert program.body.name == "part"


@pytest.mark.slow
def test_an_object_without_a_file_needs_no_mesh_library() -> None:
    code = (
        "import sys; from graspdsl.compiler.program import program_of; from pathlib import Path; "
        "program_of(Path('specs/towel_roll_two_contacts.yaml').read_text('utf-8'), 'spec'); "
        "sys.exit(any(name in sys.modules for name in ('trimesh', 'vhacdx', 'pybullet')))"
    )
    root = Path(__file__).parents[2]
    assert subprocess.run([sys.executable, "-c", code], cwd=root, check=False).returncode == 0


def test_contacts_cannot_float_on_a_mesh(folder: Path) -> None:
    text = _spec("{mesh: {file: missing.stl}}").replace("world: bullet", "world: floating")
    codes = [found.code for found in examine(text, "spec.yaml", (), folder).diagnostics]
    assert "shape-not-in-world" in codes
    assert "file-not-found" not in codes


def _chain(links: int) -> str:
    link = "<link name='l{}'/><joint name='j{}' type='fixed'><parent link='l{}'/><child link='l{}'/></joint>"
    rest = "".join(link.format(i, i, i - 1, i) for i in range(1, links))
    return f"<robot><link name='l0'>{BOX}</link>{rest}</robot>"


@pytest.mark.slow
@pytest.mark.parametrize(("links", "said"), [(100, ()), (1900, ("1900 links below the root",))])
def test_very_many_links_take_no_time(links: int, said: tuple[str, ...], tmp_path: Path) -> None:
    (tmp_path / "long.urdf").write_text(_chain(links), encoding="utf-8")
    began = time.perf_counter()
    found = examine(_spec("{urdf: long.urdf}"), "spec.yaml", (), tmp_path).diagnostics
    assert time.perf_counter() - began < 2.0
    assert len(found) == len(said)
    assert all(words in fault.message for words, fault in zip(said, found, strict=True))
