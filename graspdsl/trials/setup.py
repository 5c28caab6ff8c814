"""From a program to the world that its trials run in."""

from __future__ import annotations

from graspdsl.compiler.program import Program
from graspdsl.objects.shapes import Body, Box, Cylinder, Shape, Sphere, catalogue
from graspdsl.spec import scene as spec
from graspdsl.trials.loop import TrialLoop
from graspdsl.worlds.bullet.touch import TouchSettings
from graspdsl.worlds.bullet.world import BulletSettings, BulletWorld


def body_of(choice: str | spec.InlineObject) -> Body:
    """The object that a scene names or describes."""
    if isinstance(choice, str):
        return catalogue()[choice]
    return Body(choice.name or "object", _shape(choice.shape), choice.mass)


def _shape(shape: spec.Cylinder | spec.Sphere | spec.Box) -> Shape:
    match shape:
        case spec.Cylinder():
            return Cylinder(shape.diameter, shape.height)
        case spec.Sphere():
            return Sphere(shape.diameter)
        case spec.Box():
            return Box(shape.size)


def world_of(program: Program) -> BulletWorld:
    """The world of a program's scene."""
    scene = program.spec.scene
    touch = TouchSettings(sensing=scene.sensing)
    return BulletWorld(BulletSettings(program.robot, body_of(scene.object), scene.friction, touch))


def trial_loop(program: Program) -> TrialLoop:
    """The loop that runs the program's trials in its world."""
    return TrialLoop(program, world_of(program), body_of(program.spec.scene.object))
