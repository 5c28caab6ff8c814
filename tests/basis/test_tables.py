"""Checks that every potential, sensor transform and effector transform of the tables has to pass."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import islice, product
from typing import Any

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.basis import spaces
from graspdsl.basis.effectors import EFFECTORS, Effector
from graspdsl.basis.potentials import POTENTIALS, Potential, displaced_in, lowering
from graspdsl.basis.resources import ContactSet, JointSet
from graspdsl.basis.sensors import SENSORS, Sensor, measuring
from graspdsl.basis.spaces import NET_FORCE, NET_MOMENT, NET_WRENCH, GradientSpace, TaskSpace
from graspdsl.spec.program import Control, Until

from .coordinates import COORDINATES, Coordinates
from .differences import central_differences
from .drawing import JOINTS, generator, inputs, with_gravity
from .models import MODELS
from .resource_sets import CONTACTS, JOINT_SETS, SETS, WITH_GRAVITY

EACH_POTENTIAL = pytest.mark.parametrize("potential", POTENTIALS.values(), ids=POTENTIALS)
EACH_EFFECTOR = pytest.mark.parametrize("effector", EFFECTORS.values(), ids=EFFECTORS)
EACH_ENTRY = pytest.mark.parametrize(
    "entry", [*POTENTIALS.values(), *SENSORS.values(), *EFFECTORS.values()], ids=[*POTENTIALS, *SENSORS, *EFFECTORS]
)
EACH_COORDINATES = pytest.mark.parametrize("coordinates", COORDINATES, ids=lambda coordinates: coordinates.name)

UNITS = r"\[[^]]*\b(1|m|N|rad)\b[^]]*\]|\bDimensionless\b|\bIn (m|N|rad|\(N·m\))[²·]*\b"
ROWS = {NET_FORCE: 3, NET_MOMENT: 3, NET_WRENCH: 6}
COLUMNS = {
    GradientSpace.SURFACE: 2 * CONTACTS,
    GradientSpace.CARTESIAN: 3 * CONTACTS,
    GradientSpace.ROTATION: 3,
    GradientSpace.JOINTS: JOINTS,
}


Resources = ContactSet | JointSet


def moves_joint_sets(effector: Effector) -> bool:
    """Whether an effector transform takes sets of joints."""
    return SENSORS[MODELS[effector.symbol].sensor].over_joints


SENSED = [
    pytest.param(sensor, resources, id=f"{symbol}-{name}")
    for symbol, sensor in SENSORS.items()
    for name, resources in (JOINT_SETS if sensor.over_joints else SETS).items()
]


def pairs(effector: Effector) -> list[tuple[tuple[str, Resources], tuple[str, Resources]]]:
    """What is moved and what is sensed: one set of contacts, or any two of joints; a turn moves what any set senses."""
    if moves_joint_sets(effector):
        return list(product(JOINT_SETS.items(), repeat=2))
    if effector.gradient_space is GradientSpace.ROTATION:
        return list(product([("some", SETS["some"])], (SETS | WITH_GRAVITY).items()))
    return [((name, same), (name, same)) for name, same in SETS.items()]


MOVED = [
    pytest.param(effector, moved, sensed, id=f"{symbol}-{one}-{other}")
    for symbol, effector in EFFECTORS.items()
    for (one, moved), (other, sensed) in pairs(effector)
]
EACH_SENSED = pytest.mark.parametrize(("sensor", "resources"), SENSED)
EACH_MOVED = pytest.mark.parametrize(("effector", "moved", "sensed"), MOVED)


def sensing(sensor: Sensor, resources: ContactSet | JointSet) -> Array:
    """The mixing that a sensor transform takes: a row for each resource, or the weights of a sum."""
    return resources.matrix if isinstance(resources, JointSet) or sensor.per_contact else resources.weights


def moving(effector: Effector, moved: ContactSet | JointSet, sensed: ContactSet | JointSet) -> Array:
    """The mixing that an effector transform takes."""
    if isinstance(moved, JointSet):
        return sensed.matrix * np.isin(np.arange(JOINTS), moved.joints)
    if effector.gradient_space is GradientSpace.ROTATION:
        assert isinstance(sensed, ContactSet)
        return sensed.turning
    return moved.matrix if effector.gradient_space is GradientSpace.JOINTS else moved.weights


def drawn(sensed: ContactSet | JointSet, *batch: int, **options: Any) -> Iterator[dict[str, Array]]:
    """Inputs without end, with gravity behind the contacts where it is sensed."""
    random = generator()
    while True:
        given = inputs(random, CONTACTS, *batch, **options)
        yield with_gravity(given, random) if isinstance(sensed, ContactSet) and sensed.has_gravity else given


def rows_of(space: TaskSpace, resources: ContactSet | JointSet) -> int:
    """The numbers of a task space."""
    if isinstance(resources, JointSet):
        return len(resources.joints)
    return ROWS.get(space, 3 * len(resources.members))


@EACH_ENTRY
def test_docstring_has_symbol_source_and_unit(entry: Potential | Sensor | Effector) -> None:
    text = " ".join((type(entry).__doc__ or "").split())
    assert text.startswith(entry.symbol)
    assert f"Eq. {entry.equation}" in text or ("Sec." in entry.equation and entry.equation in text)
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
    for kind in ("per_contact", "over_joints"):
        assert len({getattr(SENSORS[symbol], kind) for symbol in (*potential.sensors, *potential.references)}) == 1
    assert potential.references or not potential.has_default_reference


@EACH_POTENTIAL
def test_difference_takes_one_place_to_the_other(potential: Potential) -> None:
    """The displacement between two places, made at the one, leads to the other; none leads nowhere; in batches too."""
    difference = potential.difference
    end, start = generator().normal(scale=0.5, size=(2, 20, 4, 3))
    between = difference.between(end, start)
    np.testing.assert_allclose(difference.displaced(between, start), end, atol=1e-12)
    np.testing.assert_allclose(difference.displaced(np.zeros_like(start), start), start, atol=1e-12)
    assert between.shape == start.shape
    for row in range(len(start)):
        np.testing.assert_allclose(between[row], difference.between(end[row], start[row]), atol=1e-14)


@EACH_POTENTIAL
def test_settings_that_a_potential_names_exist(potential: Potential) -> None:
    """A gain that may be zero, and what is said then; end conditions; potentials that it is normal to."""
    assert not potential.law.gain or (potential.law.gain in Control.model_fields and potential.law.without)
    assert set(potential.lowers) <= set(Until.model_fields)
    assert set(potential.normal_to) <= set(POTENTIALS)
    assert not (potential.is_residual and potential.references)
    assert potential.references or not (potential.displaced_by or potential.is_capped)


def test_every_bound_of_a_phase_is_lowered_and_every_residual_measured() -> None:
    bounds = set(Until.model_fields) - {"contact", "hold"}
    assert set(lowering()) == bounds
    assert all(name in potential.lowers for name, found in lowering().items() for potential in found)
    assert [measuring(name).symbol for name in ("force_residual", "moment_residual")] == ["σ_fr", "σ_mr"]


@EACH_EFFECTOR
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


@EACH_SENSED
def test_sensor_shape_and_batches(sensor: Sensor, resources: ContactSet | JointSet) -> None:
    mixing = sensing(sensor, resources)
    batch = inputs(generator(), CONTACTS, 2, 3)
    per_contact = isinstance(resources, ContactSet) and sensor.per_contact
    shape = (len(resources.members), 3) if per_contact else (rows_of(sensor.space, resources),)
    whole = sensor.evaluate(mixing, *[batch[name] for name in sensor.reads])
    assert whole.shape == (2, 3, *shape)
    for place in np.ndindex(2, 3):
        one = sensor.evaluate(mixing, *[_at(batch, name, place) for name in sensor.reads])
        np.testing.assert_allclose(whole[place], one, atol=1e-14)


@EACH_COORDINATES
@EACH_MOVED
def test_effector_shape_and_batches(
    effector: Effector, moved: ContactSet | JointSet, sensed: ContactSet | JointSet, coordinates: Coordinates
) -> None:
    mixing = moving(effector, moved, sensed)
    batch = next(drawn(sensed, 2, 3, coordinates=coordinates))
    rows = rows_of(SENSORS[MODELS[effector.symbol].sensor].space, sensed)
    whole = effector.evaluate(mixing, *[batch[name] for name in effector.reads])
    columns = COLUMNS[effector.gradient_space]
    assert whole.shape == ((rows, columns) if moves_joint_sets(effector) else (2, 3, rows, columns))
    for place in np.ndindex(2, 3):
        one = effector.evaluate(mixing, *[_at(batch, name, place) for name in effector.reads])
        np.testing.assert_allclose(np.broadcast_to(whole, (2, 3, rows, columns))[place], one, atol=1e-14)


def _at(batch: dict[str, Array], name: str, place: tuple[int, ...]) -> Array:
    shared = name in {"curvature_radius", "joint_weights"}
    return batch[name] if shared else batch[name][place]


def test_every_effector_has_a_model() -> None:
    assert set(MODELS) == set(EFFECTORS)


@EACH_COORDINATES
@EACH_MOVED
def test_effector_is_the_derivative_under_its_model(
    effector: Effector, moved: ContactSet | JointSet, sensed: ContactSet | JointSet, coordinates: Coordinates
) -> None:
    model = MODELS[effector.symbol]
    mask = np.isin(np.arange(JOINTS), moved.joints) if isinstance(moved, JointSet) else 1.0
    for at_rest in islice(drawn(sensed, coordinates=coordinates), 5):

        def read(displacement: Array, at_rest: dict[str, Array] = at_rest) -> Array:
            parts = []
            for part in model.parts:
                after, sensor = part.moved(at_rest, mask * displacement, coordinates), SENSORS[part.sensor]
                value = sensor.evaluate(sensing(sensor, sensed), *[after[name] for name in sensor.reads])
                parts.append(value.ravel() / (at_rest[part.unit] if part.unit else 1.0))
            return np.concatenate(parts)

        derivative = effector.evaluate(moving(effector, moved, sensed), *[at_rest[name] for name in effector.reads])
        differences = central_differences(read, np.zeros(COLUMNS[effector.gradient_space]))
        np.testing.assert_allclose(derivative, differences, atol=1e-8)
