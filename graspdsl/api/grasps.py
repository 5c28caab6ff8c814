"""Given contacts: their residuals, and whether and how well they hold an object.

Points are in m, normals are unit vectors *into* the object, as a fingertip presses; the frame is any one of both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from graspdsl.api.arrays import finite, floats, of_shape, of_unit_length
from graspdsl.arrays import Array
from graspdsl.basis.sensors import measuring
from graspdsl.quality import ferrari_canny as measure
from graspdsl.quality import force_closure as test
from graspdsl.quality.contact_models import contact_model
from graspdsl.quality.wrench_space import WrenchSpace, wrench_space
from graspdsl.spec.grading import DEFAULT_EDGES, ContactKind


@dataclass(frozen=True, slots=True)
class Residuals:
    """What unit forces along the inward normals leave over: net force (..., 3) (1) and net moment (..., 3) [m]."""

    net_force: Array
    net_moment: Array

    @property
    def force_residual(self) -> Array:
        """‖ρ_f‖ (1), (...)."""
        return np.asarray(np.sqrt(self.force_squared))

    @property
    def moment_residual(self) -> Array:
        """‖ρ_m‖ [m], (...)."""
        return np.asarray(np.sqrt(self.moment_squared))

    @property
    def force_squared(self) -> Array:
        """ε_f = ρ_fᵀρ_f (1), (...)."""
        return np.asarray(np.vecdot(self.net_force, self.net_force))

    @property
    def moment_squared(self) -> Array:
        """ε_m = ρ_mᵀρ_m [m²], (...)."""
        return np.asarray(np.vecdot(self.net_moment, self.net_moment))


def residuals(
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    *,
    about: npt.ArrayLike | None = None,
    weights: npt.ArrayLike | None = None,
) -> Residuals:
    """The force and the moment residual of contacts (Eq. 4.11, 4.15), by σ_fr and σ_mr.

    points, normals: (..., k, 3); about: (..., 3) [m], what moments are taken about, by default the contacts' centroid.
    weights: (k,), by default one each; the m members of a virtual contact have 1/m each (Eq. 4.32). Raises ValueError
    for other shapes, numbers that are not finite and normals that are no unit vectors.
    """
    points, normals = _contacts(points, normals)
    shares = np.ones(points.shape[-2]) if weights is None else _given("weights", weights, (points.shape[-2],))
    if about is None:
        if not shares.sum() > 0.0:
            raise ValueError("without contacts that weigh something there is no centroid: give 'about'")
        origin = shares / shares.sum() @ points
    else:
        origin = _given("about", about, (3,) if np.ndim(about) == 1 else (*points.shape[:-2], 3))
    force, moment = measuring("force_residual"), measuring("moment_residual")
    return Residuals(force.evaluate(shares, normals), moment.evaluate(shares, points, normals, origin))


def force_closure(
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    friction: float,
    *,
    contact: ContactKind | None = None,
    torsion: float | None = None,
    edges: int = DEFAULT_EDGES,
) -> test.ForceClosure:
    """Whether contacts can balance any wrench on the object, by how much, and if not why.

    points, normals: (k, 3). friction: Coulomb's coefficient (1). contact, torsion [m] and edges are the conventions
    that a spec has under ``grading``, with the same defaults: no more than two contacts are soft fingers, which also
    resist turning about the normal by ``torsion`` N·m a newton, by default (3π/16) μ a of a patch of a = 2.8 mm, and
    more are hard points unless a torsion is given. Friction cones are pyramids of so many ``edges`` within them. Raises
    ValueError for other shapes, numbers that are not finite, coefficients below 0 and normals that are no unit vectors.
    """
    return test.force_closure(_wrenches(points, normals, friction, contact, torsion, edges))


def ferrari_canny(
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    friction: float,
    *,
    contact: ContactKind | None = None,
    torsion: float | None = None,
    edges: int = DEFAULT_EDGES,
    about: npt.ArrayLike | None = None,
    length: float | None = None,
) -> measure.FerrariCanny:
    """Ferrari and Canny's ε, the largest wrench that contacts resist in every direction (L1), and the volume of all.

    points, normals, friction, contact, torsion and edges as for :func:`force_closure`. about: (3,) [m], what moments
    are taken about, by default the contacts' centroid (give the object's centre of mass to judge how it can be held);
    length [m]: the torque scale, what moments are divided by. The object is not known here, so that it is by default
    the largest distance of a contact from there: to compare grasps give one for all, as a run does with the object's
    radius of gyration. ``epsilon.value``, ``shortfall.value``, the share of ε that the pyramids may leave out, and
    ``volume.value`` come with a ``reason`` where they are zero or None. Raises ValueError as :func:`force_closure`.
    """
    reference = None if about is None else _given("about", about, (3,))
    return measure.ferrari_canny(_wrenches(points, normals, friction, contact, torsion, edges, reference, length))


def _wrenches(
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    friction: float,
    contact: ContactKind | None,
    torsion: float | None,
    edges: int,
    reference: Array | None = None,
    length: float | None = None,
) -> WrenchSpace:
    places, directions = _contacts(points, normals)
    model = contact_model(contact, len(places), friction, torsion, edges)
    return wrench_space(places, directions, model, reference=reference, length=length)


def _contacts(points: npt.ArrayLike, normals: npt.ArrayLike) -> tuple[Array, Array]:
    """Points and unit normals (..., k, 3) as arrays. Raises ValueError for what cannot be such."""
    places = floats("points", points)
    if places.ndim < 2 or places.shape[-1] != 3:
        raise ValueError(f"points: expected the shape (..., k, 3), a row a contact, found {places.shape}")
    finite("points", places)
    directions = _given("normals", normals, places.shape)
    of_unit_length("normals", directions)
    return places, directions


def _given(name: str, values: npt.ArrayLike, shape: tuple[int, ...]) -> Array:
    array = floats(name, values)
    of_shape(name, array, shape)
    finite(name, array)
    return array
