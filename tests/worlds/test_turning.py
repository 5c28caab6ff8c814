"""The rotation controllers on a ball that is held in the simulator: it turns until its contacts carry it (Eq. 4.41)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.basis.rotations import logarithm
from graspdsl.compiler.program import Program, program_of
from graspdsl.trials.setup import world_of
from graspdsl.trials.starts import pose
from graspdsl.worlds.rigid.world import RigidWorld

from .scenes import grasped, opened

pytestmark = pytest.mark.slow

SPEC = Path(__file__).parents[2] / "specs" / "chapter" / "4_41_rotate_orientation.yaml"
CLOSING, TURNING = 0, 1
TICKS = 800  # 16 s
LEVEL = {"height": 0.05, "standoff": 0.047, "yaw": 0.0, "offset": 0.0, "tilt": 0.0}


@dataclass(frozen=True)
class Turn:
    """What became of a ball: the net of its contacts' unit forces before and after, their points after, relative to
    its centre, how far it turned [rad], and the largest command."""

    before: Array
    after: Array
    points: Array
    angle: float
    largest: float


def net(world: RigidWorld, program: Program) -> Array:
    """What the contacts of Γσ press with in truth, (3,)."""
    return program.phases[TURNING].grasp.weights[:3] @ world.truth().normals


def turned(formula: str, roll: float, engine: str) -> Turn:
    """The ball of the spec, grasped with the hand rolled, and turned by a controller."""
    settings = (f"program.1.run={formula}", f"scene.world={engine}")
    program = program_of(SPEC.read_text("utf-8"), SPEC.name, settings)
    start = pose("side", {**LEVEL, "roll": roll}, program.body, program.robot.hand.palm_surface)
    world = world_of(program)
    assert isinstance(world, RigidWorld)
    with opened(world):
        seen, ((pipeline,), largest) = grasped(world, start, program), (program.pipelines()[TURNING], 0.0)
        before, stood = net(world, program), world.stage.scene.object_pose()[1]
        for _ in range(TICKS):
            command = pipeline.evaluate(seen).command
            largest = max(largest, float(np.abs(command.displacement).max()))
            seen = world.step(command)
        assert seen.touching.all()
        place, stands = world.stage.scene.object_pose()
        angle = float(np.linalg.norm(logarithm(stands @ stood.T)))
        return Turn(before, net(world, program), world.truth().points - place, angle, largest)


def degrees_from_up(direction: Array) -> float:
    """The angle of a direction (3,) from straight up."""
    return float(np.degrees(np.arccos(direction[2] / np.linalg.norm(direction))))


ONE, TWO = ("π_rgθ|γ1 {γ1, γ_g}", False), ("π_rgθ|{γ2, γ3} {γ2, γ3, γ_g}", True)
OTHERS = (
    ("π_rgθ|{γ1, γ2, γ3} {γ1, γ2, γ3, γ_g}", True),
    ("π_gθ|γ1 {γ1, γ2, γ3, γ_g}", True),
    ("π_rgθ|<γ2, γ3> {<γ2, γ3>, γ_g}", True),
)


@pytest.mark.parametrize(
    ("formula", "mirrored", "engine", "degrees"),
    [
        *((*of, "mujoco", degrees) for of in (ONE, TWO, *OTHERS) for degrees in (60.0, 120.0)),
        (*ONE, "bullet", 60.0),
        (*TWO, "bullet", 120.0),
    ],
)
def test_a_held_ball_turns_until_its_contacts_oppose_its_weight(
    formula: str, mirrored: bool, engine: str, degrees: float
) -> None:
    """One contact, two, three: the ball turns by just the angle that their net lacks, and they end beneath it. The two
    fingers press against the thumb, and outweigh it."""
    steep = degrees > 90.0
    turn = turned(formula, roll=-np.pi / 6 if steep != mirrored else np.pi / 6, engine=engine)
    assert degrees_from_up(turn.before) == pytest.approx(degrees, abs=2.0)
    assert degrees_from_up(turn.after) < 2.0
    assert np.degrees(turn.angle) == pytest.approx(degrees, abs=2.0)
    fingers, thumb = turn.points[:2].mean(axis=0), turn.points[2]
    beneath, above = (fingers, thumb) if mirrored else (thumb, fingers)
    assert beneath[2] < -0.04 < 0.04 < above[2]


@pytest.mark.parametrize("formula", ["π_rgθ|γ1 Γ", "π_rgθ|Γ Γ", "π_gθ|γ1 {γ1, γ2, γ3}", "π_rgθ|{γ1, γ2} γ3"])
def test_without_gravity_a_held_ball_stays_as_it_is(formula: str) -> None:
    """As the chapter has it under Eq. 4.41, and as ``validate`` warns."""
    turn = turned(formula, roll=np.pi / 6, engine="mujoco")
    assert turn.largest < 1e-12
    assert turn.angle < 1e-3
