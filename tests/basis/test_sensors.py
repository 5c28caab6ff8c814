"""Sensor transforms against their definitions, written out contact by contact: Eq. 4.10 to 4.15, 4.32, 4.35 to 4.37."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.basis.resources import ContactResource, ContactSet, JointSet
from graspdsl.basis.sensors import SENSORS
from graspdsl.contracts.drawing import CONTACTS, JOINT_SETS, SETS, WITH_GRAVITY, generator, inputs, with_gravity

Reading = Callable[[Mapping[str, Array], int], Array]

# What a single contact, or gravity, senses.
OF_ONE: Mapping[str, Reading] = {
    "σ_n": lambda given, i: given["normals"][i],
    "σ_p": lambda given, i: given["points"][i],
    "σ_f": lambda given, i: (given["forces"][i] @ given["normals"][i]) * given["normals"][i],
    "σ_r": lambda given, i: given["orientations"][i],
    "σ_m": lambda given, i: np.cross(
        given["points"][i] - given["origin"], (given["forces"][i] @ given["normals"][i]) * given["normals"][i]
    ),
    "σ_fr": lambda given, i: given["normals"][i],
    "σ_mr": lambda given, i: np.cross(given["points"][i] - given["origin"], given["normals"][i]),
    "σ_w": lambda given, i: np.concatenate(
        [
            given["normals"][i],
            np.cross(given["points"][i] - given["origin"], given["normals"][i]) / given["curvature_radius"],
        ]
    ),
}
FEELS_GRAVITY = [symbol for symbol in OF_ONE if SENSORS[symbol].feels_gravity]


def of_resource(reading: Reading, given: Mapping[str, Array], resource: ContactResource) -> Array:
    """A mean over the members of a virtual contact (Eq. 4.32), whose weights sum to one."""
    return sum((weight * reading(given, contact) for contact, weight in resource.weights), start=np.zeros(1))


def _checked(symbol: str, resources: ContactSet, given: Mapping[str, Array]) -> None:
    sensor = SENSORS[symbol]
    expected = np.stack([of_resource(OF_ONE[symbol], given, member) for member in resources.members])
    mixing = resources.matrix if sensor.per_contact else resources.weights
    found = sensor.evaluate(mixing, *[given[name] for name in sensor.reads])
    np.testing.assert_allclose(found, expected if sensor.per_contact else expected.sum(axis=0), atol=1e-14)


@pytest.mark.parametrize("resources", SETS.values(), ids=SETS)
@pytest.mark.parametrize("symbol", OF_ONE)
def test_sensor_of_contacts(symbol: str, resources: ContactSet) -> None:
    random = generator()
    for _ in range(10):
        _checked(symbol, resources, inputs(random, CONTACTS))


@pytest.mark.parametrize("resources", WITH_GRAVITY.values(), ids=WITH_GRAVITY)
@pytest.mark.parametrize("symbol", FEELS_GRAVITY)
def test_sensor_of_contacts_and_gravity(symbol: str, resources: ContactSet) -> None:
    """Gravity stands behind the contacts: at the centre of mass, its force the weight, its normal straight down."""
    random = generator()
    for _ in range(10):
        _checked(symbol, resources, with_gravity(inputs(random, CONTACTS)))


def test_only_an_orientation_is_not_gravitys() -> None:
    assert [symbol for symbol, sensor in SENSORS.items() if not sensor.feels_gravity] == ["σ_r"]


@pytest.mark.parametrize("resources", JOINT_SETS.values(), ids=JOINT_SETS)
def test_posture_is_the_joints_of_the_set_in_its_order(resources: JointSet) -> None:
    joints = inputs(generator(), CONTACTS)["joints"]
    np.testing.assert_array_equal(SENSORS["σ_k"].evaluate(resources.matrix, joints), joints[list(resources.joints)])


def test_every_sensor_is_checked() -> None:
    assert {*OF_ONE, "σ_k"} == set(SENSORS)


def test_moment_of_a_virtual_contact_is_the_mean_moment_not_the_moment_of_means() -> None:
    given, resources = inputs(generator(), CONTACTS), SETS["virtual"]
    found = SENSORS["σ_mr"].evaluate(resources.weights, given["points"], given["normals"], given["origin"])
    points, normals = (resources.matrix @ given[name] for name in ("points", "normals"))
    of_means = np.cross(points - given["origin"], normals).sum(axis=0)
    assert np.linalg.norm(found - of_means) > 0.1 * np.linalg.norm(found)


def test_residuals_of_opposed_contacts_are_nothing() -> None:
    """Two contacts across a sphere, and the wrench of one alone about another point."""
    points = np.array([[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0]])
    normals, origin, radius = -points / 0.1, np.array([1.0, 2.0, 3.0]), np.array(0.1)
    wrench = SENSORS["σ_w"].evaluate(np.ones(2), points, normals, origin, radius)
    np.testing.assert_allclose(wrench, 0.0, atol=1e-12)
    alone = SENSORS["σ_w"].evaluate(np.array([1.0, 0.0]), points, normals, origin, radius)
    np.testing.assert_allclose(alone, [-1.0, 0.0, 0.0, 0.0, 30.0, -20.0], atol=1e-12)


def test_friction_is_no_force_along_the_normal() -> None:
    given = inputs(generator(), CONTACTS)
    across = given["forces"] - np.sum(given["forces"] * given["normals"], axis=-1, keepdims=True) * given["normals"]
    for symbol in ("σ_f", "σ_m"):
        read = [{**given, "forces": across}[name] for name in SENSORS[symbol].reads]
        np.testing.assert_allclose(SENSORS[symbol].evaluate(SETS["plain"].matrix, *read), 0.0, atol=1e-14)
