"""The kinds of joints, by their names in a URDF."""

from __future__ import annotations

FIXED, REVOLUTE, CONTINUOUS, PRISMATIC = "fixed", "revolute", "continuous", "prismatic"
ROTATING = (REVOLUTE, CONTINUOUS)
HINGES = (*ROTATING, PRISMATIC)
