"""The spaces that controllers live in: what a potential measures, and what an effector moves."""

from __future__ import annotations

import enum
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TaskSpace:
    """What a potential's error is measured in; sensors map to it. ``unit``: of its numbers."""

    name: str
    unit: str

    @property
    def about(self) -> str:
        """The space in words, with its unit."""
        return f"{self.name} ({self.unit})"


NET_FORCE = TaskSpace("net unit force", "1")
NET_MOMENT = TaskSpace("net moment of unit forces", "m")
NET_WRENCH = TaskSpace("net wrench of unit forces", "1, m")
POSITION = TaskSpace("contact positions", "m")
ORIENTATION = TaskSpace("contact orientations", "rad")
FORCE = TaskSpace("contact forces", "N")
MOMENT = TaskSpace("contact moments", "N·m")
POSTURE = TaskSpace("joint positions", "rad or m")
NORMAL = TaskSpace("unit normals", "1")


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
