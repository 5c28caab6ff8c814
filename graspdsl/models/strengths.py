"""What drives the joints of a MJCF at most, as its actuators say."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import mujoco


def efforts(model: mujoco.MjModel) -> dict[str, float]:
    """The most [N m or N] that drives each joint of which that is known: the range of forces of the joint, or what its
    actuators give together, those at tendons of joints among them."""
    import mujoco

    most = dict[int, float]()
    for actuator in range(model.nu):
        force = _force(model, actuator)
        kind = mujoco.mjtTrn(int(model.actuator_trntype[actuator]))
        target = int(model.actuator_trnid[actuator, 0])
        pulled = dict[int, float]()
        if kind in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT):
            pulled[target] = 1.0
        elif kind == mujoco.mjtTrn.mjTRN_TENDON:
            pulled = {joint: abs(factor) for joint, factor in pulled_joints(model, target).items()}
        for joint, factor in pulled.items():
            gear = abs(float(model.actuator_gear[actuator, 0]))
            most[joint] = most.get(joint, 0.0) + force * factor * gear
    for joint in range(model.njnt):
        if model.jnt_actfrclimited[joint]:
            most[joint] = float(np.abs(model.jnt_actfrcrange[joint]).max())
    return {model.joint(joint).name: effort for joint, effort in most.items()}


def pulled_joints(model: mujoco.MjModel, tendon: int) -> dict[int, float]:
    """The joints of a fixed tendon and how much it lengthens with each; none of one that runs through space."""
    import mujoco

    first = int(model.tendon_adr[tendon])
    wraps = range(first, first + int(model.tendon_num[tendon]))
    return {
        int(model.wrap_objid[wrap]): float(model.wrap_prm[wrap])
        for wrap in wraps
        if model.wrap_type[wrap] == mujoco.mjtWrap.mjWRAP_JOINT
    }


def _force(model: mujoco.MjModel, actuator: int) -> float:
    """The most that an actuator gives, 0 where that is not said."""
    if model.actuator_forcelimited[actuator]:
        return float(np.abs(model.actuator_forcerange[actuator]).max())
    if model.actuator_ctrllimited[actuator] and not model.actuator_biasprm[actuator].any():
        return float(np.abs(model.actuator_ctrlrange[actuator]).max() * abs(model.actuator_gainprm[actuator, 0]))
    return 0.0
