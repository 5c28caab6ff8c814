"""Files of objects for the tests, made by trimesh."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import trimesh

from graspdsl.arrays import Array

AWAY = (1.0, 2.0, 3.0)  # m: the origin of a file is not where the object is


def cylinder() -> trimesh.Trimesh:
    """A cylinder, diameter 9 cm, height 18 cm, somewhere."""
    return trimesh.creation.cylinder(radius=0.045, height=0.18, sections=64).apply_translation(AWAY)


def ring() -> trimesh.Trimesh:
    """A ring, which is not convex."""
    return trimesh.creation.annulus(r_min=0.03, r_max=0.05, height=0.1, sections=24)


def without(mesh: trimesh.Trimesh, faces: int) -> trimesh.Trimesh:
    """A mesh without its first faces."""
    mesh.update_faces(np.arange(len(mesh.faces)) >= faces)
    return mesh


def write(mesh: trimesh.Trimesh, path: Path) -> Path:
    """The mesh in a file, in the format of its suffix."""
    mesh.export(path)
    return path


def textured(corners: Array, polygons: Sequence[Sequence[int]]) -> str:
    """An OBJ file whose polygons of corners (n, 3), numbered from 0, each have texture and normal of their own."""
    rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in corners.tolist()]
    for face, polygon in enumerate(polygons):
        around = np.roll(corners[list(polygon)], -1, axis=0)
        normal = np.cross(corners[list(polygon)], around).sum(axis=0)
        rows += [f"vt {face % 7 / 7!r} {place / 4!r}" for place in range(4)]
        rows.append("vn " + " ".join(map(repr, (normal / np.linalg.norm(normal)).tolist())))
        words = (f"{corner + 1}/{4 * face + place + 1}/{face + 1}" for place, corner in enumerate(polygon))
        rows.append("f " + " ".join(words))
    return "\n".join(rows) + "\n"


URDF = """<robot name="lamp">
  <link name="foot">
    <inertial><mass value="0.3"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="5 1 0.05"/><geometry><box size="0.12 0.10 0.10"/></geometry></collision>
  </link>
  <link name="arm">
    <collision>
      <origin rpy="0 1.5707963267948966 0"/><geometry><cylinder radius="0.02" length="0.08"/></geometry>
    </collision>
    <collision><origin xyz="0 0 0.05"/><geometry><mesh filename="{mesh}" scale="0.5 0.5 0.5"/></geometry></collision>
  </link>
  <joint name="joint" type="fixed">
    <parent link="foot"/><child link="arm"/><origin xyz="5 1 0.12" rpy="0 0 0.4"/>
  </joint>
</robot>
"""
