"""The priority certificate of trials: it holds on a ball as its Jacobian has it, and fails by what can go wrong."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from graspdsl.api.controllers import Controller
from graspdsl.arrays import Array
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.program import Program, program_of, program_of_expression
from graspdsl.objects.sphere import SmoothSphere
from graspdsl.trials.batches import led
from graspdsl.trials.priorities import CAP, CAUSES, LOWER, NOT_CARRIED_OUT, TOUCH, UNKNOWN, PriorityLog
from graspdsl.trials.setup import trial_loop, world_of
from graspdsl.trials.stages import stages_of
from graspdsl.trials.starts import draws, generator
from graspdsl.worlds.floating import sensed, slid
from graspdsl.worlds.protocol import Command, InfeasibleStartError, Observation, Start

SPECS = Path(__file__).parents[2] / "specs"
RADIUS = 0.05  # m
SPHERE = SmoothSphere(2 * RADIUS)
LEVELS = "φ_fr|τ_frx({γ1, γ2}) σ_fr({γ1, γ2}) ◁ φ_fr|τ_frx(Γ) σ_fr(Γ)"  # on a ball there is no moment to strive for
LAG = 5  # ticks in which joints have come to where they were sent


def floating(*overrides: str) -> Program:
    """Two contacts that would be opposite, subject to a grasp of three, on a ball as large as gradients assume."""
    name = "compare/moment_subject_to_force.yaml"
    given = ("scene.object={sphere: {diameter: 0.1}}", f'program.0.run="{LEVELS}"', *overrides)
    return program_of((SPECS / name).read_text("utf-8"), name, given)


def pipeline(*overrides: str) -> Pipeline:
    """Of its one stage."""
    (((found),),) = floating(*overrides).pipelines()
    return found


def points(seed: int) -> Array:
    """Where three contacts are on the ball, and five more that nothing moves, (8, 3) [m]."""
    return SPHERE.sample(8, np.random.default_rng(seed))


def following(made: Pipeline, start: Array, ticks: int) -> dict[str, Array]:
    """The channels of a trial from points on the ball."""
    log, here = PriorityLog([made], 1), start
    for tick in range(ticks + 1):
        seen = sensed(SPHERE, here, tick / 50, 0.0)
        now = made.ticks(led(seen))
        log.note(np.array([tick]), np.array([0]), 0, led(led(seen)), led(now))
        here = slid(SPHERE, here, now.displacement[0])
    return {name: values[:ticks, 0] for name, values in log.channels(0, ticks + 1).items()}


# It holds


def test_it_holds_on_a_ball_without_a_cap() -> None:
    """By the Jacobian to rounding; as seen up to what is quadratic in the step, which falls by four with half of it."""
    coarse, fine = (
        pipeline("control.nullspace=task", "control.cap=0.1", f"control.step={step}") for step in (4e-3, 2e-3)
    )
    for seed in range(5):
        found, halved = (following(made, points(seed), 1) for made in (coarse, fine))
        assert found["predicted_disturbance"][0] < 1e-14
        assert found["observed_disturbance"][0] > 1e-6
        assert halved["observed_disturbance"][0] == pytest.approx(found["observed_disturbance"][0] / 4, rel=0.1)


@pytest.mark.parametrize("nullspace", ["task", "gradient"])
def test_it_is_the_difference_between_two_worlds_of_which_one_has_no_lower_level(nullspace: str) -> None:
    """The command and that of the level alone, each carried out from the same contacts: the difference of what is
    sensed then is what was predicted, up to what is quadratic in the step."""
    for seed in range(5):
        errors = []
        for step in (2e-4, 1e-4):
            made = pipeline(f"control.nullspace={nullspace}", "control.cap=0.1", f"control.step={step}")
            seen = sensed(SPHERE, points(seed), 0.0, 0.0)
            (priority,), values = made.priorities, made.values(seen)
            after = [
                made.values(sensed(SPHERE, slid(SPHERE, points(seed), values[command]), 0.0, 0.0))[priority.sensed]
                for command in (made.command, priority.alone)
            ]
            predicted = made.ticks(seen).parts[0].sum(axis=0)
            errors.append(np.linalg.norm(after[0] - after[1] - predicted))
            if nullspace == "gradient":
                assert errors[-1] < 0.05 * np.linalg.norm(predicted)
        assert errors[1] == pytest.approx(errors[0] / 4, rel=0.1)


# It fails


def test_a_cap_breaks_it() -> None:
    """It leaves the level alone room for what the lower one takes."""
    found = following(pipeline("control.nullspace=task", "control.cap=0.001"), points(1), 5)
    assert found["predicted_disturbance"].min() > 1e-4
    assert set(found["disturbance_by_cause"].argmax(axis=-1)) == {CAUSES.index(CAP)}


def test_a_gradient_keeps_one_direction_of_three() -> None:
    found = following(pipeline("control.nullspace=gradient", "control.cap=0.1", "control.step=0.002"), points(2), 5)
    lower = found["disturbance_by_cause"][:, CAUSES.index(LOWER)]
    np.testing.assert_allclose(lower, found["observed_disturbance"], rtol=0.1)
    assert found["predicted_disturbance"].min() > 1e-3


def test_a_wrong_radius_is_what_the_jacobian_does_not_know() -> None:
    wrong = ("control.curvature_radius=0.1", "control.step=0.0005")
    found = following(pipeline("control.nullspace=task", "control.cap=0.1", *wrong), points(3), 3)
    assert found["predicted_disturbance"].max() < 1e-12
    unknown = found["disturbance_by_cause"][:, CAUSES.index(UNKNOWN)]
    np.testing.assert_allclose(unknown, found["observed_disturbance"], rtol=0.05)
    assert unknown.min() > 1e-3


@dataclasses.dataclass
class SoftContacts:
    """A hand on springs: contacts of a stiffness [N/m] that answer what is pressed, or that give way and lose touch."""

    stiffness: float = 1000.0
    creeps: float = 0.0
    carried_out: float = 1.0
    lost: bool = False

    def follow(self, made: Pipeline, seen: Observation, ticks: int) -> tuple[PriorityLog, Array]:
        """The log of a trial, and its times (ticks + 1,) [s]."""
        log = PriorityLog([made], 1)
        for tick in range(ticks + 1):
            now = made.ticks(led(seen))
            log.note(np.array([tick]), np.array([0]), 0, led(led(seen)), led(now))
            step = self.carried_out * now.displacement[0]
            depth = np.sum((seen.jacobian @ step) * seen.normals, axis=-1, keepdims=True)
            forces = seen.forces * (1.0 - self.creeps) + self.stiffness * depth * seen.normals
            touching = seen.touching.copy()
            if self.lost and tick == ticks - 1:
                touching[2], forces[2] = False, 0.0
            seen = dataclasses.replace(seen, joints=seen.joints + step, forces=forces, touching=touching)
        return log, np.arange(ticks + 1) / 50


def held() -> tuple[Pipeline, Observation]:
    """A force level above a position, on fingertips that all press with 1 N."""
    move = "φ_p|τ_p({γ1, γ2, γ3}) σ_p({γ1, γ2, γ3}) (0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1)"
    press = "φ_f|τ_f({γ1, γ2, γ3}) σ_f({γ1, γ2, γ3}) (κ_f σ_n({γ1, γ2, γ3}))"
    program = program_of_expression(f"{move} ◁ {press}")
    ((made,),) = dataclasses.replace(
        program,
        spec=program.spec.model_copy(update={"control": program.spec.control.model_copy(update={"nullspace": "task"})}),
    ).pipelines()
    seen, (lower, upper) = Controller(program, made).example(), program.target.limits
    return made, dataclasses.replace(seen, joints=0.5 * (lower + upper))


def test_a_stiff_hand_that_does_as_it_is_told_keeps_its_forces() -> None:
    """And the stiffness is found."""
    made, seen = held()
    log, time = SoftContacts().follow(made, seen, 20)
    (found,) = log.disturbances(0, time)
    assert (found.level, found.stage, found.rank) == ("φ_f", 0, made.evaluate(seen).ranks[0])
    assert found.stiffness == pytest.approx(1000.0, rel=1e-9)
    assert found.predicted.size < 1e-12
    assert found.observed.size < 1e-9


@pytest.mark.parametrize(
    ("world", "cause"),
    [
        (SoftContacts(creeps=0.1), UNKNOWN),
        (SoftContacts(carried_out=0.5), NOT_CARRIED_OUT),
        (SoftContacts(lost=True), TOUCH),
    ],
)
def test_soft_contacts_lame_joints_and_lost_touch_break_it(world: SoftContacts, cause: str) -> None:
    made, seen = held()
    log, time = world.follow(made, seen, 20)
    (found,), channels = log.disturbances(0, time), log.channels(0, 21)
    assert found.predicted.size < 1e-12
    assert found.observed.cause == cause
    assert found.observed.size > 5e-3
    assert found.observed.time == time[found.observed.tick]
    if world.lost:
        assert found.observed.tick == 19
        assert found.observed.size == pytest.approx(np.linalg.norm(seen.forces[2]), rel=0.5)
    causes = channels["disturbance_by_cause"][:20, 0]
    np.testing.assert_allclose(causes.sum(axis=-1), channels["observed_disturbance"][:20, 0], atol=1e-12)
    assert np.isnan(channels["observed_disturbance"][20]).all()


# In trials


@pytest.mark.slow
def test_physics_and_a_real_hand() -> None:
    """In the simulator a force level is disturbed by what no Jacobian knows, and the command does next to nothing."""
    name = "towel_roll_two_contacts.yaml"
    program = program_of((SPECS / name).read_text("utf-8"), name, ("control.nullspace=task", "program.1.limit=2.0"))
    [trial] = trial_loop(program).run_all([1], 2006)
    inner, force = trial.record.priorities
    assert (inner.level, force.level) == ("φ_fr", "φ_f")
    sliding = trial.trajectory["stage"] == 1
    assert np.nanmedian(trial.trajectory["predicted_disturbance"][sliding, 1]) < 1e-12
    assert np.nanmedian(trial.trajectory["observed_disturbance"][sliding, 1]) > 1e-3
    assert np.isnan(trial.trajectory["observed_disturbance"][~sliding]).all()
    at = force.observed.tick
    assert trial.trajectory["observed_disturbance"][at, 1] == pytest.approx(force.observed.size, rel=1e-6)


@pytest.mark.slow
def test_hands_move_apart_as_predicted() -> None:
    """The simulator from the same state, by replay of the same commands, with the command and with that of the level
    alone: how far the joints then are apart does to the level what was predicted, but for how they lag."""
    name = "towel_roll_two_contacts.yaml"
    program = program_of((SPECS / name).read_text("utf-8"), name)
    close, slide = (stage.pipeline for stage in stages_of(program))
    world, random = world_of(program), generator(2006, 1)
    commands: list[Command] = []

    def begun(start: Start, seed: int) -> Observation:
        seen = world.reset(start, seed)
        for command in commands:
            seen = world.step(command)
        return seen

    for start in draws(program.spec.trials.start_of(1), program.body, program.robot.hand.palm_surface, random):
        seed = int(random.integers(2**31))
        try:
            seen = begun(start, seed)
        except InfeasibleStartError:
            continue
        break
    while not seen.touching.all() or len(commands) < 60:
        commands.append((close if not seen.touching.all() or len(commands) < 40 else slide).evaluate(seen).command)
        seen = world.step(commands[-1])
    priority, values, ticks = slide.priorities[0], slide.values(seen), slide.ticks(seen)
    after = []
    for step in (ticks.displacement, values[priority.alone]):
        np.testing.assert_array_equal(begun(start, seed).joints, seen.joints)
        world.step(Command("q", step))
        for _ in range(LAG):
            at_rest = world.step(Command("q", np.zeros_like(step)))
        after.append(at_rest.joints)
    world.close()
    apart, predicted = values[priority.effect] @ (after[0] - after[1]), ticks.parts[0].sum(axis=0)[:3]
    assert np.linalg.norm(predicted) > 1e-4
    np.testing.assert_allclose(apart, predicted, atol=0.2 * np.linalg.norm(predicted))
