"""How robots, objects and contacts look, as MuJoCo's models of what is only seen: nothing in them collides."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence

import mujoco
import numpy as np

from graspdsl.hands.descriptions import Robot
from graspdsl.objects.shading import Shaded
from graspdsl.worlds.mujoco.meshes import spec_of
from graspdsl.worlds.mujoco.model import OBJECT, tip_geom
from graspdsl.worlds.protocol import TABLE_SIZE
from graspdsl.worlds.rigid.assembly import joined

PAPER, WOOD, CONTACT = (0.93, 0.91, 0.86, 1.0), (0.76, 0.62, 0.46, 1.0), (0.13, 0.42, 0.62, 1.0)
BALL = 0.0035  # m, radius


def robot_looks(robot: Robot) -> mujoco.MjSpec:
    """A robot with its root at the origin: what its model says of looks, of a link that has none what touches."""
    tree = joined(robot)
    bare = {link.get("name", "") for link in tree.iterfind("link") if link.find("visual") is None}
    tips = [contact for contact in robot.hand.contacts.values() if contact.link in bare]
    for link in tree.iterfind("link"):
        for part in link.findall("collision"):
            if link.get("name") in bare.difference(tip.link for tip in tips):
                part.tag = "visual"
            else:
                link.remove(part)
    ET.SubElement(ET.SubElement(tree, "mujoco"), "compiler", discardvisual="false", fusestatic="false")
    spec = spec_of(tree)
    for tip in tips:
        tip_geom(spec.body(tip.link), tip.shape)
    for mesh in spec.meshes:
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # which also a mesh that is open or flat has
    return spec


def put_table(spec: mujoco.MjSpec, top: float) -> None:
    """The table, its top at a height [m]."""
    half = [size / 2 for size in TABLE_SIZE]
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half, pos=[0.0, 0.0, top - half[2]], rgba=WOOD)


def put_object(spec: mujoco.MjSpec, parts: Sequence[Shaded]) -> None:
    """An object of triangles that can be put anywhere, its frame at the origin."""
    made = spec.worldbody.add_body(name=OBJECT, explicitinertial=True, mass=1.0, inertia=[1.0, 1.0, 1.0])
    made.add_freejoint(name=OBJECT)
    for number, part in enumerate(parts):
        mesh = spec.add_mesh(name=f"{OBJECT}-{number}", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
        mesh.uservert, mesh.usernormal = part.vertices.ravel(), part.normals.ravel()
        mesh.userface = mesh.userfacenormal = part.faces.astype(np.int32).ravel()
        kind = mujoco.mjtGeom.mjGEOM_MESH
        made.add_geom(type=kind, meshname=mesh.name, rgba=PAPER, contype=0, conaffinity=0)  # else hulls are made


def put_contacts(spec: mujoco.MjSpec, count: int) -> None:
    """So many small balls, each put where its number has its place among the bodies that are moved."""
    for _ in range(count):
        ball = spec.worldbody.add_body(mocap=True)
        ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[BALL, 0.0, 0.0], rgba=CONTACT)
