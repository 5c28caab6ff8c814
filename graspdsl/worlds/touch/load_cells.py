"""Fingertip load cells, read by intrinsic contact sensing."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross, length
from graspdsl.spec.sensing import LoadCell
from graspdsl.worlds.touch.fingertip_sensor import FingertipSensor, Frames, TipContact
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
        return self._loads(step, self.hand.frames())

    def _loads(self, step: int, frames: Frames) -> Array:
        """The (k, 6) loads that the object puts on the tips, about their shapes' centres, in the tips' frames."""
        tips, raw = self.hand.tips, super().read(step)
        masses = np.array([tip.mass for tip in tips])
        levers = np.array([tip.weight_lever for tip in tips])
        # Along the rows of the rotations; the joint holds up the weights of the tips, and answers to the object's load.
        weights = (-self.gravity * masses)[:, None] * np.array([rotation[2] for _, rotation in frames])
        forces = -raw[:, :3] - weights
        return np.concatenate([forces, cross(levers, forces) - raw[:, 3:]], axis=1)

    def strengths(self, step: int, frames: Frames) -> Array:
        """The forces (k,) [N] of the loads, friction and all."""
        self.loads, self.frames = self._loads(step, frames) - self.zero, frames
        return length(self.loads[:, :3])

    def contact(self, tip: int) -> TipContact:
        """Where the load of a tip acts."""
        load, surface = self.loads[tip], self.surfaces[tip]
        _, rotation = self.frames[tip]
        from_centre = surface.contact(load[:3], load[3:])
        return TipContact(*self.at(tip, from_centre), rotation @ surface.normal(from_centre), -rotation @ load[:3])
