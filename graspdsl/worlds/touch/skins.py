"""Fingertip skins, read by extrinsic contact sensing: taxels that feel normal pressure."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from graspdsl.arrays import Array
from graspdsl.spec.sensing import Skin
from graspdsl.worlds.touch.fingertip_sensor import FingertipSensor, Frames, TipContact
from graspdsl.worlds.touch.signals import Flaws
from graspdsl.worlds.touch.surfaces import Taxels

TAXEL_DEVIATIONS = 5.0  # of noise that a taxel must exceed; there are hundreds of them


class Skins(FingertipSensor):
    """A grid of taxels all over each tip.

    The normal force of each of the engine's contacts is spread over the taxels around it with a Gaussian footprint, as
    a soft cover does; friction is not felt. The contact is where the pressure around the strongest taxel has its
    centroid, put on the tip's surface, its force the sum of that pressure along the surface's normal.
    """

    name = "skin"
    about = "taxels all over each fingertip: extrinsic contact sensing, by the centroid of the pressure"
    called = "skin"
    model = Skin
    tares = True

    @cached_property
    def taxels(self) -> list[Taxels]:
        """The taxels of each tip."""
        return [surface.taxels(self.spec.pitch) for surface in self.surfaces]

    @cached_property
    def _most(self) -> int:
        """The largest number of taxels of a tip."""
        return max(len(taxels.points) for taxels in self.taxels)

    @cached_property
    def _threshold(self) -> float:
        spec: Skin = self.spec
        noise = TAXEL_DEVIATIONS * spec.taxel_noise_at(self.clock.control)
        return noise if spec.threshold is None else spec.threshold

    def flaws(self) -> Flaws:
        """Of each taxel."""
        spec: Skin = self.spec
        return Flaws(
            noise=np.full(self._most, spec.taxel_noise),
            bias=np.full(self._most, spec.taxel_bias),
            drift=np.full(self._most, spec.taxel_drift),
            quantum=np.full(self._most, spec.taxel_quantum),
        )

    def measured(self) -> Array:
        """The force [N] on each taxel, (k, t)."""
        frames = self.hand.frames()
        forces = np.zeros((len(frames), self._most))
        for row, (points, presses) in enumerate(self.hand.presses()):
            if len(presses):
                origin, rotation = frames[row]
                forces[row] = self._spread(row, (points - origin) @ rotation - self.hand.tips[row].centre, presses)
        return forces

    def _spread(self, tip: int, points: Array, presses: Array) -> Array:
        """The force (t,) [N] on each taxel under normal forces (c,) [N] at points (c, 3), from the centre."""
        taxels, surface = self.taxels[tip], self.surfaces[tip]
        feet = np.array([surface.nearest(point) for point in points])
        squares = np.sum((taxels.points - feet[:, None]) ** 2, axis=2)
        nearest = squares.min(axis=1, keepdims=True)  # so that a footprint smaller than the pitch still presses
        footprints = np.exp((nearest - squares) / (2.0 * self.spec.patch**2)) * taxels.areas
        forces = np.zeros(self._most)
        forces[: len(taxels.areas)] = presses @ (footprints / footprints.sum(axis=1, keepdims=True))
        return forces

    def strengths(self, step: int, frames: Frames) -> Array:
        """The sums (k,) [N] of the pressure around the strongest taxels; zero where none stands out of the noise."""
        self.frames = frames
        readings = self.read(step) - self.zero
        self.pressed = [self._around_strongest(row, forces) for row, forces in enumerate(readings)]
        return np.array([max(0.0, float(forces.sum())) for _, forces in self.pressed])

    def _around_strongest(self, tip: int, forces: Array) -> tuple[Array, Array]:
        """The points and forces of the taxels within the window about the strongest one."""
        points = self.taxels[tip].points
        forces = forces[: len(points)]
        strongest = int(forces.argmax())
        if forces[strongest] <= self._threshold:
            return points[:0], forces[:0]
        inside = np.sum((points - points[strongest]) ** 2, axis=1) <= self.spec.window**2
        return points[inside], forces[inside]

    def contact(self, tip: int) -> TipContact:
        """The centroid of the pressure on a tip."""
        points, forces = self.pressed[tip]
        surface, total = self.surfaces[tip], float(forces.sum())
        from_centre = surface.nearest(forces @ points / total)
        normal = self.frames[tip][1] @ surface.normal(from_centre)
        return TipContact(*self.at(tip, from_centre), normal, total * normal)
