"""Intrinsic contact sensing: where a fingertip is touched, from the wrench on its load cell.

After Bicchi, Salisbury and Brock, "Contact sensing from force measurements", 1993, for a sphere and a soft
contact: the contact may carry a moment about its normal. The normal comes from the tip's own surface at the contact
point, so friction does not turn it.
"""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array


def sphere_contact(force: Array, moment: Array, radius: float) -> Array:
    """The contact point on a spherical tip, from its centre.

    force, moment: (3,) [N, N·m], the load that the object puts on the tip, the moment about the sphere's centre;
    radius [m]. Returns the point (3,) [m], at distance R from the centre.

    The point c and the scalar K of a soft contact satisfy K c + c × f = m with |c| = R and c·f < 0 (a contact pushes).
    Squaring gives (c·f)² = ((R²f² − m²) + √((R²f² − m²)² + 4 R² (m·f)²)) / 2, then K = (m·f) / (c·f) and c from the
    linear equation. Raises ValueError when the force is zero.
    """
    fx, fy, fz = force.tolist()
    mx, my, mz = moment.tolist()
    force_squared = fx * fx + fy * fy + fz * fz
    if force_squared == 0.0:
        raise ValueError("a contact without a force has no place")
    along = fx * mx + fy * my + fz * mz
    reach = radius * radius * force_squared - (mx * mx + my * my + mz * mz)
    push_squared = 0.5 * (reach + (reach * reach + 4.0 * radius * radius * along * along) ** 0.5)
    # A moment no contact on the sphere can make (noise) gives the point of the rim that comes nearest.
    push = -(max(push_squared, 1e-12 * radius * radius * force_squared) ** 0.5)
    twist = along / push
    cross = (fy * mz - fz * my, fz * mx - fx * mz, fx * my - fy * mx)
    point = np.array([twist * m + c + push * f for m, c, f in zip((mx, my, mz), cross, (fx, fy, fz), strict=True)])
    return point * (radius / max(float(np.sqrt(point @ point)), 1e-300))
