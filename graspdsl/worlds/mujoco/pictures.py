"""Pictures of a model by MuJoCo's own rays, shaded and smoothed, before a calm background."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array, Flags
from graspdsl.worlds.camera import FAR, OVERSAMPLING, Camera, Picture

LIGHT = 3.0 * np.array([-0.5, -1.0, 1.8]) / np.linalg.norm([-0.5, -1.0, 1.8])  # m
AMBIENT, DIFFUSE, GLOSS, SHININESS = 0.62, 0.5, 0.12, 20.0
SHADE = 0.5  # of the light that comes straight, the share that also a shadow has
SKY, GROUND = np.array([236.0, 240.0, 244.0]), np.array([206.0, 213.0, 220.0])
SHADOW = 1e-3  # m that a surface may be behind another and still be lit, as the same one is by rounding
STEP = 3  # pixels between those that are always looked at
SMALL = 2 * STEP  # pixels, radius
TURN = 0.15  # by which the parts of the normals of neighbours differ at an edge, at the least
LEVEL = 1e-5  # m between parallel triangles that are told apart
Numbers = npt.NDArray[np.int32]


class Painter:
    """Takes pictures of a model in a state of it.

    Where a few rays about some pixels meet the same thing, equally lit and hardly turned, these are between what those
    show; only pixels at edges, and where something small is, are looked at one by one.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        self._facets = {mesh: _Facets(model, mesh) for mesh in set(model.geom_dataid.tolist()) if mesh >= 0}

    def picture(self, camera: Camera, oversampling: int = OVERSAMPLING) -> Picture:
        """What a camera sees now. A pixel at an edge is the mean of so many by so many rays, which smooths it."""
        columns, rows = -(-camera.width // STEP) + 1, -(-camera.height // STEP) + 1
        x, y = np.meshgrid(STEP * np.arange(columns) + 0.5, STEP * np.arange(rows) + 0.5)
        colours, alike = self._seen(camera, x.ravel(), y.ravel())
        whole = _between(colours.reshape(rows, columns, 3))[: camera.height, : camera.width]
        edges = _edges(alike.reshape(rows, columns, -1))[: camera.height, : camera.width] | self._small(camera)
        y, x = (place[:, None, None] for place in np.nonzero(edges))
        finer = (np.arange(oversampling) + 0.5) / oversampling
        x, y = np.broadcast_arrays(x + finer[:, None], y + finer)
        fine, _ = self._seen(camera, x.ravel(), y.ravel())
        whole[edges] = fine.reshape(-1, oversampling**2, 3).mean(axis=1)
        return np.asarray(np.round(whole), dtype=np.uint8)

    def _small(self, camera: Camera) -> Flags:
        """Which pixels (height, width) things are in that rays some pixels apart may miss."""
        places, around = self._data.geom_xpos, np.zeros((camera.height, camera.width), dtype=bool)
        away = np.linalg.norm(places - camera.eye, axis=1)
        radii = self._model.geom_rbound * camera.projection[1, 1] * camera.height / 2 / away
        for geom in np.flatnonzero(radii < SMALL).tolist():
            (x, y), radius = camera.pixels(places[geom]), radii[geom]
            rows, columns = (slice(max(0, int(middle - radius)), max(0, int(middle + radius) + 1)) for middle in (y, x))
            around[rows, columns] = True
        return around

    def _seen(self, camera: Camera, x: Array, y: Array) -> tuple[Array, Array]:
        """The colours (r, 3), 0 to 255, at places of a picture, x (r,) to the right and y (r,) down [pixels].

        And numbers (r, 5), by which what is seen there differs: the thing, whether it is lit, and its normal.
        """
        rays = _rays(camera, x, y)
        geoms, distances, normals = self._cast(camera.eye, rays)
        colours = SKY + (y / camera.height)[:, None] * (GROUND - SKY)
        alike = np.column_stack([geoms, np.zeros(len(x)), normals])
        hit = np.flatnonzero(geoms >= 0)
        points = camera.eye + distances[hit, None] * rays[hit]
        colours[hit], alike[hit, 1] = self._shaded(geoms[hit], points, normals[hit], -rays[hit])
        return colours, alike

    def _cast(self, start: Array, rays: Array) -> tuple[Numbers, Array, Array]:
        """What rays (r, 3) from a point (3,) meet first: geoms (r,), -1 for nothing, distances (r,) in lengths of the
        rays, and unit normals (r, 3)."""
        count = len(rays)
        geoms, distances, normals = np.full(count, -1, dtype=np.int32), np.zeros(count), np.zeros((count, 3))
        mujoco.mj_multiRay(
            *(self._model, self._data, start, rays.ravel(), None, True, -1),
            *(geoms, distances, normals.ravel(), count, FAR),
        )
        return geoms, distances, normals

    def _shaded(self, geoms: Numbers, points: Array, flat: Array, back: Array) -> tuple[Array, Flags]:
        """The colours (r, 3) of points (r, 3) with normals (r, 3), seen from directions (r, 3), and which are lit."""
        normals = self._smooth(geoms, points, flat)
        normals *= np.sign(_dot(flat, back))[:, None]
        to_light = LIGHT - points
        to_light /= np.sqrt(_dot(to_light, to_light))[:, None]
        facing = _dot(normals, to_light)
        lit = facing > 0.0
        lit[lit] = self._lit(points[lit], -to_light[lit])
        half = to_light + back
        shine = np.maximum(0.0, _dot(normals, half)) / np.sqrt(_dot(half, half))
        bright = AMBIENT + DIFFUSE * np.where(lit, 1.0, SHADE) * np.maximum(0.0, facing)
        gloss = GLOSS * lit * shine**SHININESS
        colours = self._model.geom_rgba[geoms, :3] * bright[:, None] + gloss[:, None]
        return np.asarray(255.0 * np.minimum(colours, 1.0)), lit

    def _lit(self, points: Array, rays: Array) -> Flags:
        """Which points (r, 3) the light falls on, from where rays (r, 3) go to them."""
        _, distances, _ = self._cast(LIGHT, rays)
        away = points - LIGHT
        return np.asarray(distances > np.sqrt(_dot(away, away)) - SHADOW)

    def _smooth(self, geoms: Numbers, points: Array, flat: Array) -> Array:
        """Normals (r, 3) of surfaces of triangles, which have those of their vertices; of others as they are."""
        normals = flat.copy()
        for geom in np.unique(geoms).tolist():
            mesh = int(self._model.geom_dataid[geom])
            if mesh >= 0:
                rows = np.flatnonzero(geoms == geom)
                frame = self._data.geom_xmat[geom].reshape(3, 3)
                local = (points[rows] - self._data.geom_xpos[geom]) @ frame
                normals[rows] = self._facets[mesh].normals(local, flat[rows] @ frame) @ frame.T
        return normals


class _Facets:
    """The triangles of a mesh: where their planes are and the normals of their vertices."""

    def __init__(self, model: mujoco.MjModel, mesh: int) -> None:
        from scipy.spatial import cKDTree

        def rows(first: npt.NDArray[np.int32], count: npt.NDArray[np.int32]) -> slice:
            return slice(int(first[mesh]), int(first[mesh]) + int(count[mesh]))

        vertices = model.mesh_vert[rows(model.mesh_vertadr, model.mesh_vertnum)].astype(float)
        normals = model.mesh_normal[rows(model.mesh_normaladr, model.mesh_normalnum)].astype(float)
        faces = rows(model.mesh_faceadr, model.mesh_facenum)
        corners = vertices[model.mesh_face[faces]]
        self._first, self._sides = corners[:, 0], corners[:, 1:] - corners[:, :1]
        self._normals = normals[model.mesh_facenormal[faces]]
        across = np.cross(self._sides[:, 0], self._sides[:, 1])
        across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), np.finfo(float).tiny)
        self._size = float(np.linalg.norm(vertices, axis=1).max())
        self._tree = cKDTree(self._planes(self._first, across))

    def _planes(self, points: Array, normals: Array) -> Array:
        """Numbers (r, 4) that are near each other for planes that are: through points (r, 3) with unit normals."""
        return np.column_stack([normals, (points * normals).sum(axis=1) / self._size])

    def normals(self, points: Array, flat: Array) -> Array:
        """The normals (r, 3) at points (r, 3) of triangles with normals (r, 3): between those of the vertices.

        Two triangles in one plane are one: what is between the vertices of either goes on over the other.
        """
        planes = self._planes(points, flat)
        # All that was found on one triangle is asked for once.
        _, kept, number = np.unique(
            np.round(planes / (LEVEL / self._size)) @ [1.0, np.pi, np.e, np.sqrt(2.0)],
            return_index=True,
            return_inverse=True,
        )
        triangle = np.asarray(self._tree.query(planes[kept])[1])[number.reshape(-1)]
        a, b = self._sides[triangle, 0], self._sides[triangle, 1]
        off = points - self._first[triangle]
        aa, ab, bb = (a * a).sum(axis=1), (a * b).sum(axis=1), (b * b).sum(axis=1)
        ao, bo = (a * off).sum(axis=1), (b * off).sum(axis=1)
        area = np.maximum(aa * bb - ab * ab, np.finfo(float).tiny)
        u, v = (bb * ao - ab * bo) / area, (aa * bo - ab * ao) / area
        weights = np.clip(np.column_stack([1.0 - u - v, u, v]), -1.0, 1.0)
        between = np.einsum("rc,rci->ri", weights, self._normals[triangle])
        return np.asarray(between / np.maximum(np.linalg.norm(between, axis=1, keepdims=True), np.finfo(float).tiny))


def _rays(camera: Camera, x: Array, y: Array) -> Array:
    """Unit vectors (r, 3) from a camera's eye through places of its picture, x (r,) to the right and y (r,) down."""
    right, up = camera.projection[0, 0], camera.projection[1, 1]
    across, above = (2.0 * x / camera.width - 1.0) / right, (1.0 - 2.0 * y / camera.height) / up
    rays = np.stack([across, above, np.full(len(x), -1.0)], axis=-1) @ camera.view[:3, :3]
    return np.asarray(rays / np.sqrt(1.0 + across**2 + above**2)[:, None])


def _between(values: Array) -> Array:
    """Values (STEP (r − 1), STEP (c − 1), 3) of all pixels between those of every STEP-th, (r, c, 3)."""
    share = (np.arange(STEP) / STEP)[:, None, None]
    down = ((1.0 - share) * values[:-1, None] + share * values[1:, None]).reshape(-1, values.shape[1], 3)
    across = (1.0 - share[:, 0]) * down[:, :-1, None] + share[:, 0] * down[:, 1:, None]
    return np.asarray(across.reshape(len(down), -1, 3))


def _edges(alike: Array) -> Flags:
    """Which pixels (STEP (r − 1), STEP (c − 1)) are not between such as show the same, by their numbers (r, c, 5)."""
    corners = alike[:-1, :-1], alike[:-1, 1:], alike[1:, :-1], alike[1:, 1:]
    mixed = np.zeros(corners[0].shape[:2], dtype=bool)
    for corner in corners[1:]:
        mixed |= (corner[..., :2] != corners[0][..., :2]).any(axis=-1)
        mixed |= np.abs(corner[..., 2:] - corners[0][..., 2:]).max(axis=-1) > TURN
    return np.asarray(mixed.repeat(STEP, axis=0).repeat(STEP, axis=1))


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ri,ri->r", a, b))
