"""A tactile sensor of a stranger's: three-axis force cells, which feel how hard and which way but no moment."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field

from graspdsl.arrays import Array
from graspdsl.spec.sensing import Newtons, SampledSensor
from graspdsl.worlds.touch.fingertip_sensor import FingertipSensor, Frames, TipContact
from graspdsl.worlds.touch.signals import Flaws


class ForceCell(SampledSensor):
    """A three-axis force cell behind each fingertip; noise, bias, drift and quantum are of each axis."""

    about: ClassVar = "three-axis force cells behind the fingertips"

    flaws = ("noise", "bias", "drift", "quantum")
    usual_rate = 100.0

    noise: Newtons = Field(default=0.0, description="white noise of a sample, standard deviation (N)")
    bias: Newtons = Field(default=0.0, description="standard deviation (N) of the bias drawn for each trial")
    drift: Newtons = Field(
        default=0.0, description="drift: a random walk of this standard deviation (N) after one second"
    )
    quantum: Newtons = Field(default=0.0, description="step (N) that readings are rounded to; 0: none")

    def force_noise_at(self, control_rate: float) -> float:
        """The standard deviation [N] of one axis in one control tick's reading."""
        return self.averaged(self.noise, control_rate)


class ForceCells(FingertipSensor):
    """Three forces before each tip, in the frame of the tip's link.

    Without a moment the place of the contact is a guess: where a force through the middle of the tip enters it. That
    is right without friction on a ball, and off by the angle of friction otherwise.
    """

    name = "force-cell"
    about = "a three-axis force cell behind each fingertip: the contact is where the force points to"
    called = "force cells"
    model = ForceCell
    needs_cells = True
    tares = True

    def flaws(self) -> Flaws:
        """The same on all three axes."""
        spec: ForceCell = self.spec
        noise, bias, drift, quantum = np.outer([spec.noise, spec.bias, spec.drift, spec.quantum], np.ones(3))
        return Flaws(noise, bias, drift, quantum)

    def measured(self) -> Array:
        """The forces (k, 3) [N] on the cells."""
        return self.hand.wrenches()[:, :3]

    def read(self, step: int) -> Array:
        """The forces (k, 3) [N] that the object puts on the tips, in the tips' frames: without the tips' own weight."""
        weights = [
            tip.mass * rotation.T @ np.array([0.0, 0.0, -self.gravity])
            for tip, (_, rotation) in zip(self.hand.tips, self.hand.frames(), strict=True)
        ]
        # A cell answers what it holds up against: minus the object's force and the weight.
        return -super().read(step) - np.array(weights)

    def strengths(self, step: int, frames: Frames) -> Array:
        """The forces' sizes (k,) [N]."""
        self.forces, self.frames = self.read(step) - self.zero, frames
        return np.asarray(np.linalg.norm(self.forces, axis=1))

    def contact(self, tip: int) -> TipContact:
        """Where the force on a tip, taken through its middle, enters it."""
        force, surface = self.forces[tip], self.surfaces[tip]
        _, rotation = self.frames[tip]
        from_centre = surface.contact(force, np.zeros(3))
        return TipContact(*self.at(tip, from_centre), rotation @ surface.normal(from_centre), -rotation @ force)
