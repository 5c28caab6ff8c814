"""What the compiler must know besides the formula."""

from __future__ import annotations

from dataclasses import dataclass

from graspdsl.hands.descriptions import Robot
from graspdsl.spec.program import Control


@dataclass(frozen=True, slots=True)
class Target:
    """What a pipeline drives and how: a robot in a world with a tick rate [Hz], under the spec's control settings."""

    robot: Robot
    rate: float
    control: Control
