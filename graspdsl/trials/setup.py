"""From a program to the world that its trials run in."""

from __future__ import annotations

from graspdsl.compiler.program import Program
from graspdsl.spec.scene import InlineObject
from graspdsl.trials.loop import TrialLoop
from graspdsl.worlds.kind import Anchor, WorldSettings
from graspdsl.worlds.protocol import WitnessedWorld


def settings_of(program: Program) -> WorldSettings:
    """What of a program its world is made from."""
    scene = program.spec.scene
    fixed = isinstance(scene.object, InlineObject) and scene.object.fixed
    anchor = Anchor.HAND if scene.held else Anchor.WORLD if fixed else Anchor.NONE
    sensing = program.world.sensor(scene.sensing)
    return WorldSettings(program.robot, program.body, scene.friction, sensing, anchor, program.probes)


def world_of(program: Program) -> WitnessedWorld:
    """The world of a program's scene."""
    return program.world.make(settings_of(program))


def trial_loop(program: Program) -> TrialLoop:
    """The loop that runs the program's trials in its world."""
    return TrialLoop(program, world_of(program))
