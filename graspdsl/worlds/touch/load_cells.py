"""Fingertip load cells, read by intrinsic contact sensing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.basis.algebra import cross, length
from graspdsl.spec.sensing import LoadCell
from graspdsl.worlds.touch.fingertip_sensor import FingertipSensor, Frames, TipContact, TipFrames
from graspdsl.worlds.touch.signals import Flaws


class LoadCells(FingertipSensor):
    """A six-axis cell before each tip, in the frame of the tip's link.

    What it reads late it reads in the frame of the tip, which has moved on meanwhile. The weight of the tip is known in
    every pose and taken off.
    """

    name = "load-cell"
    about = "a six-axis load cell before each fingertip: intrinsic contact sensing, friction and all"
    called = "load cells"
    model = LoadCell
    needs_cells = True
    tares = True
    loads: Array

    def flaws(self) -> Flaws:
        """Of forces, then of moments."""
        spec: LoadCell = self.spec
        return Flaws(
            noise=np.repeat([spec.force_noise, spec.moment_noise], 3),
            bias=np.repeat([spec.force_bias, spec.moment_bias], 3),
            drift=np.repeat([spec.force_drift, spec.moment_drift], 3),
            quantum=np.repeat([spec.force_quantum, spec.moment_quantum], 3),
        )

    def measured(self) -> Array:
        """The wrenches (k, 6) on the cells."""
        return self.hand.wrenches()

    def read(self, step: int) -> Array:
        """The loads (k, 6) that the object puts on the tips."""
        _, rotations = zip(*self.hand.frames(), strict=True)
        return np.asarray(self._loads([self], [step], np.array(rotations)[None])[0])

    @classmethod
    def _loads(cls, sensors: Sequence[Self], steps: Sequence[int], rotations: Array) -> Array:
        """The (N, k, 6) loads that objects put on the tips, about their shapes' centres, in the tips' frames, which are
        turned by (N, k, 3, 3)."""
        tips = sensors[0].hand.tips
        raw = np.array([super(LoadCells, sensor).read(step) for sensor, step in zip(sensors, steps, strict=True)])
        masses = np.array([tip.mass for tip in tips])
        levers = np.array([tip.weight_lever for tip in tips])
        # Along the rows of the rotations; the joint holds up the weights of the tips, and answers to the object's load.
        weights = (-sensors[0].gravity * masses)[:, None] * rotations[..., 2, :]
        forces = -raw[..., :3] - weights
        return np.concatenate([forces, cross(levers, forces) - raw[..., 3:]], axis=-1)

    @classmethod
    def strengths_of(cls, sensors: Sequence[Self], steps: Sequence[int], frames: TipFrames) -> Array:
        """The forces (N, k) [N] of the loads, friction and all."""
        loads = cls._loads(sensors, steps, frames.rotations) - np.array([sensor.zero for sensor in sensors])
        for sensor, load in zip(sensors, loads, strict=True):
            sensor.loads = load
        return length(loads[..., :3])

    @classmethod
    def contacts_of(cls, sensors: Sequence[Self], touching: Flags, frames: TipFrames) -> Array:
        """Where the loads of tips act."""
        loads, tips = np.array([sensor.loads for sensor in sensors])[touching], np.nonzero(touching)[1]
        forces, from_centres, normals = loads[:, :3], np.empty((len(tips), 3)), np.empty((len(tips), 3))
        kinds = sensors[0].alike
        for kind in set(kinds.tolist()):
            surface, chosen = sensors[0].surfaces[kind], kinds[tips] == kind
            if chosen.any():
                from_centres[chosen] = surface.contacts(forces[chosen], loads[chosen, 3:])
                normals[chosen] = surface.normals(from_centres[chosen])
        places = np.array([tip.centre for tip in sensors[0].hand.tips])[tips] + from_centres
        origins, rotations = frames.origins[touching], frames.rotations[touching]
        points = origins + np.matvec(rotations, places)
        return np.array([places, points, np.matvec(rotations, normals), -np.matvec(rotations, forces)])

    def strengths(self, step: int, frames: Frames) -> Array:
        """The forces (k,) [N] of the loads, friction and all."""
        self.frames = frames
        origins, rotations = (np.array(part)[None] for part in zip(*frames, strict=True))
        return np.asarray(self.strengths_of([self], [step], TipFrames(origins, rotations))[0])

    def contact(self, tip: int) -> TipContact:
        """Where the load of a tip acts."""
        origins, rotations = (np.array(part)[None] for part in zip(*self.frames, strict=True))
        touching = (np.arange(len(self.frames)) == tip)[None]
        return TipContact(*self.contacts_of([self], touching, TipFrames(origins, rotations))[:, 0])
