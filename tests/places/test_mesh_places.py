"""Where a URDF's meshes are looked for, in the layouts that packages of ROS have."""

from __future__ import annotations

from pathlib import Path

import pytest

from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.places.files import SpecFolder
from graspdsl.places.mesh_places import MeshPlaces

MESH = "package://robotiq/meshes/a.stl"
# The URDF, the files about it, and that which is meant.
LAYOUTS = {
    "beside": ("h.urdf", ("meshes/a.stl",), "meshes/a.stl"),
    "package beside": ("h.urdf", ("robotiq/meshes/a.stl", "meshes/a.stl"), "robotiq/meshes/a.stl"),
    "the spec's folder is the package": ("urdf/h.urdf", ("meshes/a.stl",), "meshes/a.stl"),
    "the spec is above the package": ("robotiq/urdf/h.urdf", ("robotiq/meshes/a.stl",), "robotiq/meshes/a.stl"),
    "name before what is nearer": (
        "robotiq/urdf/h.urdf",
        ("robotiq/urdf/meshes/a.stl", "robotiq/meshes/a.stl"),
        "robotiq/meshes/a.stl",
    ),
    "manifest before what is nearer": (
        "mine/urdf/h.urdf",
        ("mine/urdf/meshes/a.stl", "mine/meshes/a.stl", "mine/package.xml"),
        "mine/meshes/a.stl",
    ),
    "name before the manifest": (
        "robotiq/mine/urdf/h.urdf",
        ("robotiq/mine/package.xml", "robotiq/mine/meshes/a.stl", "robotiq/meshes/a.stl"),
        "robotiq/meshes/a.stl",
    ),
    "another package": (
        "mine/urdf/h.urdf",
        ("mine/package.xml", "robotiq/package.xml", "robotiq/meshes/a.stl"),
        "robotiq/meshes/a.stl",
    ),
}


def _write(folder: Path, names: tuple[str, ...]) -> None:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(name.encode())


def _complaint(folder: Path, urdf: str, mesh: str) -> Diagnostic:
    with pytest.raises(DiagnosticError) as caught:
        MeshPlaces(SpecFolder(folder), urdf).name(mesh)
    (fault,) = caught.value.diagnostics
    return fault


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("absolute", [False, True])
def test_layouts(layout: str, absolute: bool, tmp_path: Path) -> None:
    urdf, names, meant = LAYOUTS[layout]
    _write(tmp_path, names)
    files = SpecFolder(tmp_path)
    found = MeshPlaces(files, str(tmp_path / urdf) if absolute else urdf).name(MESH)
    assert files.read(found) == meant.encode()


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_copies_of_a_run_give_the_same_file(layout: str, tmp_path: Path) -> None:
    urdf, names, meant = LAYOUTS[layout]
    _write(tmp_path / "spec", names)
    files = SpecFolder(tmp_path / "spec")
    files.read(MeshPlaces(files, urdf).name(MESH))
    _write(tmp_path / "copies", tuple(str(file.kept_as) for file in files.files))
    assert MeshPlaces(SpecFolder(tmp_path / "copies"), urdf).name(MESH) == meant


def test_a_mesh_that_is_nowhere_says_where_it_was_looked_for(tmp_path: Path) -> None:
    fault = _complaint(tmp_path, "robotiq/urdf/h.urdf", MESH)
    assert (fault.code, fault.message) == ("file-not-found", f"there is no file {MESH}")
    for place in ("robotiq/meshes/a.stl", "robotiq/urdf/meshes/a.stl", "meshes/a.stl"):
        assert f" {place}" in (fault.hint or "")
    deep = _complaint(tmp_path, "/a/b/c/d/e/f/g/h.urdf", MESH)
    assert (deep.hint or "").endswith("and so on, from the folder of the spec")


@pytest.mark.parametrize("mesh", ["package://../a.stl", "package://x/../a.stl", "package://x/../../a.stl"])
def test_a_package_does_not_lead_out_of_the_folder(mesh: str, tmp_path: Path) -> None:
    _write(tmp_path, ("a.stl", "spec/b.stl"))
    assert _complaint(tmp_path / "spec", "h.urdf", mesh).code == "file-not-found"


def test_an_absolute_mesh_is_not_of_the_spec(tmp_path: Path) -> None:
    _write(tmp_path, ("a.stl", "spec/b.stl"))
    place = tmp_path / "a.stl"
    for mesh in (str(place), f"file://{place}"):
        assert _complaint(tmp_path / "spec", "h.urdf", mesh).code == "outside-of-folder"
        assert MeshPlaces(SpecFolder(tmp_path / "spec"), str(tmp_path / "h.urdf")).name(mesh) == str(place)
    for mesh in (f"package://{place}", f"package://x/{place}"):
        assert _complaint(tmp_path / "spec", "h.urdf", mesh).code == "file-not-found"
