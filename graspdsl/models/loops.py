"""Closed loops of a MJCF: how joints without a motor follow those with one, found by moving the model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from graspdsl.arrays import Array

if TYPE_CHECKING:
    import mujoco

PLACES = 7  # of a driven joint, from one limit to the other
STEPS = 1500  # of 2 ms, in which all comes to rest at each
# What drives [N m/rad or N/m], and what all joints are given so that they come to rest, whatever they weigh.
STIFFNESS, DRIVEN_INERTIA, INERTIA, DAMPING = 50.0, 0.01, 1e-4, 0.005
STILL = 0.1  # of its range: a joint that moves by less keeps still
STRAIGHT = 0.1  # of its own way: how far a joint may be off a straight line of its leader's places


class Led(NamedTuple):
    """A joint that a loop leads: its number and its leader's, place = ratio · that of the leader + offset, and how far
    off that it is at the most [rad or m]. One without a leader keeps still at the offset."""

    joint: int
    leader: int | None
    ratio: float
    offset: float
    off: float

    @property
    def is_straight(self) -> bool:
        """Whether the joint follows one leader by a ratio, as couplings do."""
        return bool(np.isfinite(self.off))


def led_by_loops(model: mujoco.MjModel, leaders: Sequence[int], others: Sequence[int]) -> Iterator[Led]:
    """What each of some joints without motors does as the leaders go from limit to limit, one at a time.

    The model's own equalities, tendons and springs hold the loops together, without gravity and contacts. Infinitely
    far off is what several leaders move, or what is no straight line of its leader's places.
    """
    ways = {leader: _moved(model, leader, leaders) for leader in leaders}
    for joint in others:
        adr = model.jnt_qposadr[joint]
        travels = {leader: float(np.ptp(way[:, adr])) for leader, way in ways.items()}
        low, high = model.jnt_range[joint].tolist() if model.jnt_limited[joint] else (-np.pi, np.pi)
        movers = [leader for leader, travel in travels.items() if not travel < STILL * (high - low)]
        if not movers:
            places = np.concatenate([way[:, adr] for way in ways.values()])
            place = min(max(float(places.mean()), low), high)
            yield Led(joint, None, 0.0, place, float(np.abs(places - place).max()))
            continue
        leader, way = movers[0], ways[movers[0]]
        ratio, offset = np.polyfit(way[:, model.jnt_qposadr[leader]], way[:, adr], 1)
        off = float(np.abs(ratio * way[:, model.jnt_qposadr[leader]] + offset - way[:, adr]).max())
        straight = len(movers) == 1 and off <= STRAIGHT * travels[leader]
        yield Led(joint, leader, float(ratio), float(offset), off if straight else np.inf)


def _moved(model: mujoco.MjModel, leader: int, leaders: Sequence[int]) -> Array:
    """The places of all joints (PLACES, nq) as one leader goes from limit to limit, the others halfway."""
    import copy

    import mujoco

    model = copy.deepcopy(model)
    model.opt.gravity[:] = 0.0
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
    model.dof_armature[:] += INERTIA
    model.dof_damping[:] += DAMPING
    data = mujoco.MjData(model)
    for joint in leaders:
        dof, adr = model.jnt_dofadr[joint], model.jnt_qposadr[joint]
        model.jnt_stiffness[joint] = STIFFNESS
        model.dof_armature[dof] = DRIVEN_INERTIA
        model.dof_damping[dof] = 2.0 * np.sqrt(STIFFNESS * DRIVEN_INERTIA)
        model.qpos_spring[adr] = data.qpos[adr] = model.jnt_range[joint].mean()
    way = []
    low, high = model.jnt_range[leader].tolist()
    for place in np.linspace(low, high, PLACES):
        model.qpos_spring[model.jnt_qposadr[leader]] = place
        mujoco.mj_step(model, data, STEPS)
        way.append(data.qpos.copy())
    return np.array(way)
