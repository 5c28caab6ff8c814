"""What transforms are tried on: random contacts, the same for each run, and sets of them, of gravity and of joints."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import spherical_frames, spherical_stretch, tangent_frames
from graspdsl.basis.effectors import Effector, sphere_by_cartesian
from graspdsl.basis.operations import transposed_times
from graspdsl.basis.resources import ContactResource, ContactSet, JointSet
from graspdsl.basis.sensors import Sensor
from graspdsl.basis.spaces import GradientSpace

CONTACTS, JOINTS = 4, 5
GRAVITY = CONTACTS  # its index, behind those of the contacts
SHARED = ("curvature_radius", "joint_weights", "origin_shares")  # of the scene and of the hand: without leading axes

Inputs = Mapping[str, Array]
Resources = ContactSet | JointSet


@dataclass(frozen=True)
class Coordinates:
    """Surface coordinates by the name of their control setting: frames (..., 3, 2) and stretch (..., 2) of normals."""

    name: str
    frames: Callable[[Array], Array]
    stretch: Callable[[Array], Array]


TANGENT = Coordinates("tangent", tangent_frames, lambda normals: np.ones((*normals.shape[:-1], 2)))
SPHERICAL = Coordinates("spherical", spherical_frames, spherical_stretch)


def generator() -> np.random.Generator:
    """A fresh generator of random numbers."""
    return np.random.default_rng(7)


def unit_vectors(random: np.random.Generator, *shape: int) -> Array:
    """Directions spread evenly over the sphere, (*shape, 3)."""
    vectors = random.normal(size=(*shape, 3))
    unit: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return unit


def inputs(
    random: np.random.Generator, contacts: int, *batch: int, coordinates: Coordinates = TANGENT
) -> dict[str, Array]:
    """Everything that a sensor or effector transform may read, for contacts on a hand with JOINTS joints."""
    drawn = {
        "points": random.normal(size=(*batch, contacts, 3)),
        "normals": unit_vectors(random, *batch, contacts),
        "forces": random.normal(size=(*batch, contacts, 3)),
        "jacobian": random.normal(size=(*batch, contacts, 3, JOINTS)),
        "angular_jacobian": random.normal(size=(*batch, contacts, 3, JOINTS)),
        "orientations": random.normal(size=(*batch, contacts, 3)),
        "joints": random.normal(size=(*batch, JOINTS)),
        "joint_weights": random.uniform(0.5, 10.0, size=JOINTS),
        "origin": random.normal(size=(*batch, 3)),
        "origin_shares": random.uniform(0.1, 0.5, size=contacts),
        "curvature_radius": np.array(0.37),
        "centre_of_mass": random.normal(size=(*batch, 3)),
        "weight": random.uniform(0.1, 9.0, size=(*batch, 1)) * np.array([0.0, 0.0, -1.0]),
        "touching": np.ones((*batch, contacts), dtype=bool),
    }
    frames, local = coordinates.frames(drawn["normals"]), random.normal(size=(*batch, contacts, 2, 2))
    return {
        **drawn,
        "frames": frames,
        "stretch": coordinates.stretch(drawn["normals"]),
        "tangents": sphere_by_cartesian(frames, coordinates.stretch(drawn["normals"])),
        "into": transposed_times(drawn["jacobian"], drawn["normals"]),
        "shape_operators": frames @ (local + np.swapaxes(local, -1, -2)) @ np.swapaxes(frames, -1, -2),
    }


READABLE = tuple(inputs(generator(), CONTACTS))


def with_gravity(given: Inputs) -> dict[str, Array]:
    """Inputs with gravity behind the contacts: at the centre of mass, its force the weight, its normal down."""
    shape = (*given["points"].shape[:-2], 1, 3)
    behind = {
        "points": given["centre_of_mass"][..., None, :],
        "forces": given["weight"][..., None, :],
        "normals": np.broadcast_to([0.0, 0.0, -1.0], shape),
    }
    return {**given, **{name: np.concatenate([given[name], row], axis=-2) for name, row in behind.items()}}


def drawn(sensed: Resources, *batch: int, coordinates: Coordinates = TANGENT) -> Iterator[dict[str, Array]]:
    """Inputs without end, with gravity behind the contacts where it is sensed."""
    random = generator()
    while True:
        given = inputs(random, CONTACTS, *batch, coordinates=coordinates)
        yield with_gravity(given) if isinstance(sensed, ContactSet) and sensed.has_gravity else given


def one_of(batch: Inputs, place: tuple[int, ...]) -> dict[str, Array]:
    """The inputs at a place of a batch."""
    return {name: value if name in SHARED else value[place] for name, value in batch.items()}


def _set(*members: dict[int, float]) -> ContactSet:
    resources = (ContactResource(f"γ{i + 1}", tuple(member.items())) for i, member in enumerate(members))
    return ContactSet("Γ", tuple(resources), CONTACTS)


def _joints(*joints: int) -> JointSet:
    return JointSet("Γ_k", joints, JOINTS)


PLAIN = _set({0: 1.0}, {1: 1.0}, {2: 1.0}, {3: 1.0})
SOME = _set({2: 1.0}, {0: 1.0})
VIRTUAL = _set({0: 1.0}, {1: 0.5, 2: 0.5})
NESTED = _set({3: 1.0}, {0: 0.5, 1: 0.25, 2: 0.25})

SETS = {"plain": PLAIN, "some": SOME, "virtual": VIRTUAL, "nested": NESTED}
WITH_GRAVITY = {
    "gravity": _set({1: 1.0}, {GRAVITY: 1.0}),
    "virtual and gravity": _set({GRAVITY: 1.0}, {1: 0.5, 3: 0.5}),
    "gravity in a virtual contact": _set({0: 1.0}, {2: 0.5, GRAVITY: 0.5}),
}
JOINT_SETS = {"all joints": _joints(*range(JOINTS)), "some joints": _joints(3, 1), "one joint": _joints(2)}


def sets_of(sensor: Sensor) -> Mapping[str, Resources]:
    """The sets that a sensor transform is tried on, by what they are like; none if it reads what there is not."""
    if not set(sensor.reads) <= set(READABLE):
        return {}
    if sensor.over_joints:
        return JOINT_SETS
    return {**SETS, **WITH_GRAVITY} if sensor.feels_gravity else SETS


def moved_and_sensed(effector: Effector, sensor: Sensor) -> Iterator[tuple[Resources, Resources]]:
    """What is moved and what is sensed: one set of contacts, or any two of joints; a turn moves what any set senses."""
    if sensor.over_joints:
        yield from ((moved, sensed) for moved in JOINT_SETS.values() for sensed in JOINT_SETS.values())
    elif effector.gradient_space is GradientSpace.ROTATION:
        yield from ((SOME, sensed) for sensed in sets_of(sensor).values())
    else:
        yield from ((same, same) for same in SETS.values())


def sensing(sensor: Sensor, resources: Resources) -> Array:
    """The mixing that a sensor transform takes: a row for each resource, or the weights of a sum."""
    return resources.matrix if isinstance(resources, JointSet) or sensor.per_contact else resources.weights


def moving(effector: Effector, moved: Resources, sensed: Resources) -> Array:
    """The mixing that an effector transform takes."""
    if isinstance(moved, JointSet):
        return sensed.matrix * moved.mask
    if effector.gradient_space is GradientSpace.ROTATION:
        assert isinstance(sensed, ContactSet)
        return sensed.turning
    if effector.weighs_sensed:
        assert isinstance(sensed, ContactSet)
        return sensed.beside(moved)
    return moved.matrix if effector.gradient_space is GradientSpace.JOINTS else moved.weights


def free_to_move(effector: Effector, moved: Resources) -> Array:
    """Ones for the coordinates of a gradient space that are free, zeros for those of what is not moved, (D,) or ()."""
    if isinstance(moved, JointSet):
        return moved.mask
    coordinates = {GradientSpace.SURFACE: 2, GradientSpace.CARTESIAN: 3}.get(effector.gradient_space)
    return np.repeat(moved.weights > 0.0, coordinates).astype(float) if coordinates else np.array(1.0)


def sensed_by(sensor: Sensor, resources: Resources, given: Inputs) -> Array:
    """σ of a set of resources."""
    return np.asarray(sensor.evaluate(sensing(sensor, resources), *[given[name].copy() for name in sensor.reads]))


def moved_by(effector: Effector, moved: Resources, sensed: Resources, given: Inputs) -> Array:
    """τ of what is moved, for what is sensed."""
    mixing, inputs = moving(effector, moved, sensed), [given[name].copy() for name in effector.reads]
    return np.asarray(effector.evaluate(mixing, *inputs))
