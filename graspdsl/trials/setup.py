"""From a program to the world that its trials run in, or to a hand of one's own."""

from __future__ import annotations

from graspdsl.arrays import Array
from graspdsl.compiler.program import Program
from graspdsl.spec.scene import InlineObject
from graspdsl.trials.loop import TrialLoop
from graspdsl.worlds.kind import Anchor, WorldSettings, fixed_to
from graspdsl.worlds.protocol import WitnessedWorld
from graspdsl.worlds.real_hand import RealHand


def settings_of(program: Program) -> WorldSettings:
    """What of a program its world is made from."""
    scene = program.spec.scene
    fixed = isinstance(scene.object, InlineObject) and scene.object.fixed
    free = Anchor.AFLOAT if scene.afloat else Anchor.NONE
    anchor = Anchor.HAND if scene.held else fixed_to(program.robot) if fixed else free
    sensing = program.world.sensor(scene.sensing)
    return WorldSettings(
        *(program.robot, program.body, scene.friction, sensing, anchor, program.probes, scene.gravity),
        effort=program.world.effort_in(scene.physics),
        backend=program.target.backend,
    )


def world_of(program: Program) -> WitnessedWorld:
    """The world of a program's scene."""
    return program.world.make(settings_of(program))


def trial_loop(program: Program) -> TrialLoop:
    """The loop that runs the program's trials in its world."""
    return TrialLoop(program, world_of(program))


def hand_of(program: Program, position: Array | None = None, rotation: Array | None = None) -> RealHand:
    """What makes observations for a program of the readings of a hand of one's own. position (3,) [m] and rotation
    (3, 3): where its mounting face is in the world when the joints of a mount without a base are all zero. An arm
    stands on its base, and a pose that is given is not read.

    Raises DiagnosticError where contacts are sensed by other than load cells, and ValueError for a mount without a base
    where there is no pose, or what is given is none.
    """
    settings = settings_of(program)
    return RealHand(program.robot, settings.sensing, position, rotation, settings.gravity)
