"""The table of effector transforms."""

from __future__ import annotations

from collections.abc import Mapping

from graspdsl.basis.effector import Effector
from graspdsl.basis.joint_effectors import (
    ForceJacobian,
    MomentJacobian,
    OrientationJacobian,
    PositionJacobian,
    PostureSelection,
)
from graspdsl.basis.rotation_effectors import ForceResidualRotation, MomentResidualRotation
from graspdsl.basis.surface_effectors import (
    ForceResidualDisplacement,
    ForceResidualSurface,
    MomentResidualDisplacement,
    MomentResidualSurface,
    WrenchResidualDisplacement,
    WrenchResidualSurface,
)

EFFECTORS: Mapping[str, Effector] = {
    effector.symbol: effector
    for effector in (
        ForceResidualSurface(),
        ForceResidualDisplacement(),
        ForceResidualRotation(),
        MomentResidualSurface(),
        MomentResidualDisplacement(),
        MomentResidualRotation(),
        WrenchResidualSurface(),
        WrenchResidualDisplacement(),
        PositionJacobian(),
        OrientationJacobian(),
        ForceJacobian(),
        MomentJacobian(),
        PostureSelection(),
    )
}
