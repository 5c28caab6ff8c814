"""Intrinsic contact sensing: where a fingertip is touched, from the wrench on its load cell.

After Bicchi, Salisbury and Brock, "Contact sensing from force measurements", 1993, for soft contacts, which may carry
a moment about their normal: a load (f, m) of a contact at c, whose outward normal is n, has K n + c × f = m with some
scalar K, and the contact pushes, n·f < 0. On a convex surface there is no more than one such point. The normal is that
of the tip's own surface at c, so friction does not turn it.

Noise can make a load that no contact explains. Each function then gives the admissible point that comes nearest, never
a number that is not finite. Forces [N] and moments [N·m] are loads that the object puts on the tip, moments about the
centre of the shape, in its own axes.
"""

from __future__ import annotations

import math

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross

LONGEST_LEVER = 1e6  # of |m| / |f|, in sizes of the tip: beyond it a load is taken to be pure torsion
GRAZING = 1e-6  # the least -n·f / |f| that a contact pushes with


def sphere_contact(force: Array, moment: Array, radius: float) -> Array:
    """The contact points (..., 3) [m] on a spherical tip of ``radius`` [m], from its centre; force, moment: (..., 3).

    With n = c / R, squaring gives (c·f)² = ((R²f² − m²) + √((R²f² − m²)² + 4 R² (m·f)²)) / 2, then K = (m·f) / (c·f)
    and c from the linear equation. A load whose line of action misses the sphere has the point of the sphere that is
    nearest to that line. Raises ValueError when a force is zero.
    """
    forces, moments = _scaled(force, moment, radius)
    fx, fy, fz = (forces[..., axis] for axis in range(3))
    mx, my, mz = (moments[..., axis] for axis in range(3))
    force_squared = fx * fx + fy * fy + fz * fz
    along = fx * mx + fy * my + fz * mz
    reach = force_squared - (mx * mx + my * my + mz * mz)
    root = np.sqrt(reach * reach + 4.0 * along * along)
    # Of the two forms of one root, the one that does not subtract equals.
    opposite = np.where(root > reach, root - reach, 1.0)
    push_squared = np.where(reach > 0.0, 0.5 * (reach + root), 2.0 * along * along / opposite)
    push = -np.sqrt(np.maximum(push_squared, GRAZING * GRAZING * force_squared))
    twist = along / push
    points = twist[..., None] * moments + cross(forces, moments) + push[..., None] * forces
    sizes = np.asarray(_hypot(points[..., 0], points[..., 1], points[..., 2]), dtype=np.float64)
    return np.asarray(points * (radius / sizes)[..., None])


_hypot = np.frompyfunc(math.hypot, 3, 1)


def _scaled(force: Array, moment: Array, size: float) -> tuple[Array, Array]:
    """Loads in units in which the tip's size is 1 and the force about 1, so that no product leaves the numbers."""
    scale, lever = np.abs(force).max(axis=-1, keepdims=True), np.abs(moment).max(axis=-1, keepdims=True)
    if (scale == 0.0).any():
        raise ValueError("a contact without a force has no place")
    twists = lever > LONGEST_LEVER * scale * size
    scaled = moment / np.where(twists, lever, scale)
    return force / scale, np.where(twists, scaled * LONGEST_LEVER, scaled / size)


def ellipsoid_contact(force: Array, moment: Array, semi_axes: Array) -> Array:
    """The contact point (3,) [m] on an ellipsoid with semi-axes a (3,) [m] along its own axes, from its centre.

    With A = diag(a), c = A u and |u| = 1, the normal is along A⁻¹u and (A u) × f = det(A) A⁻¹ (u × A⁻¹f), so that
    K A⁻¹u + c × f = m becomes K u + u × g = A m with g = det(A) A⁻¹f: the problem of the unit sphere. A u pushes on
    the ellipsoid exactly when u pushes on the sphere. Raises ValueError when the force is zero.
    """
    size = float(semi_axes.max())
    share = semi_axes / size
    forces, moments = _scaled(force, moment, size)
    scaled = sphere_contact(forces * (share.prod() / share), moments * share, 1.0)
    return np.asarray(scaled * semi_axes)


def capsule_contact(force: Array, moment: Array, radius: float, length: float) -> Array:
    """The contact point (3,) [m] on a capsule about a segment of ``length`` [m] along z, from its middle.

    On the side c = t e + R n with e along z and n across it. Along e the equation says R (n × f)·e = m·e, which gives
    n; along e × n it says t (f·n) − R (f·e) = m·(e × n), which gives t. On an end the contact is that of a sphere about
    the end of the segment. Of the three points, each put where its piece ends if it lies beyond, the one whose load
    comes nearest is taken: exactly one fits when any contact does. Raises ValueError when the force is zero.
    """
    forces, moments = _scaled(force, moment, radius)
    half = 0.5 * length / radius
    candidates = [_end(forces, moments, half), _end(forces, moments, -half)]
    if math.hypot(float(forces[0]), float(forces[1])) > GRAZING:
        candidates.append(_side(forces, moments, half))
    return radius * min(candidates, key=lambda point: _misfit(point, forces, moments, half))


def _side(force: Array, moment: Array, half: float) -> Array:
    fx, fy, fz = force.tolist()
    across = math.hypot(fx, fy)
    sine = max(-1.0, min(1.0, float(moment[2]) / across))
    cosine = -math.sqrt(1.0 - sine * sine)
    # n is the direction of the force across the axis, turned by the angle whose sine and cosine these are.
    nx, ny = (fx * cosine + fy * sine) / across, (fy * cosine - fx * sine) / across
    along_normal = min(across * cosine, -GRAZING * across)
    beside = float(moment[1]) * nx - float(moment[0]) * ny
    height = max(-half, min(half, (beside + fz) / along_normal))
    return np.array([nx, ny, height])


def _end(force: Array, moment: Array, height: float) -> Array:
    lever = np.array([-height * force[1], height * force[0], 0.0])
    x, y, z = sphere_contact(force, moment - lever, 1.0).tolist()
    if z * height < 0.0:  # the half of the sphere inside the capsule
        outward = math.hypot(x, y)
        x, y, z = (x / outward, y / outward, 0.0) if outward > 0.0 else (1.0, 0.0, 0.0)
    return np.array([x, y, z + height])


def _misfit(point: Array, force: Array, moment: Array, half: float) -> float:
    """|m − c × f − K n| with the K that fits best; infinite for a contact that pulls."""
    x, y, z = point.tolist()
    nx, ny, nz = x, y, z - max(-half, min(half, z))
    fx, fy, fz = force.tolist()
    if nx * fx + ny * fy + nz * fz > 0.0:
        return math.inf
    mx, my, mz = moment.tolist()
    rest = (mx - (y * fz - z * fy), my - (z * fx - x * fz), mz - (x * fy - y * fx))
    torsion = rest[0] * nx + rest[1] * ny + rest[2] * nz
    return math.hypot(rest[0] - torsion * nx, rest[1] - torsion * ny, rest[2] - torsion * nz)
