"""The spaces that controllers live in: what a potential measures, and what an effector moves."""

from __future__ import annotations

import enum


class TaskSpace(enum.Enum):
    """What a potential's error is measured in; sensors map to it."""

    NET_FORCE = "net unit force (1)"
    NET_MOMENT = "net moment of unit forces (m)"
    POSITION = "contact positions (m)"
    ORIENTATION = "contact orientations (rad)"
    FORCE = "contact forces (N)"
    MOMENT = "contact moments (N·m)"
    POSTURE = "joint positions (rad or m)"
    NET_WRENCH = "net wrench of unit forces (1, m)"
    NORMAL = "unit normals (1)"


class GradientSpace(enum.Enum):
    """What a controller displaces; ``◁`` joins controllers of one gradient space only."""

    SURFACE = "ψ"
    CARTESIAN = "x"
    ROTATION = "r"
    JOINTS = "q"

    @property
    def about(self) -> str:
        """The space in words, with its unit."""
        return {
            GradientSpace.SURFACE: "surface coordinates of the contacts (rad on the model sphere)",
            GradientSpace.CARTESIAN: "Cartesian displacements of the contacts (m)",
            GradientSpace.ROTATION: "rotation of a held object with its contacts (rad)",
            GradientSpace.JOINTS: "joint displacements (m or rad)",
        }[self]


# A gradient in this space can be the reference of a controller of that task space: reference = sensed + displacement.
DISPLACES = {GradientSpace.CARTESIAN: TaskSpace.POSITION, GradientSpace.ROTATION: TaskSpace.ORIENTATION}
