"""How finely MuJoCo works physics out where a spec does not say; known without the engine."""

from __future__ import annotations

from graspdsl.worlds.kind import Effort

EFFORT = Effort(time_step=0.002, solver_iterations=100)
