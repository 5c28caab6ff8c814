"""Write the table of docs/quality.md: how much of ε the pyramids within the friction cones leave out, by their edges.

Run it with the package installed: python docs/render_quality.py. It takes some minutes.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

import graspdsl as g
from graspdsl.arrays import Array
from graspdsl.quality.contact_models import ContactModel, HardPoint, SoftFinger, contact_model
from graspdsl.quality.ferrari_canny import ferrari_canny
from graspdsl.quality.force_closure import force_closure
from graspdsl.quality.wrench_space import WrenchSpace, wrench_space

PLACE = Path(__file__).resolve().parent / "quality.md"
SPEC = PLACE.parents[1] / "specs" / "chapter" / "4_18_grasp.yaml"
TABLE = re.compile(r"(?<=<!-- table: edges -->\n\n)(?:\|.*\n)+")
HALF_AXES = np.array([0.04, 0.06, 0.09])  # m, of the ellipsoid that contacts are on
TORQUE_SCALE = float(np.sqrt(2.0 / 15.0 * (HALF_AXES**2).sum()))  # m, its radius of gyration
FRICTION = 0.5
SEED = 2006
GRASPS = 20  # of each number of contacts
EDGES = (8, 16, 32)
TOLERANCE = 1e-3  # of the ε of round cones
FACETS = 40  # at most, that are pushed out at once
HEAD = (
    "| contacts | edges | left out: median | 9 in 10 | largest | said: median | 9 in 10 | largest |",
    "|---|--:|--:|--:|--:|--:|--:|--:|",
)


def table() -> str:
    """A row for each kind of grasps and number of edges: what is left out of ε, and what is said to be at most."""
    return "\n".join([*HEAD, *(row for name in KINDS for row in rows(name)), ""])


def rows(name: str, edges: Sequence[int] = EDGES) -> Iterator[str]:
    """The rows of grasps of a kind."""
    spaces = list(itertools.islice(KINDS[name](), GRASPS))
    exact = [round_cones(space)[0] for space in spaces]
    for number in edges:
        found = [ferrari_canny(with_edges(space, number)) for space in spaces]
        left_out = [1.0 - (one.epsilon.value or 0.0) / whole for one, whole in zip(found, exact, strict=True)]
        said = [1.0 if one.shortfall.value is None else one.shortfall.value for one in found]
        cells = [f"{100 * max(0.0, share):.1f} %" for shares in (left_out, said) for share in _told(shares)]
        yield f"| {name} | {number} | {' | '.join(cells)} |"


def _told(shares: Sequence[float]) -> list[float]:
    return [float(np.quantile(shares, quantile)) for quantile in (0.5, 0.9, 1.0)]


def drawn(count: int) -> Iterator[WrenchSpace]:
    """Contacts drawn anywhere on the ellipsoid, of those draws that are closed."""
    random = np.random.default_rng([SEED, count])
    while True:
        on_ball = random.normal(size=(count, 3))
        on_ball /= np.linalg.norm(on_ball, axis=1)[:, None]
        inward = -on_ball / HALF_AXES
        model = contact_model(None, count, FRICTION, None, 16)
        space = wrench_space(on_ball * HALF_AXES, inward, model, reference=np.zeros(3), length=TORQUE_SCALE)
        if force_closure(space):
            yield space


def settled() -> Iterator[WrenchSpace]:
    """Where the trials of a spec have ended."""
    program = g.load(SPEC)
    scale = program.body.shape.solid.radius_of_gyration
    run = g.run(program, trials=GRASPS, seed=SEED, progress=False)
    for record in run.trials:
        points, normals = (run.trajectory(record.number)[name][-1] for name in ("points", "normals"))
        model = contact_model(None, len(points), FRICTION, None, 16)
        yield wrench_space(points, normals, model, reference=np.zeros(3), length=scale)


KINDS: Mapping[str, Callable[[], Iterator[WrenchSpace]]] = {
    "3, settled by π_g": settled,
    **{f"{count}, drawn": partial(drawn, count) for count in (2, 3, 4, 5)},
}


def with_edges(space: WrenchSpace, edges: int) -> WrenchSpace:
    """The same contacts with pyramids of so many edges."""
    model = space.model
    assert isinstance(model, HardPoint | SoftFinger)
    return replace(space, model=replace(model, edges=edges))


def round_cones(space: WrenchSpace, tolerance: float = TOLERANCE) -> tuple[float, float]:
    """The ε of round cones, from below and from above, to a relative tolerance.

    The hull of some wrenches is within that of round cones, which reaches h(d) along a unit vector d, so that ε lies
    between the least offset of its facets and the least h over their normals. The facets that are nearest to the
    origin are pushed out to the wrenches that reach farthest along their normals, until both agree.
    """
    wrenches, high = space.wrenches, np.inf
    while True:
        normals, offsets = facets(wrenches)
        low, high = float(offsets.min()), min(high, float(space.support(normals).min()))
        if high - low <= tolerance * high:
            return low, high
        near = np.argsort(offsets)[:FACETS]
        farthest = [reached(space, normals[facet]) for facet in near if offsets[facet] < high]
        wrenches = np.unique(np.vstack([wrenches, *farthest]).round(12), axis=0)


def facets(wrenches: Array) -> tuple[Array, Array]:
    """Unit normals (f, 6) and offsets (f,) of the facets of the hull of wrenches (m, 6)."""
    left, values, right = np.linalg.svd(wrenches, full_matrices=False)
    try:
        hull = ConvexHull(left)
    except QhullError:
        hull = ConvexHull(left, qhull_options="QJ Pp")
    normals = (hull.equations[:, :-1] / values) @ right
    lengths = np.linalg.norm(normals, axis=1)
    return normals / lengths[:, None], -hull.equations[:, -1] / lengths


def reached(space: WrenchSpace, direction: Array) -> Array:
    """The wrench (k, 6) of each contact's round cone that reaches farthest along a direction (6,)."""
    model: ContactModel = space.model
    assert isinstance(model, HardPoint | SoftFinger)
    along = space.basis @ direction
    sideways = along[:, 1:3] / np.maximum(np.hypot(along[:, 1], along[:, 2]), 1e-300)[:, None]
    turning = np.sign(along[:, 3:]) * (model.torsion if isinstance(model, SoftFinger) else 0.0)
    parts = np.hstack([np.ones((len(along), 1)), model.friction * sideways, turning])
    return np.asarray(np.einsum("kc,kci->ki", parts, space.basis))


if __name__ == "__main__":
    made = table()
    PLACE.write_text(TABLE.sub(lambda _: made, PLACE.read_text("utf-8")), "utf-8")
