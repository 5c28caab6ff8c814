"""From a program to the world that its trials run in."""

from __future__ import annotations

from graspdsl.compiler.program import Program
from graspdsl.spec import scene as spec
from graspdsl.trials.loop import TrialLoop
from graspdsl.worlds.bullet.probing import ProbingWorld
from graspdsl.worlds.bullet.scene import Anchor
from graspdsl.worlds.bullet.world import BulletSettings, BulletWorld
from graspdsl.worlds.floating import FloatingWorld
from graspdsl.worlds.protocol import GRAVITY


def world_of(program: Program) -> BulletWorld | FloatingWorld:
    """The world of a program's scene."""
    scene = program.spec.scene
    body = program.body
    if program.world.floats:
        return FloatingWorld(program.robot.contacts, body.shape.surface(), GRAVITY * body.mass, body.major_axis)
    fixed = isinstance(scene.object, spec.InlineObject) and scene.object.fixed
    anchor = Anchor.HAND if scene.held else Anchor.WORLD if fixed else Anchor.NONE
    settings = BulletSettings(program.robot, body, scene.friction, scene.sensor, anchor)
    return ProbingWorld(settings) if program.probes else BulletWorld(settings)


def trial_loop(program: Program) -> TrialLoop:
    """The loop that runs the program's trials in its world."""
    return TrialLoop(program, world_of(program))
