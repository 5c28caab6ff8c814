"""The syntax tree of the notation: what a formula says, with the place of every part.

Names are kept in their canonical (Unicode) spelling: ``φ_fr``, ``τ_frx``, ``γ1``, ``Γ_m``, ``π_gx``, ``κ_f``.
Places do not count when two trees are compared, so a formula and its reprint in another spelling are equal.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from graspdsl.diagnostics import Span

NOWHERE = Span(1, 1, 1, 1)


@dataclass(frozen=True, slots=True)
class Name:
    """A name in canonical spelling: a resource (γ1, γ_g, a joint set), a set (Γ), a parameter (κ_f, x_ref)."""

    text: str
    span: Span = field(default=NOWHERE, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Virtual:
    """A virtual contact ``<γ2, γ3>``: contacts that act as one (Sec. 4.4.1). May nest; may be empty (an error)."""

    members: tuple[Resource, ...]
    span: Span = field(default=NOWHERE, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class ResourceSet:
    """A set written out: ``{γ1, <γ2, γ3>}``. May be empty (an error found by the checker)."""

    members: tuple[Resource, ...]
    span: Span = field(default=NOWHERE, compare=False, repr=False)


Resource = Name | Virtual
Resources = Name | Virtual | ResourceSet


@dataclass(frozen=True, slots=True)
class Transform:
    """A sensor or effector transform over resources: ``σ_fr(Γ)``."""

    name: Name
    resources: Resources
    span: Span = field(default=NOWHERE, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Vector:
    """A reference written out: ``(0.1, 0, 0.3)``; one number is a vector of one."""

    values: tuple[float, ...]
    span: Span = field(default=NOWHERE, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class ScaledSensor:
    """A reference made from a sensor: ``κ_f σ_n(Γ)``, ``0.5 σ_n(Γ)`` or ``σ_n(Γ)`` (factor None)."""

    factor: float | Name | None
    sensor: Transform
    span: Span = field(default=NOWHERE, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Controller:
    """``φ|τ(Γτ) σ(Γσ) (reference)``: a potential with its effector and its sensor transform (Eq. 3.5)."""

    potential: Name
    effector: Transform
    sensor: Transform
    reference: Reference | None = None
    span: Span = field(default=NOWHERE, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Abbreviation:
    """``π|Γτ Γσ (reference)``: a named controller applied to resources, effector resources first.

    More than one resource argument on a side is written as a tuple, ``π_sq|(Γ_m, Γ_τ) (Γ_m, Γ_σ) (x_ref)``
    (Eq. 4.26). A controller defined without resources is used by its bare name: both tuples are empty.
    """

    name: Name
    effector: tuple[Resources, ...] = ()
    sensor: tuple[Resources, ...] = ()
    reference: Reference | None = None
    span: Span = field(default=NOWHERE, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class SubjectTo:
    """``a ◁ b ◁ c``: the rightmost term has the highest priority. At least two terms, none a bare SubjectTo
    unless the formula has brackets there."""

    terms: tuple[Expression, ...]
    span: Span = field(default=NOWHERE, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Then:
    """``a then b``: a to convergence, then b (C*, Sec. 4.1.4). At least two steps."""

    steps: tuple[Expression, ...]
    span: Span = field(default=NOWHERE, compare=False, repr=False)


Expression = Controller | Abbreviation | SubjectTo | Then
Reference = Vector | Name | ScaledSensor | Expression


@dataclass(frozen=True, slots=True)
class Head:
    """The left side of a definition: ``π_s|Γ_m Γ_m (x_ref)``, or a bare ``π_mine``.

    A resource parameter that appears twice (``Γ_m Γ_m``) asks for equal arguments (Eq. 4.18).
    """

    name: Name
    effector: tuple[Name, ...] = ()
    sensor: tuple[Name, ...] = ()
    reference: Name | None = None
    span: Span = field(default=NOWHERE, compare=False, repr=False)
