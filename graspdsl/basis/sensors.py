"""Sensor transforms σ: from what the hand senses to a task space.

Contact forces are unit forces along the inward normal. Sums and means over resources use weights w: one for a
physical contact, 1/|α| for each member of a virtual contact (Eq. 4.32).
"""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from graspdsl.arrays import Array, namespace, product
from graspdsl.basis.algebra import along, cross
from graspdsl.basis.entry import Entry
from graspdsl.basis.spaces import (
    FORCE,
    MOMENT,
    NET_FORCE,
    NET_MOMENT,
    NET_WRENCH,
    NORMAL,
    ORIENTATION,
    POSITION,
    POSTURE,
    TaskSpace,
)


class Sensor(Entry):
    """A sensor transform: ``reads`` names its inputs (fields of an Observation, or ``origin``).

    ``per_contact`` sensors give one row a resource, the others one vector for the whole set. ``over_joints`` sensors
    take joint sets instead of contacts. Sensors that do not ``feel_gravity`` leave γ_g out of a set. ``measures``: the
    end condition of a phase that bounds the norm of what is sensed. One that ``turns_alike`` senses of every contact of
    a held object what moving any of them changes. The directions of one that ``makes_forces`` are reference forces,
    of as many newtons as their factor says.
    """

    space: ClassVar[TaskSpace]
    reads: ClassVar[tuple[str, ...]]
    per_contact: ClassVar[bool]
    over_joints: ClassVar[bool] = False
    feels_gravity: ClassVar[bool] = True
    measures: ClassVar[str] = ""
    turns_alike: ClassVar[bool] = False
    makes_forces: ClassVar[bool] = False

    @abstractmethod
    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """σ for a mixing matrix over the k contacts: (m, k) for per-contact sensors, else weights (k,)."""


class UnitNormals(Sensor):
    """σ_n: the inward unit normals of the resources [1] (Eq. 4.10), (..., m, 3); a virtual contact's is a mean."""

    symbol = "σ_n"
    about = "inward unit normals"
    equation = "4.10"
    space = NORMAL
    reads = ("normals",)
    per_contact = True
    makes_forces = True

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """R n, shape (..., m, 3)."""
        (normals,) = inputs
        return product(mixing, normals)


class Positions(Sensor):
    """σ_p: the positions of the resources [m], (..., m, 3) (Eq. 4.20, 4.32)."""

    symbol = "σ_p"
    about = "contact positions"
    equation = "4.20"
    space = POSITION
    reads = ("points",)
    per_contact = True

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """R x, shape (..., m, 3)."""
        (points,) = inputs
        return product(mixing, points)


class Forces(Sensor):
    """σ_f: the forces of the resources on the object along their normals [N], (..., m, 3) (Eq. 4.21, 4.32).

    The part along the surface is friction and is left out: a sliding contact must not servo it (end of Sec. 4.3.3).
    """

    symbol = "σ_f"
    about = "contact forces along the normals"
    equation = "4.21"
    space = FORCE
    reads = ("forces", "normals")
    per_contact = True

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """R (n nᵀ f), shape (..., m, 3)."""
        forces, normals = inputs
        return product(mixing, along(forces, normals))


class NetForce(Sensor):
    """σ_fr: the net force of unit contact forces, Σ w n [1] (Eq. 4.11), (..., 3)."""

    symbol = "σ_fr"
    about = "net force of unit contact forces"
    equation = "4.11"
    space = NET_FORCE
    reads = ("normals",)
    per_contact = False
    measures = "force_residual"

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """Σ w n, shape (..., 3)."""
        (normals,) = inputs
        return product(mixing, normals)


class NetMoment(Sensor):
    """σ_mr: the net moment of unit contact forces about the origin c, Σ w (x − c) × n [m] (Eq. 4.15), (..., 3)."""

    symbol = "σ_mr"
    about = "net moment of unit contact forces"
    equation = "4.15"
    space = NET_MOMENT
    reads = ("points", "normals", "origin")
    per_contact = False
    measures = "moment_residual"

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """Σ w (x − c) × n, shape (..., 3)."""
        points, normals, origin = inputs
        return product(mixing, cross(points - origin[..., None, :], normals))


class NetWrench(Sensor):
    """σ_w: the net wrench of unit contact forces, (Σ w n, Σ w (x − c) × n / r) (Sec. 4.1.3), (..., 6) [1].

    The moment is in units of the curvature radius r, so that force and moment weigh alike.
    """

    symbol = "σ_w"
    about = "net wrench of unit contact forces"
    equation = "Sec. 4.1.3"
    space = NET_WRENCH
    reads = ("points", "normals", "origin", "curvature_radius")
    per_contact = False

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """The net force above the net moment over r, shape (..., 6)."""
        points, normals, origin, radius = inputs
        moment = product(mixing, cross(points - origin[..., None, :], normals))
        return namespace(normals).concatenate([product(mixing, normals), moment / radius], axis=-1)


class Orientations(Sensor):
    """σ_r: the orientations of the contact frames in exponential coordinates [rad], (..., m, 3) (Eq. 4.41, 4.32).

    γ_g has none: the Γσ of Eq. 4.41 is sensed without it, one row for each other resource. As a held object turns all
    contacts alike, τ_r(Γτ) serves every row, whichever contacts Γτ names.
    """

    symbol = "σ_r"
    about = "contact orientations"
    equation = "4.41"
    space = ORIENTATION
    reads = ("orientations",)
    per_contact = True
    feels_gravity = False
    turns_alike = True

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """R r, shape (..., m, 3)."""
        (orientations,) = inputs
        return product(mixing, orientations)


class Moments(Sensor):
    """σ_m: the moments of the contact forces about the origin c [N·m], (x − c) × n nᵀ f (Sec. 3.1.2), (..., m, 3)."""

    symbol = "σ_m"
    about = "moments of the contact forces along the normals"
    equation = "Sec. 3.1.2"
    space = MOMENT
    reads = ("points", "forces", "normals", "origin")
    per_contact = True

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """R ((x − c) × (n nᵀ f)), shape (..., m, 3)."""
        points, forces, normals, origin = inputs
        return product(mixing, cross(points - origin[..., None, :], along(forces, normals)))


class Posture(Sensor):
    """σ_k: the positions of the joints of a joint set [rad, m for a slide] (Eq. 4.25), (..., s)."""

    symbol = "σ_k"
    about = "joint positions"
    equation = "4.25"
    space = POSTURE
    reads = ("joints",)
    per_contact = False
    over_joints = True

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """S q for the selection S (s, n), shape (..., s)."""
        (joints,) = inputs
        return namespace(joints).einsum("sn,...n->...s", mixing, joints)


SENSORS: dict[str, Sensor] = {
    sensor.symbol: sensor
    for sensor in (
        UnitNormals(),
        Positions(),
        Orientations(),
        Forces(),
        Moments(),
        NetForce(),
        NetMoment(),
        NetWrench(),
        Posture(),
    )
}


def measuring(condition: str) -> Sensor:
    """The sensor transform whose norm an end condition bounds, by its name in a spec."""
    return next(sensor for sensor in SENSORS.values() if sensor.measures == condition)
