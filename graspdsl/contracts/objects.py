"""The contract of objects: what a catalogue entry has to keep, so that it stands on the table."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graspdsl.contracts.described import is_named, is_told
from graspdsl.contracts.numbers import shown
from graspdsl.contracts.rule import Breach, contract
from graspdsl.objects.shapes import Body
from graspdsl.objects.standing import fall_of
from graspdsl.spec.scene import GRAVITY
from graspdsl.worlds.kind import TABLE_FRICTION
from graspdsl.worlds.kinds import rigid_bodies
from graspdsl.worlds.protocol import TABLE_SIZE, UnstableObjectError

LIGHTEST, HEAVIEST = 1.0, 23_000.0  # kg/m³: foam, osmium
SHORTEST, HIGHEST = 0.005, 2.0  # m
ROUNDING = 1e-6  # of a size


def named(body: Body) -> Iterator[Breach]:
    """An object has a name that a spec can write."""
    yield from is_named(body.name)


def told(body: Body) -> Iterator[Breach]:
    """One line says what it is."""
    yield from is_told(body.about)


def solid(body: Body) -> Iterator[Breach]:
    """It encloses a volume, and its moments of inertia are those of a possible body."""
    found = body.shape.solid
    if not (np.isfinite(found.volume) and found.volume > 0.0 and np.isfinite(found.centre).all()):
        yield f"its volume is {found.volume:g} m³", "give it a closed shape"
        return
    moments, _ = found.principal(body.mass)
    if not ((moments > 0.0).all() and 2.0 * moments.max() <= moments.sum() * (1.0 + ROUNDING)):
        yield f"its moments of inertia are {shown(moments)} kg m²", "none can be larger than the two others together"


def mass(body: Body) -> Iterator[Breach]:
    """Its mass is that of something that there is."""
    density = body.mass / body.shape.solid.volume
    if not LIGHTEST <= density <= HEAVIEST:
        yield f"{body.mass:g} kg in its volume are {density:.3g} kg/m³", "give the mass in kg and lengths in m"


def size(body: Body) -> Iterator[Breach]:
    """It fits on the table, and a hand can see it; its origin is at half its height."""
    x, y, z = body.shape.extent
    if max(x, y) > min(TABLE_SIZE[:2]) or z > HIGHEST:
        yield f"it is {x:g} × {y:g} × {z:g} m large, the table {TABLE_SIZE[0]:g} m", "give lengths in m"
    elif min(x, y, z) < SHORTEST:
        yield f"it is {x:g} × {y:g} × {z:g} m small", "give lengths in m"
    up, down = (body.shape.support(np.array([0.0, 0.0, sign])) for sign in (1.0, -1.0))
    if abs(up - down) > ROUNDING * z:
        yield f"it reaches {up:g} m up and {down:g} m down", "put its origin at half its height"


def standing(body: Body) -> Iterator[Breach]:
    """It stands as it is put down, with z up: its centre of mass is nowhere lower near by."""
    angle = fall_of(body.shape)
    if angle > 0.0:
        yield f"put down upright, it tips by {np.degrees(angle):.0f}°", "turn it, or give it a broader foot"


def rest(body: Body) -> Iterator[Breach]:
    """The engine brings it to rest on the table."""
    from graspdsl.worlds.rigid.settling import resting_pose

    kind = rigid_bodies()
    try:
        resting_pose(kind.engine(kind.effort), body, TABLE_FRICTION, GRAVITY)
    except UnstableObjectError as error:
        yield str(error), "turn it, or give it a broader foot"


RULES = contract(named, told, solid, mass, size, standing, rest, name=lambda body: body.name, wording=(told,))
