"""Shapes inside Bullet: how they collide, how their mass is spread."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.objects.facets import Hull
from graspdsl.objects.shape import convex_parts
from graspdsl.objects.shapes import Body
from graspdsl.worlds.bullet.hand import rotation_matrix


@dataclass(frozen=True, eq=False, slots=True)
class EngineBody:
    """A body in the engine. The engine's frame of it has its origin at the centre of mass, which is at ``centre`` (3,)
    [m] of the frame of the shape, and its axes, the columns of ``axes`` (3, 3), along the principal ones of inertia."""

    index: int
    centre: Array
    axes: Array

    def pose(self, engine: Any, client: int) -> tuple[Array, Array]:
        """The centre of mass (3,) [m] and the rotation (3, 3) of the shape's frame in the world."""
        position, quaternion = engine.getBasePositionAndOrientation(self.index, client)
        return np.array(position), rotation_matrix(quaternion) @ self.axes.T

    def move(self, engine: Any, client: int, origin: Array) -> None:
        """Put the body upright with the origin of its shape's frame at a point (3,) [m], at rest."""
        quaternion = Rotation.from_matrix(self.axes).as_quat()
        position = (origin + self.centre).tolist()
        engine.resetBasePositionAndOrientation(self.index, position, quaternion.tolist(), client)


def put_body(engine: Any, client: int, body: Body, *, fixed: bool) -> EngineBody:
    """A body with the origin of its shape's frame at that of the world, upright; ``fixed`` to the world or free."""
    solid = body.shape.solid
    moments, axes = solid.principal(body.mass)
    back = (axes.T, -axes.T @ solid.centre)
    primitive = _primitive(engine, client, body)
    hulls: tuple[Hull, ...] = ()
    if primitive is None:
        hulls = convex_parts(body.shape)
        collision = _collision(engine, client, [hull.placed(*back) for hull in hulls])
    else:
        collision = primitive
    visual = speck(engine, client)
    index: int = engine.createMultiBody(0.0 if fixed else body.mass, collision, visual, physicsClientId=client)
    for hull in hulls[:1]:
        engine.changeDynamics(index, -1, collisionMargin=hull.margin, physicsClientId=client)
    if primitive is None and not fixed:  # the engine knows the inertia of its own shapes
        engine.changeDynamics(index, -1, localInertiaDiagonal=moments.tolist(), physicsClientId=client)
    placed = EngineBody(index, solid.centre, axes)
    placed.move(engine, client, np.zeros(3))
    return placed


def _primitive(engine: Any, client: int, body: Body) -> int | None:
    """What the engine has a shape of its own for; the centre of mass is its origin, and its axes are principal."""
    form: dict[str, float | list[float]]
    match body.shape.primitive:
        case "cylinder", (radius, top):
            kind, form = engine.GEOM_CYLINDER, {"radius": radius, "height": 2 * top}
        case "box", half:
            kind, form = engine.GEOM_BOX, {"halfExtents": list(half)}
        case "sphere", (radius,):
            kind, form = engine.GEOM_SPHERE, {"radius": radius}
        case _:
            return None
    collision: int = engine.createCollisionShape(kind, **form, physicsClientId=client)
    return collision


def _collision(engine: Any, client: int, hulls: Sequence[Hull]) -> int:
    if len(hulls) == 1:
        vertices = hulls[0].vertices.tolist()
        index: int = engine.createCollisionShape(engine.GEOM_MESH, vertices=vertices, physicsClientId=client)
        return index
    # Several hulls reach the engine only through a file, in which each object becomes the hull of its points.
    engine.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=client)
    with tempfile.TemporaryDirectory(prefix="graspdsl-") as folder:
        path = Path(folder, "hulls.obj")
        path.write_text(_wavefront(hulls), encoding="ascii")
        compound: int = engine.createCollisionShape(engine.GEOM_MESH, fileName=str(path), physicsClientId=client)
    return compound


def _wavefront(hulls: Sequence[Hull]) -> str:
    """An OBJ file with an object for each hull; its triangles only have to name every vertex."""
    lines, first = [], 1
    for number, hull in enumerate(hulls):
        count = len(hull.vertices)
        lines.append(f"o hull-{number}")
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in hull.vertices]
        corners = first + np.minimum(np.arange(-(-count // 3) * 3), count - 1).reshape(-1, 3)
        lines += [f"f {a} {b} {c}" for a, b, c in corners]
        first += count
    return "\n".join([*lines, ""])


def speck(engine: Any, client: int) -> int:
    """The number of the visual shape of what nobody sees: the engine keeps looks of every world for good, and without
    one it would make those of what collides."""
    index: int = engine.createVisualShape(engine.GEOM_BOX, halfExtents=[1e-4] * 3, physicsClientId=client)
    return index
