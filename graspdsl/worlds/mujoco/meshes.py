"""A robot's URDF as MuJoCo takes it, its mesh files of whatever format."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import mujoco

from graspdsl.models.mesh_files import stl_of


def spec_of(tree: ET.Element) -> mujoco.MjSpec:
    """A URDF, the triangles of its meshes as STL: their names in it are others then."""
    files: dict[str, bytes] = {}
    names: dict[str, str] = {}
    for mesh in tree.iter("mesh"):
        path = mesh.get("filename", "")
        if path not in names:
            names[path] = f"mesh-{len(names)}.stl"
            files[names[path]] = stl_of(path)
        mesh.set("filename", names[path])
    return mujoco.MjSpec.from_string(ET.tostring(tree, encoding="unicode"), assets=files)
