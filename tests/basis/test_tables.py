"""Checks that every potential, sensor transform and effector transform of the tables has to pass."""

from __future__ import annotations

import re

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.basis.effectors import EFFECTORS, Effector
from graspdsl.basis.potentials import POTENTIALS, Potential
from graspdsl.basis.resources import ContactSet
from graspdsl.basis.sensors import SENSORS, Sensor
from graspdsl.basis.spaces import DISPLACES, GradientSpace, TaskSpace

from .differences import central_differences
from .drawing import JOINTS, generator, inputs
from .models import MODELS
from .resource_sets import CONTACTS, SETS

EACH_POTENTIAL = pytest.mark.parametrize("potential", POTENTIALS.values(), ids=POTENTIALS)
EACH_SENSOR = pytest.mark.parametrize("sensor", SENSORS.values(), ids=SENSORS)
EACH_EFFECTOR = pytest.mark.parametrize("effector", EFFECTORS.values(), ids=EFFECTORS)
EACH_ENTRY = pytest.mark.parametrize(
    "entry", [*POTENTIALS.values(), *SENSORS.values(), *EFFECTORS.values()], ids=[*POTENTIALS, *SENSORS, *EFFECTORS]
)
EACH_SET = pytest.mark.parametrize("resources", SETS.values(), ids=SETS)

UNITS = r"\[[^]]*\b(1|m|N|rad)\b[^]]*\]|\bDimensionless\b|\bIn (m|N|rad)[²·]*\b"
ROWS = {TaskSpace.NET_FORCE: 3, TaskSpace.NET_MOMENT: 3}
COLUMNS = {
    GradientSpace.SURFACE: 2 * CONTACTS,
    GradientSpace.CARTESIAN: 3 * CONTACTS,
    GradientSpace.JOINTS: JOINTS,
}


def mixing_of(entry: Sensor | Effector, resources: ContactSet) -> Array:
    """The mixing that a transform takes: a row for each resource, or the weights of a sum."""
    by_row = entry.per_contact if isinstance(entry, Sensor) else entry.gradient_space is GradientSpace.JOINTS
    return resources.matrix if by_row else resources.weights


def rows_of(space: TaskSpace, resources: ContactSet) -> int:
    """The numbers of a task space."""
    return ROWS.get(space, 3 * len(resources.members))


@EACH_ENTRY
def test_docstring_has_symbol_source_and_unit(entry: Potential | Sensor | Effector) -> None:
    text = type(entry).__doc__ or ""
    assert text.startswith(entry.symbol)
    assert f"Eq. {entry.equation}" in text or f"Sec. {entry.equation}" in text
    assert re.search(UNITS, text)
    assert entry.about


@pytest.mark.parametrize(("table", "head"), [(POTENTIALS, "φ_"), (SENSORS, "σ_"), (EFFECTORS, "τ_")], ids="φστ")
def test_entries_are_found_by_their_own_symbol(table: dict[str, Potential | Sensor | Effector], head: str) -> None:
    assert all(symbol == entry.symbol and symbol.startswith(head) for symbol, entry in table.items())


@EACH_POTENTIAL
def test_gradient_of_potential(potential: Potential) -> None:
    for error in generator().normal(size=(20, 6)):
        slope = central_differences(potential.value, error)
        np.testing.assert_allclose(potential.gradient(error), slope, atol=1e-8)


@EACH_POTENTIAL
def test_potential_is_least_at_no_error(potential: Potential) -> None:
    assert potential.value(np.zeros(6)) == 0.0
    assert np.all(potential.value(generator().normal(size=(20, 6))) > 0.0)


@EACH_POTENTIAL
def test_potential_takes_batches(potential: Potential) -> None:
    errors = generator().normal(size=(2, 3, 6))
    for function in (potential.value, potential.gradient):
        one_by_one = [[function(error) for error in row] for row in errors]
        np.testing.assert_array_equal(function(errors), one_by_one)


@EACH_POTENTIAL
def test_parts_of_a_potential_exist_and_agree(potential: Potential) -> None:
    assert potential.sensors
    assert potential.effectors
    assert {SENSORS[symbol].space for symbol in potential.sensors} == {potential.space}
    assert {MODELS[symbol].sensor for symbol in potential.effectors} <= set(potential.sensors)
    assert set(potential.references) <= set(SENSORS)
    sizes = {SENSORS[symbol].per_contact for symbol in (*potential.sensors, *potential.references)}
    assert len(sizes) == 1


@EACH_EFFECTOR
def test_effector_belongs_to_a_potential(effector: Effector) -> None:
    assert [potential.symbol for potential in POTENTIALS.values() if effector.symbol in potential.effectors]


def test_displaced_spaces_have_a_potential() -> None:
    assert set(DISPLACES.values()) <= {potential.space for potential in POTENTIALS.values()}


@EACH_SET
@EACH_SENSOR
def test_sensor_shape_and_batches(sensor: Sensor, resources: ContactSet) -> None:
    mixing = mixing_of(sensor, resources)
    batch = inputs(generator(), CONTACTS, 2, 3)
    shape = (len(resources.members), 3) if sensor.per_contact else (3,)
    whole = sensor.evaluate(mixing, *[batch[name] for name in sensor.reads])
    assert whole.shape == (2, 3, *shape)
    for place in np.ndindex(2, 3):
        one = sensor.evaluate(mixing, *[_at(batch[name], place) for name in sensor.reads])
        np.testing.assert_allclose(whole[place], one, atol=1e-14)


@EACH_SET
@EACH_EFFECTOR
def test_effector_shape_and_batches(effector: Effector, resources: ContactSet) -> None:
    mixing = mixing_of(effector, resources)
    batch = inputs(generator(), CONTACTS, 2, 3)
    rows = rows_of(SENSORS[MODELS[effector.symbol].sensor].space, resources)
    whole = effector.evaluate(mixing, *[batch[name] for name in effector.reads])
    assert whole.shape == (2, 3, rows, COLUMNS[effector.gradient_space])
    for place in np.ndindex(2, 3):
        one = effector.evaluate(mixing, *[_at(batch[name], place) for name in effector.reads])
        np.testing.assert_allclose(whole[place], one, atol=1e-14)


def _at(value: Array, place: tuple[int, ...]) -> Array:
    return value[place] if value.ndim else value


def test_every_effector_has_a_model() -> None:
    assert set(MODELS) == set(EFFECTORS)


@EACH_SET
@EACH_EFFECTOR
def test_effector_is_the_derivative_under_its_model(effector: Effector, resources: ContactSet) -> None:
    model = MODELS[effector.symbol]
    sensor = SENSORS[model.sensor]
    random = generator()
    for _ in range(5):
        at_rest = inputs(random, CONTACTS)

        def sensed(displacement: Array, at_rest: dict[str, Array] = at_rest) -> Array:
            moved = model.moved(at_rest, displacement)
            return sensor.evaluate(mixing_of(sensor, resources), *[moved[name] for name in sensor.reads]).ravel()

        derivative = effector.evaluate(mixing_of(effector, resources), *[at_rest[name] for name in effector.reads])
        differences = central_differences(sensed, np.zeros(COLUMNS[effector.gradient_space]))
        np.testing.assert_allclose(derivative, differences, atol=1e-8)
