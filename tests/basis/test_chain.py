"""The joint-space effectors on a chain of hinges whose motion is worked out link by link."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.basis.effectors import EFFECTORS
from graspdsl.basis.resources import ContactSet
from graspdsl.basis.rotations import turn_between
from graspdsl.basis.sensors import SENSORS
from graspdsl.contracts.differences import central_differences
from graspdsl.contracts.drawing import CONTACTS, JOINTS, SETS, generator, unit_vectors


@dataclass(frozen=True)
class Chain:
    """Hinges one after the other: axes (n, 3) and offsets (n, 3) in the frame of the link before, and contacts that
    each sit at a tip (k, 3) of a link."""

    axes: Array
    offsets: Array
    tips: Array
    links: tuple[int, ...]

    def poses(self, angles: Array) -> tuple[Array, Array, Array, Array]:
        """Of contacts: points and rotations, (k, 3) and (k, 3, 3); of hinges: places and axes, (n, 3) each."""
        rotation, place = np.eye(3), np.zeros(3)
        places, axes, frames = [], [], []
        for axis, offset, angle in zip(self.axes, self.offsets, angles, strict=True):
            place = place + rotation @ offset
            axes.append(rotation @ axis)
            places.append(place)
            rotation = rotation @ Rotation.from_rotvec(angle * axis).as_matrix()
            frames.append(rotation)
        rotations = np.stack([frames[link] for link in self.links])
        points = np.stack([places[link] + frames[link] @ tip for link, tip in zip(self.links, self.tips, strict=True)])
        return points, rotations, np.stack(places), np.stack(axes)

    def jacobians(self, angles: Array) -> tuple[Array, Array]:
        """Of the contact points and of their rotations in fixed axes, (k, 3, n) each, by screw theory."""
        points, _, places, axes = self.poses(angles)
        carried = np.arange(JOINTS) <= np.array(self.links)[:, None]
        linear = np.cross(axes, points[:, None] - places) * carried[..., None]
        return np.swapaxes(linear, 1, 2), np.swapaxes(axes * carried[..., None], 1, 2)


def chain() -> Chain:
    """Hinges about random axes; two contacts on the last link, two on links before."""
    random = generator()
    return Chain(
        unit_vectors(random, JOINTS),
        random.normal(size=(JOINTS, 3)),
        random.normal(size=(CONTACTS, 3)),
        (JOINTS - 1, JOINTS - 1, 2, 1),
    )


def postures() -> Array:
    """Angles all over the circle."""
    return generator().uniform(-np.pi, np.pi, size=(20, JOINTS))


def as_vectors(rotations: Array) -> Array:
    """The exponential coordinates of rotations (k, 3, 3)."""
    return Rotation.from_matrix(rotations).as_rotvec()


@pytest.mark.parametrize("resources", SETS.values(), ids=SETS)
def test_positions_follow_the_chain(resources: ContactSet) -> None:
    hinges = chain()
    for angles in postures():
        linear, _ = hinges.jacobians(angles)

        def sensed(moved: Array) -> Array:
            return SENSORS["σ_p"].evaluate(resources.matrix, hinges.poses(moved)[0]).ravel()

        found = EFFECTORS["τ_p"].evaluate(resources.matrix, linear)
        np.testing.assert_allclose(found, central_differences(sensed, angles), atol=1e-8)


@pytest.mark.parametrize("resources", SETS.values(), ids=SETS)
def test_orientations_follow_the_chain(resources: ContactSet) -> None:
    """τ_r is the derivative of the turn from where the contacts were, whichever way they are turned already."""
    hinges = chain()
    for angles in postures():
        _, angular = hinges.jacobians(angles)
        here = as_vectors(hinges.poses(angles)[1])

        def turned(moved: Array, here: Array = here) -> Array:
            between = turn_between(as_vectors(hinges.poses(moved)[1]), here)
            return SENSORS["σ_r"].evaluate(resources.matrix, between).ravel()

        found = EFFECTORS["τ_r"].evaluate(resources.matrix, angular)
        np.testing.assert_allclose(found, central_differences(turned, angles), atol=1e-8)


def test_a_finite_turn_of_one_hinge_turns_what_it_carries_about_its_axis() -> None:
    hinges, random = chain(), generator()
    for angles in postures():
        joint, angle = int(random.integers(JOINTS)), random.uniform(-3.0, 3.0)
        before, after = (as_vectors(hinges.poses(q)[1]) for q in (angles, angles + angle * np.eye(JOINTS)[joint]))
        _, angular = hinges.jacobians(angles)
        step = EFFECTORS["τ_r"].evaluate(np.eye(CONTACTS), angular) @ (angle * np.eye(JOINTS)[joint])
        np.testing.assert_allclose(turn_between(after, before).ravel(), step, atol=1e-12)
