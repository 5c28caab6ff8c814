"""From a program to the world that its trials run in."""

from __future__ import annotations

from dataclasses import replace

from graspdsl.compiler.program import Program
from graspdsl.objects.floating_surface import surface_of
from graspdsl.objects.shapes import Body, catalogue, shape_from
from graspdsl.spec import scene as spec
from graspdsl.trials.loop import TrialLoop
from graspdsl.worlds.bullet.probing import ProbingWorld
from graspdsl.worlds.bullet.scene import Anchor
from graspdsl.worlds.bullet.world import BulletSettings, BulletWorld
from graspdsl.worlds.floating import FloatingWorld

DEFAULT_MASS = 0.5  # kg
GRAVITY = 9.81  # m/s²


def body_of(choice: str | spec.InlineObject) -> Body:
    """The object that a scene names or describes."""
    if isinstance(choice, str):
        return catalogue()[choice]
    if choice.shape is None:
        known = catalogue()[choice.like or ""]
        return replace(known, name=choice.name or known.name, mass=choice.mass or known.mass)
    kind, fields = choice.shape
    return Body(choice.name or kind, shape_from({kind: fields}), choice.mass or DEFAULT_MASS)


def world_of(program: Program) -> BulletWorld | FloatingWorld:
    """The world of a program's scene."""
    scene = program.spec.scene
    body = body_of(scene.object)
    if program.world.floats:
        return FloatingWorld(program.robot.contacts, surface_of(body.shape), GRAVITY * body.mass)
    fixed = isinstance(scene.object, spec.InlineObject) and scene.object.fixed
    anchor = Anchor.HAND if scene.held else Anchor.WORLD if fixed else Anchor.NONE
    settings = BulletSettings(program.robot, body, scene.friction, scene.sensor, anchor, GRAVITY)
    return ProbingWorld(settings) if program.probes else BulletWorld(settings)


def trial_loop(program: Program) -> TrialLoop:
    """The loop that runs the program's trials in its world."""
    return TrialLoop(program, world_of(program), body_of(program.spec.scene.object))
