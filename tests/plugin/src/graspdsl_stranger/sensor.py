"""A sensor transform: how far the contacts, taken together, are from the object's centre of mass."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.sensors import Sensor
from graspdsl.basis.spaces import TaskSpace

NET_LEVER = TaskSpace("net lever of the contacts", "m")


class NetLever(Sensor):
    """σ_c: the net lever of the contacts about the object's centre of mass c, Σ w (x − c) [m], (..., 3).

    It is zero where their centroid is at the centre of mass, so that inertia and weight do not twist the grasp. The
    distance of the two is a common measure of grasps, the less the better (Roa and Suárez 2015, "Grasp quality
    measures: review and performance").
    """

    symbol = "σ_c"
    about = "net lever of the contacts about the object's centre of mass"
    equation = "Roa and Suárez 2015"
    space = NET_LEVER
    reads = ("points", "centre_of_mass")
    per_contact = False
    feels_gravity = False

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """Σ w (x − c), shape (..., 3)."""
        points, centre = inputs
        return np.asarray(mixing @ (points - centre[..., None, :]))
