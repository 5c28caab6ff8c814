"""Fingertip shapes in hand files: convex surfaces that a load cell or a skin locates contacts on."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from graspdsl.spec.fields import Model

Metres = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Place = tuple[float, float, float]


class SphereTip(Model):
    """A sphere, centred at ``centre`` in the frame of the fingertip's link [m]."""

    centre: Place = (0.0, 0.0, 0.0)
    radius: Metres


class EllipsoidTip(Model):
    """An ellipsoid with semi-axes [m] along the axes of a frame that ``rpy`` [rad] turns from the link's."""

    centre: Place = (0.0, 0.0, 0.0)
    semi_axes: tuple[Metres, Metres, Metres]
    rpy: Place = (0.0, 0.0, 0.0)


class CapsuleTip(Model):
    """A capsule: all points within ``radius`` of a segment of ``length`` [m] about ``centre``, along ``axis``."""

    centre: Place = (0.0, 0.0, 0.0)
    radius: Metres
    length: Metres
    axis: Place = (1.0, 0.0, 0.0)


FingertipShape = SphereTip | EllipsoidTip | CapsuleTip
