"""The contract of effector transforms."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.effectors import EFFECTORS, Effector
from graspdsl.basis.potentials import POTENTIALS
from graspdsl.basis.sensors import SENSORS, Sensor
from graspdsl.contracts.differences import central_differences
from graspdsl.contracts.drawing import (
    READABLE,
    SPHERICAL,
    TANGENT,
    Coordinates,
    Inputs,
    Resources,
    drawn,
    free_to_move,
    moved_and_sensed,
    moved_by,
    moving,
    one_of,
    sensed_by,
    sets_of,
)
from graspdsl.contracts.entries import misplaced, misspelt, not_one_by_one, not_pure, undocumented, unreadable
from graspdsl.contracts.motions import COLUMNS, MOTIONS, Motion
from graspdsl.contracts.rule import Breach, contract
from graspdsl.declared import misdeclared

BATCH = (2, 3)
DRAWS = 3
ALLOWED = 1e-7


def declared(effector: Effector) -> Iterator[Breach]:
    """What an effector transform says of itself is there, and of the right type."""
    yield from misdeclared(effector, Effector)


def symbol(effector: Effector) -> Iterator[Breach]:
    """An effector transform is called τ_…, in every spelling."""
    yield from misspelt(effector, "τ")


def table(effector: Effector) -> Iterator[Breach]:
    """An effector transform is found by its own symbol."""
    yield from misplaced(effector, EFFECTORS)


def docstring(effector: Effector) -> Iterator[Breach]:
    """A docstring tells symbol, source and unit."""
    yield from undocumented(effector)


def reads(effector: Effector) -> Iterator[Breach]:
    """What it reads, an observation or the compiler has."""
    yield from unreadable(effector.reads)


def potential(effector: Effector) -> Iterator[Breach]:
    """Some potential is joined with it."""
    if not any(effector.symbol in known.effectors for known in POTENTIALS.values()):
        yield f"no potential names {effector.symbol}", "name it among the effectors of a potential"


def shape(effector: Effector) -> Iterator[Breach]:
    """τ is finite, (..., d, D): a row for each number that is sensed, a column for each that is moved."""
    for sensor in _sensors(effector):
        for moved, sensed in moved_and_sensed(effector, sensor):
            given = next(drawn(sensed, *BATCH))
            found = moved_by(effector, moved, sensed, given)
            rows = sensed_by(sensor, sensed, next(drawn(sensed))).size
            wanted = (rows, COLUMNS[effector.gradient_space])
            if found.shape not in (wanted, (*BATCH, *wanted)):
                of = f"{sensor.symbol} and {effector.gradient_space.value}"
                yield f"it gives {found.shape[-2:]} for {wanted} of {of}", "give (..., d, D)"
            elif not np.isfinite(found).all():
                yield "it gives numbers that are not finite", "mind divisors and roots that can be zero"
            else:
                continue
            return


def batches(effector: Effector) -> Iterator[Breach]:
    """Many trials at once are moved as one by one."""
    for sensor in _sensors(effector):
        for moved, sensed in moved_and_sensed(effector, sensor):
            batch = next(drawn(sensed, *BATCH))
            whole = moved_by(effector, moved, sensed, batch)
            each = [moved_by(effector, moved, sensed, one_of(batch, place)) for place in np.ndindex(BATCH)]
            breaches = list(not_one_by_one(np.broadcast_to(whole, (*BATCH, *whole.shape[-2:])), each))
            yield from breaches
            if breaches:
                return


def pure(effector: Effector) -> Iterator[Breach]:
    """It leaves what it reads as it is, and keeps nothing."""
    for sensor in _sensors(effector):
        moved, sensed = next(iter(moved_and_sensed(effector, sensor)))
        given = next(drawn(sensed, *BATCH))
        yield from not_pure(
            effector.evaluate, moving(effector, moved, sensed), *[given[name] for name in effector.reads]
        )


def moves(effector: Effector) -> Iterator[Breach]:
    """What it moves changes what is sensed."""
    for sensor in _sensors(effector):
        pairs = moved_and_sensed(effector, sensor)
        if not any(way.any() for pair in pairs for ways in _differences(effector, sensor, *pair) for way in ways):
            space = effector.gradient_space.about
            yield f"{sensor.symbol} does not change by {space}", "move what is sensed, or sense what is moved"


def derivative(effector: Effector) -> Iterator[Breach]:
    """Each row is the derivative of what is sensed along a motion that its gradient space can mean, by differences.

    On a surface: contacts slide over the model sphere, or along their tangent planes; the chapter has the force from
    the one and the moment from the other. A motion that leaves the row as it is does not count where another changes
    it.
    """
    for sensor in _sensors(effector):
        for coordinates in (TANGENT, SPHERICAL):
            for moved, sensed in moved_and_sensed(effector, sensor):
                found = _over_draws(effector, moved, sensed, coordinates)
                ways = _differences(effector, sensor, moved, sensed, coordinates)
                if found.shape != ways[0].shape:
                    return  # for the rule of shapes
                breach = _unlike(effector, sensor, found, ways)
                if breach is not None:
                    yield breach
                    return


RULES = contract(
    declared, symbol, table, docstring, reads, potential, shape, batches, pure, moves, derivative, wording=(docstring,)
)


def _sensors(effector: Effector) -> list[Sensor]:
    """The sensor transforms of the potentials that are joined with it; none for one that reads what there is not."""
    names = dict.fromkeys(
        name for known in POTENTIALS.values() if effector.symbol in known.effectors for name in known.sensors
    )
    known = [SENSORS[name] for name in names if name in SENSORS] if set(effector.reads) <= set(READABLE) else []
    return [sensor for sensor in known if sets_of(sensor)]


def _draws(sensed: Resources, coordinates: Coordinates) -> Iterator[dict[str, Array]]:
    return islice(drawn(sensed, coordinates=coordinates), DRAWS)


def _over_draws(effector: Effector, moved: Resources, sensed: Resources, coordinates: Coordinates) -> Array:
    """τ (draws, d, D)."""
    return np.stack([moved_by(effector, moved, sensed, given) for given in _draws(sensed, coordinates)])


def _differences(
    effector: Effector, sensor: Sensor, moved: Resources, sensed: Resources, coordinates: Coordinates = TANGENT
) -> list[Array]:
    """By motion: the derivative (draws, d, D) of what is sensed along it."""
    free = free_to_move(effector, moved)

    def along(motion: Motion, given: Inputs) -> Array:
        def read(displacement: Array) -> Array:
            return sensed_by(sensor, sensed, motion(given, free * displacement)).ravel()

        return central_differences(read, np.zeros(COLUMNS[effector.gradient_space]))

    motions = MOTIONS[effector.gradient_space].values()
    return [np.stack([along(motion, given) for given in _draws(sensed, coordinates)]) for motion in motions]


def _unlike(effector: Effector, sensor: Sensor, found: Array, ways: list[Array]) -> Breach | None:
    """The first row that is no derivative along any motion."""
    told = list(MOTIONS[effector.gradient_space])
    for row in range(found.shape[1]):
        changing = [way for way in range(len(ways)) if np.abs(ways[way][:, row]).max() > ALLOWED]
        candidates = changing or list(range(len(ways)))
        off = {way: np.abs(found[:, row] - ways[way][:, row]).max() for way in candidates}
        nearest = min(off, key=lambda way: off[way])
        if not off[nearest] <= ALLOWED * max(1.0, np.abs(ways[nearest][:, row]).max()):
            return (
                f"row {row + 1} is not the derivative of {sensor.symbol}: off by {off[nearest]:.2g} of "
                f"{np.abs(ways[nearest][:, row]).max():.2g} where {told[nearest]}",
                f"give ∂{sensor.symbol}/∂{effector.gradient_space.value} where {' or '.join(told)}",
            )
    return None
