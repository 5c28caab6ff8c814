"""The controller keeps within the joints' limits, and lets the other joints do what a joint at its limit cannot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.worlds.protocol import Observation

from .observations import JOINTS, LOWER, UPPER, compiled, observation

FORMULA = "π_s|Γ Γ (π_gx|Γ Γ)"


def squeezed(seen: Observation, step: Array, joints: list[int]) -> Observation:
    """The observation with some joints so near to the limit they move to that the step does not fit any more."""
    places = seen.joints.copy()
    for joint in joints:
        places[joint] = (UPPER if step[joint] > 0 else LOWER)[joint] - 0.4 * step[joint]
    return replace(seen, joints=places)


@pytest.mark.parametrize("seed", range(5))
def test_no_command_goes_beyond_a_limit(seed: int) -> None:
    controller, random = compiled(FORMULA), np.random.default_rng(seed)
    free = observation(seed)
    joints = random.choice(JOINTS, size=4, replace=False).tolist()
    seen = squeezed(free, controller.evaluate(free).command.displacement, joints)
    after = seen.joints + controller.evaluate(seen).command.displacement
    assert (after <= UPPER + 1e-12).all()
    assert (after >= LOWER - 1e-12).all()


@pytest.mark.parametrize("seed", range(5))
def test_the_others_make_the_step_of_a_robot_without_the_joint(seed: int) -> None:
    controller, free = compiled(FORMULA), observation(seed)
    joint = seed
    seen = squeezed(free, controller.evaluate(free).command.displacement, [joint])
    present = np.arange(JOINTS) != joint
    without = replace(free, jacobian=free.jacobian * present, angular_jacobian=free.angular_jacobian * present)
    expected = controller.evaluate(without).command.displacement * present
    np.testing.assert_allclose(controller.evaluate(seen).command.displacement, expected, atol=1e-14)


def test_a_joint_leaves_its_limit_when_the_command_says_so() -> None:
    controller, free = compiled(FORMULA), observation(3)
    step = controller.evaluate(free).command.displacement
    at_far_end = np.where(step > 0, LOWER, UPPER)
    seen = replace(free, joints=at_far_end)
    np.testing.assert_array_equal(controller.evaluate(seen).command.displacement, step)
