"""The contract of shapes: how far each reaches, what it holds, how it collides, is drawn and floated upon, agree."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.contracts.keys import not_again, too_lenient, undescribed, unsaid
from graspdsl.contracts.numbers import shown
from graspdsl.contracts.rule import Breach, contract
from graspdsl.objects.shape import DescribedShape
from graspdsl.objects.standing import fall_of
from graspdsl.objects.surfaces.surface import Surface

CELLS, FEW_CELLS = 60, 24  # along each axis
DIRECTIONS, SAMPLES, MANY = 40, 500, 40_000
ROUNDING = 1e-9  # of a size
INTEGRAL = 0.01  # of a volume; of a size; of moments
FILLED = 0.08  # of a volume, that the convex parts may be too large or too small
FACETED, DRAWN = 5e-4, 2.5e-3  # m, that convex parts and pictures may fall short: of facets, and of rounded edges
SIGMAS = 6.0  # by which a mean of even samples may be off


def declared(kind: type[DescribedShape]) -> Iterator[Breach]:
    """A shape says which of its keys matter only where contacts float."""
    for name in kind.floating_only:
        if name not in kind.model_fields:
            yield f"floating_only names {name!r}, which is no key", "name fields of the shape"


def told(kind: type[DescribedShape]) -> Iterator[Breach]:
    """A docstring, a name and a line for lists say what it is."""
    yield from unsaid(kind, "name", "about")


def keys(kind: type[DescribedShape]) -> Iterator[Breach]:
    """Each key is described, with its unit."""
    yield from undescribed(kind)


def round_trip(kind: type[DescribedShape]) -> Iterator[Breach]:
    """A shape that is written out is read as the same, and nonsense is refused."""
    yield from not_again(example_of(kind))
    yield from too_lenient(example_of(kind))


def extent(kind: type[DescribedShape]) -> Iterator[Breach]:
    """The extent is what the support says along the axes, about an origin at half the height."""
    shape = example_of(kind)
    reach = np.array([(shape.support(axis), shape.support(-axis)) for axis in np.eye(3)])
    if not np.allclose(shape.extent, reach.sum(axis=1), rtol=ROUNDING):
        yield f"its extent is {shown(shape.extent)} m, its support gives {shown(reach.sum(axis=1))} m", "let them agree"
    elif abs(reach[2, 0] - reach[2, 1]) > ROUNDING * max(shape.extent):
        yield f"it reaches {reach[2, 0]:g} m up and {reach[2, 1]:g} m down", "put its origin at half its height"


def support(kind: type[DescribedShape]) -> Iterator[Breach]:
    """h(u + v) ≤ h(u) + h(v): the support is that of a convex hull."""
    shape, (first, second) = example_of(kind), _directions(2 * DIRECTIONS).reshape(2, -1, 3)
    for one, other in zip(first, second, strict=True):
        both = one + other
        length = float(np.linalg.norm(both))
        if length * shape.support(both / length) > shape.support(one) + shape.support(other) + ROUNDING:
            yield (
                f"its support is not convex, between {shown(one)} and {shown(other)}",
                "give max d · x over all points x of it",
            )
            return


def inside(kind: type[DescribedShape]) -> Iterator[Breach]:
    """Points inside lie within the support, and reach as far, up to the size of a cell."""
    shape = example_of(kind)
    points, _ = _points_inside(shape, CELLS)
    cell = max(shape.extent) / CELLS
    for direction in _directions(DIRECTIONS):
        reach, said = float((points @ direction).max()), shape.support(direction)
        if not said - 2.0 * cell <= reach <= said + ROUNDING:
            yield (
                f"along {shown(direction)} points inside reach {reach:g} m, its support is {said:g} m",
                "let them agree",
            )
            return


def solid(kind: type[DescribedShape]) -> Iterator[Breach]:
    """Volume, centre and moments are those of the cells inside."""
    shape = example_of(kind)
    points, cell = _points_inside(shape, CELLS)
    found, size = shape.solid, max(shape.extent)
    if abs(found.volume - len(points) * cell) > INTEGRAL * found.volume:
        yield f"its volume is {found.volume:.4g} m³, {len(points) * cell:.4g} m³ lie inside", "give ∫ dV"
    middle = points.mean(axis=0)
    if np.abs(found.centre - middle).max() > INTEGRAL * size:
        yield f"its centre is {shown(found.centre)} m, that of what lies inside {shown(middle)} m", "give ∫ r dV / V"
    moments = cell * (points - middle).T @ (points - middle)
    if np.abs(found.moments - moments).max() > 2 * INTEGRAL * np.trace(moments):
        yield (
            f"its moments are {shown(found.moments)} m⁵, those of what lies inside {shown(moments)}",
            "give ∫ (r − c)(r − c)ᵀ dV",
        )


def hulls(kind: type[DescribedShape]) -> Iterator[Breach]:
    """The convex parts reach as far as the shape, and fill it."""
    shape = example_of(kind)
    parts = shape.hulls()
    for direction in _directions(DIRECTIONS):
        reach, said = max(part.support(direction) for part in parts), shape.support(direction)
        if not said - FACETED <= reach <= said + FACETED / 10:
            yield (
                f"along {shown(direction)} its convex parts reach {reach:g} m, its support is {said:g} m",
                "let them agree",
            )
            return
    from scipy.spatial import ConvexHull

    points = _cells(shape, FEW_CELLS)[0].reshape(-1, 3)
    within = shape.inside()(points.reshape(FEW_CELLS**2, FEW_CELLS, 3)).ravel()
    filled = np.zeros(len(points), dtype=bool)
    for part in parts:
        planes = ConvexHull(part.vertices).equations
        filled |= np.array([(planes[:, :3] @ point + planes[:, 3]).max() <= part.margin for point in points])
    if not np.count_nonzero(filled != within) <= FILLED * np.count_nonzero(within):
        share = np.count_nonzero(filled) / np.count_nonzero(within)
        yield f"its convex parts fill {share:.0%} of it", "give convex parts that together are the shape"


def drawn(kind: type[DescribedShape]) -> Iterator[Breach]:
    """What is drawn reaches as far as the shape, and its normals point out of its triangles."""
    shape = example_of(kind)
    parts = shape.facets()
    for direction in _directions(DIRECTIONS):
        reach, said = max(float((part.vertices @ direction).max()) for part in parts), shape.support(direction)
        if not said - DRAWN <= reach <= said + ROUNDING:
            yield (
                f"along {shown(direction)} it is drawn as far as {reach:g} m, its support is {said:g} m",
                "let them agree",
            )
            return
    for part in parts:
        a, b, c = (part.vertices[part.faces[:, corner]] for corner in range(3))
        across = np.cross(b - a, c - a)
        outward = (across * part.normals[part.faces].mean(axis=1)).sum(axis=1)
        if not (outward[np.linalg.norm(across, axis=1) > ROUNDING] > 0.0).all():
            yield "normals of what is drawn point into it", "turn normals and triangles outwards, anticlockwise"
            return


def primitive(kind: type[DescribedShape]) -> Iterator[Breach]:
    """What an engine knows it as is of the same size."""
    shape = example_of(kind)
    if shape.primitive is None:
        return
    name, halves = shape.primitive
    sizes = {"sphere": 1, "cylinder": 2, "box": 3}
    if len(halves) != sizes.get(name):
        yield f"engines know no {name} of {len(halves)} half sizes", "give a box of 3, a cylinder of 2 or a sphere of 1"
        return
    across = halves[:1] * (4 - len(halves)) + halves[1:]
    if not np.allclose(2.0 * np.array(across), shape.extent, rtol=ROUNDING):
        yield f"its primitive is a {name} of {shown(halves)}, its extent {shown(shape.extent)}", "give half sizes (m)"


def surface(kind: type[DescribedShape]) -> Iterator[Breach]:
    """Contacts float on a surface of the same size, or the shape says that it has edges."""
    shape = example_of(kind)
    try:
        found = shape.surface()
    except ValueError:
        if not shape.edged:
            yield "it has no surface, and does not say that it has edges", "say edged: ClassVar = True"
        return
    if shape.edged:
        yield "it says that it has edges, and has a surface", "leave edged out"
    if not np.allclose(found.extent, shape.extent, rtol=ROUNDING):
        yield (
            f"its surface is of the size {shown(found.extent)} m, the shape of {shown(shape.extent)} m",
            "let them agree",
        )


def level(kind: type[DescribedShape]) -> Iterator[Breach]:
    """The level is 0 on the surface, below inside, above outside; the normals are its gradient."""
    for found in _surfaces(kind):
        points = found.sample(SAMPLES, _generator())
        normals = found.normals(points)
        step = 1e-3 * found.size * normals
        if np.abs(found.level(points)).max() > ROUNDING * found.size:
            yield "the level of its sampled points is not 0", "let sample give points of the surface"
        elif not (found.level(points + step) > 0.0).all() or not (found.level(points - step) < 0.0).all():
            yield "its level does not tell inside from outside along the normals", "negative inside; normals outwards"
        elif np.abs(np.linalg.norm(normals, axis=-1) - 1.0).max() > ROUNDING:
            yield "its normals are no unit vectors", "divide them by their lengths"
        else:
            ends = 1e-6 * found.size * np.eye(3)
            slopes = np.stack([found.level(points + end) - found.level(points - end) for end in ends], axis=-1)
            slopes /= np.linalg.norm(slopes, axis=-1, keepdims=True)
            if np.median(np.abs(normals - slopes)) > 1e-6 or np.abs(normals - slopes).max() > 0.01:
                yield "its normals are not the gradient of its level", "let them agree"


def nearest(kind: type[DescribedShape]) -> Iterator[Breach]:
    """Points beside the surface are put back on it, those outside to the nearest of its points."""
    for found in _surfaces(kind):
        random = _generator()
        points = found.sample(SAMPLES, random)
        outside = points + 0.01 * found.size * found.normals(points)
        beside = points + 0.2 * found.size * random.uniform(-1.0, 1.0, points.shape)
        special = np.concatenate([beside, np.zeros((1, 3)), 0.3 * np.array(found.extent) * np.eye(3)])
        feet = found.nearest(special)
        if not np.isfinite(feet).all() or np.abs(found.level(feet)).max() > ROUNDING * found.size:
            yield "the nearest point of some points is not on the surface", "no NaN anywhere, the centre and axes too"
        elif np.abs(found.nearest(outside) - points).max() > 1e-6 * found.size:
            yield "points before the surface do not go back along the normal", "let nearest give the nearest point"


def sample(kind: type[DescribedShape]) -> Iterator[Breach]:
    """Samples are even over the area, by ∮ n dA = 0 and ∮ x nᵀ dA = V I; the same generator gives the same."""
    for found in _surfaces(kind):
        points = found.sample(MANY, _generator())
        normals = found.normals(points)
        moments = (points[:, :, None] * normals[:, None, :]).reshape(MANY, 9)
        even = moments[:, [0, 4, 8]].mean() * np.eye(3).ravel()
        off = np.concatenate([normals.mean(axis=0), moments.mean(axis=0) - even])
        spread = np.concatenate([normals.std(axis=0), moments.std(axis=0)]) / np.sqrt(MANY)
        if (np.abs(off) > SIGMAS * spread + ROUNDING).any():
            yield "its samples are not even over the area", "draw each patch by its area"
        if not np.array_equal(found.sample(9, _generator()), found.sample(9, _generator())):
            yield "the same generator gives other samples", "draw from the generator that is given, and nothing else"


def batches(kind: type[DescribedShape]) -> Iterator[Breach]:
    """Points in any leading axes are taken as one by one."""
    for found in _surfaces(kind):
        points = found.sample(12, _generator()) * np.linspace(0.5, 1.5, 12)[:, None]
        functions: tuple[Callable[[Array], Array], ...] = (found.level, found.normals, found.nearest)
        for function in functions:
            alone = np.array([function(point) for point in points])
            many = function(points.reshape(2, 3, 2, 3))
            if many.shape != (2, 3, 2, *alone.shape[1:]) or not np.allclose(
                many.reshape(alone.shape), alone, rtol=1e-9
            ):
                yield f"{function.__name__} gives something else for many points", "let leading axes be: (..., 3)"


def rests(kind: type[DescribedShape]) -> Iterator[Breach]:
    """What says that it rests stays as it is put down."""
    angle = fall_of(example_of(kind))
    if kind.rests and angle > 0.0:
        yield f"it says that it rests, and tips by {np.degrees(angle):.0f}°", "leave rests out"


RULES = contract(
    declared,
    told,
    keys,
    round_trip,
    extent,
    support,
    inside,
    solid,
    hulls,
    drawn,
    primitive,
    surface,
    level,
    nearest,
    sample,
    batches,
    rests,
    wording=(told,),
)


def example_of(kind: type[DescribedShape]) -> DescribedShape:
    """The shape of a kind with the sizes of its examples."""
    given: dict[str, Any] = {
        field.alias or name: field.examples[0] for name, field in kind.model_fields.items() if field.examples
    }
    return kind.model_validate(given)


def _generator() -> np.random.Generator:
    return np.random.default_rng(7)


def _directions(count: int) -> Array:
    """Unit vectors (count, 3) all around."""
    vectors = _generator().normal(size=(count, 3))
    unit: Array = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    return unit


def _surfaces(kind: type[DescribedShape]) -> Iterator[Surface]:
    """The surface of the example, where it has one; that it should have one is another rule's."""
    if not kind.edged:
        yield example_of(kind).surface()


def _cells(shape: DescribedShape, count: int) -> tuple[Array, float]:
    """Lines (count², count, 3) of the centres of even cells in the box about a shape, and the volume of each [m³]."""
    high = np.array([shape.support(axis) for axis in np.eye(3)])
    low = -np.array([shape.support(-axis) for axis in np.eye(3)])
    lines = [a + (b - a) * (np.arange(count) + 0.5) / count for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
    return grid.reshape(-1, count, 3), float(np.prod((high - low) / count))


def _points_inside(shape: DescribedShape, count: int) -> tuple[Array, float]:
    """The centres (n, 3) of cells that are inside, and the volume of each [m³]."""
    lines, cell = _cells(shape, count)
    within: Flags = shape.inside()(lines)
    return lines[within], cell
