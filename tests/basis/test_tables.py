"""What holds of the tables of the basis as a whole, and the effector transforms against models of their own.

What each entry has to keep by itself is in ``graspdsl.contracts``.
"""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.basis import spaces
from graspdsl.basis.effectors import EFFECTORS, Effector
from graspdsl.basis.potentials import POTENTIALS, displaced_in, lowering
from graspdsl.basis.sensors import SENSORS, measuring
from graspdsl.basis.spaces import NET_FORCE, NET_MOMENT, NET_WRENCH, GradientSpace, TaskSpace
from graspdsl.contracts.differences import central_differences
from graspdsl.contracts.drawing import Resources, drawn, free_to_move, moved_and_sensed, moved_by, sensed_by, sets_of
from graspdsl.contracts.motions import COLUMNS
from graspdsl.spec.program import Until

from .coordinates import COORDINATES, Coordinates
from .models import MODELS

ROWS = {NET_FORCE: 3, NET_MOMENT: 3, NET_WRENCH: 6}
MOVED = [
    pytest.param(effector, moved, sensed, id=f"{symbol}-{number}")
    for symbol, effector in EFFECTORS.items()
    for number, (moved, sensed) in enumerate(moved_and_sensed(effector, SENSORS[MODELS[symbol].sensor]))
]


def test_every_bound_of_a_phase_is_lowered_and_every_residual_measured() -> None:
    bounds = set(Until.model_fields) - {"contact", "hold"}
    assert set(lowering()) == bounds
    assert all(name in potential.lowers for name, found in lowering().items() for potential in found)
    assert [measuring(name).symbol for name in ("force_residual", "moment_residual")] == ["σ_fr", "σ_mr"]


@pytest.mark.parametrize("effector", EFFECTORS.values(), ids=EFFECTORS)
def test_effector_belongs_to_one_potential(effector: Effector) -> None:
    owners = [potential for potential in POTENTIALS.values() if effector.symbol in potential.effectors]
    assert len(owners) == 1
    assert MODELS[effector.symbol].sensor in owners[0].sensors


def test_a_displacement_moves_the_reference_of_one_potential() -> None:
    """Contacts are displaced in x and turned in r; ψ and q are no displacements of what is sensed."""
    displaced = [potential.displaced_by for potential in POTENTIALS.values() if potential.displaced_by is not None]
    assert sorted(space.value for space in displaced) == ["r", "x"]
    assert all(displaced_in(space).displaced_by is space for space in displaced)


def test_every_task_space_is_sensed_and_every_gradient_space_moved() -> None:
    known = {space for space in vars(spaces).values() if isinstance(space, TaskSpace)}
    assert {sensor.space for sensor in SENSORS.values()} == known
    assert {effector.gradient_space for effector in EFFECTORS.values()} == set(GradientSpace)
    assert set(COLUMNS) == set(GradientSpace)


@pytest.mark.parametrize("space", ROWS, ids=lambda space: space.name)
def test_a_net_has_as_many_numbers_as_its_space(space: TaskSpace) -> None:
    [sensor] = [known for known in SENSORS.values() if known.space == space]
    assert {sensed_by(sensor, some, next(drawn(some))).shape for some in sets_of(sensor).values()} == {(ROWS[space],)}


def test_every_effector_has_a_model() -> None:
    assert set(MODELS) == set(EFFECTORS)


@pytest.mark.parametrize("coordinates", COORDINATES, ids=lambda coordinates: coordinates.name)
@pytest.mark.parametrize(("effector", "moved", "sensed"), MOVED)
def test_effector_is_the_derivative_under_its_model(
    effector: Effector, moved: Resources, sensed: Resources, coordinates: Coordinates
) -> None:
    model = MODELS[effector.symbol]
    free = free_to_move(effector, moved)
    for at_rest in islice(drawn(sensed, coordinates=coordinates), 5):

        def read(displacement: Array, at_rest: dict[str, Array] = at_rest) -> Array:
            parts = []
            for part in model.parts:
                after = part.moved(at_rest, free * displacement, coordinates)
                value = sensed_by(SENSORS[part.sensor], sensed, after)
                parts.append(value.ravel() / (at_rest[part.unit] if part.unit else 1.0))
            return np.concatenate(parts)

        derivative = moved_by(effector, moved, sensed, at_rest)
        differences = central_differences(read, np.zeros(COLUMNS[effector.gradient_space]))
        np.testing.assert_allclose(derivative, differences, atol=1e-8)
