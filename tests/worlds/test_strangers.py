"""A stranger's world, touch, shape, mount, hand and objects at work, each in its table."""

from __future__ import annotations

import numpy as np
import pytest
from compiler.specs import floating
from contracts.folders import JAW, KITCHEN, PORTAL
from graspdsl_stranger.shape import Cup
from graspdsl_stranger.touch import ForceCell, ForceCells
from graspdsl_stranger.world import FASTEST, Gliding

from graspdsl.compiler.program import program_of
from graspdsl.hands.descriptions import hands, mounts
from graspdsl.objects.shapes import Body, catalogue
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.setup import trial_loop
from graspdsl.worlds.kinds import WORLDS
from graspdsl.worlds.touch.sensors import TACTILE_SENSORS

from .scenes import ROLL, bullet_world, grasped, main_program, opened, settings, side_start

pytestmark = pytest.mark.slow

CUP = Body("cup", Cup(bottom=0.07, top=0.09, height=0.14), 0.3)
RADIUS = 0.0115  # m, of the Barrett hand's fingertips
FRICTION = 0.4


JAWS = """\
graspdsl: 1
name: jaws
scene: {{world: bullet, hand: parallel-jaw, mount: {mount}, object: {body}}}
resources: {{γ1: left, γ2: right, Γ: "{{γ1, γ2}}"}}
parameters: {{κ_f: 0.5}}
program:
  - {{run: π_close|Γ Γ, until: {{contact: all, hold: 0.2}}, limit: 8.0}}
  - run: π_s|Γ Γ (π_gx|Γ Γ)
    until: {{force_residual: 0.1, moment_residual: 0.005, force_error: 0.1, hold: 0.5}}
trials: {{start: {{roll: 0.1, height: 0.06, standoff: 0.04}}}}
"""


@pytest.fixture(autouse=True)
def _strangers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(WORLDS, "gliding", Gliding())
    monkeypatch.setitem(TACTILE_SENSORS, "force-cell", ForceCells)
    monkeypatch.setitem(hands(), "parallel-jaw", JAW)
    monkeypatch.setitem(mounts(), "portal", PORTAL)
    for name, body in KITCHEN.items():
        monkeypatch.setitem(catalogue(), name, body)


@pytest.mark.parametrize("mount", ["gantry", "portal"])
@pytest.mark.parametrize("body", KITCHEN)
def test_two_jaws_grasp(body: str, mount: str) -> None:
    """They close, and end opposite each other: both push along one line."""
    trial = trial_loop(program_of(JAWS.format(mount=mount, body=body), "jaws.yaml")).run(0, 1)
    assert trial.record.outcome is Outcome.CONVERGED
    assert np.linalg.norm(np.diff(trial.trajectory["joints"][[0, -1]], axis=0)) > 1e-3


def test_the_barrett_hand_grasps_on_a_strangers_mount() -> None:
    program = main_program("scene.mount=portal", "trials.start.roll=-0.74", "trials.start.height=0.12")
    assert program.robot.mount is PORTAL
    assert trial_loop(program).run(0, 1).record.outcome is Outcome.CONVERGED


@pytest.mark.parametrize("body", [ROLL, CUP], ids=lambda body: body.name)
def test_force_cells_feel_the_force_and_guess_its_place(body: Body) -> None:
    """All of the force, friction and all; its place to within the angle of friction on the tip."""
    assert "force-cell" in WORLDS["bullet"].senses
    with opened(bullet_world(settings(sensing=ForceCell(), body=body, friction=FRICTION))) as world:
        seen = grasped(world, side_start(body, roll=0.3, height=0.07), main_program())
        truth = world.truth()
    np.testing.assert_allclose(seen.forces, truth.forces, atol=0.01)
    off = np.linalg.norm(seen.points - truth.points, axis=1)
    assert off.max() < RADIUS * np.arctan(FRICTION) + 5e-4
    assert off.max() > 1e-3  # without a moment, friction turns the guess


def test_gliding_contacts_take_their_time() -> None:
    """From the same draws as floating ones to a grasp, never faster than they can."""
    text = floating("π_gx|{γ1, γ2, γ3} {γ1, γ2, γ3}", until="force_residual: 0.1, moment_residual: 0.005, hold: 0.4")
    fast, slow = (
        trial_loop(program_of(text.replace("world: floating", f"world: {world}"), "test.yaml")).run(0, 3)
        for world in ("floating", "gliding")
    )
    assert fast.record.outcome is slow.record.outcome is Outcome.CONVERGED
    quick, late = (trial.trajectory["points"].astype(float) for trial in (fast, slow))
    np.testing.assert_array_equal(quick[0], late[0])
    steps = [np.linalg.norm(np.diff(points, axis=0), axis=-1).max() * Gliding.rate for points in (quick, late)]
    assert steps[1] <= FASTEST * 1.001 < steps[0]
