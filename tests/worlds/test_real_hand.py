"""Observations out of joints and load cells alone: as the engine's world makes them, and as closed forms have them."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.compiler.program import Program, program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.hands.descriptions import Robot
from graspdsl.hands.fingertip_motion import FingertipMotion, LinkMotion
from graspdsl.spec.scene import GRAVITY
from graspdsl.spec.sensing import LoadCell, Touch
from graspdsl.trials.control_loop import ControlLoop
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.setup import hand_of, settings_of
from graspdsl.trials.starts import draws
from graspdsl.worlds.protocol import InfeasibleStartError, Observation, Start
from graspdsl.worlds.real_hand import Reading, RealHand
from graspdsl.worlds.rigid.world import RigidWorld
from worlds.scenes import MAIN, bullet_world, main_program, opened, with_uneven_tips

TRIO = Path(MAIN.parent, "hands", "trio_towel_roll.yaml")
FIXED = ("trials.start.roll=0.4", "trials.start.height=0.1", "trials.start.standoff=0.047")
DOWN = np.array([0.0, 0.0, -1.0])


def loads(world: RigidWorld) -> Array:
    """What object and weight put on the tips of the engine's hand, (k, 6) about the origins of their links. The engine
    tells what holds up against that, about the centres of mass."""
    levers = np.array([tip.centre + tip.weight_lever for tip in world.hand.tips])
    forces, moments = np.hsplit(-world.stage.fingertips.wrenches(), 2)
    return np.hstack([forces, moments + np.cross(levers, forces)])


def started(program: Program, world: RigidWorld) -> tuple[Start, Observation]:
    """The first start of a program's trials that its world takes up, and what it then observes."""
    random = np.random.default_rng(3)
    wanted, surface = program.spec.trials.start_of(0), program.robot.hand.palm_surface
    for start in draws(wanted, program.body, surface, random, floats=False):
        with contextlib.suppress(InfeasibleStartError):
            return start, world.reset(start, 3)
    raise AssertionError("there is no start")


def both_seen(program: Program) -> Iterator[tuple[Observation, Observation]]:
    """What the engine's world observes tick by tick, under the program, and what its joints and cells give."""
    loop = ControlLoop(program)
    with opened(bullet_world(settings_of(program))) as world:
        start, seen = started(program, world)
        hand = hand_of(program, start.position, start.rotation)
        hand.tare([Reading(seen.time - 0.02, seen.joints, loads(world))])
        while True:
            yield seen, hand.observe(Reading(seen.time, seen.joints, loads(world)))
            turn = loop.tick(seen)
            if turn.ending is not None:
                assert turn.ending.outcome is Outcome.CONVERGED
                return
            seen = world.step(turn.command)


@pytest.mark.slow
@pytest.mark.parametrize(
    "overrides",
    [(), ("scene.mount=wam",), ("scene.sensing={load-cell: {filter: 0.05, touch: {begins: 0.1}}}",)],
    ids=["gantry", "arm", "filtered"],
)
def test_observations_are_those_of_the_engines_world(overrides: tuple[str, ...]) -> None:
    """The engine tells frames of links in single precision, which is all that they differ by: turns of some 1e-7, and
    what these do to forces and points. Its Jacobians are of double precision, but for the points that they are of."""
    program = program_of(TRIO.read_text("utf-8"), TRIO.name, overrides)
    assert not program.robot.hand.couplings
    pairs = list(both_seen(program))
    touched = [seen.touching for seen, _ in pairs]
    assert not touched[0].any()
    assert touched[-1].all()
    for seen, found in pairs:
        assert found.time == seen.time
        np.testing.assert_array_equal(found.touching, seen.touching)
        np.testing.assert_array_equal(found.joints, seen.joints)
        np.testing.assert_allclose(found.points, seen.points, rtol=0.0, atol=1e-7)
        np.testing.assert_allclose(found.normals, seen.normals, rtol=0.0, atol=2e-6)
        np.testing.assert_allclose(found.forces, seen.forces, rtol=0.0, atol=2e-6)
        np.testing.assert_allclose(found.orientations, seen.orientations, rtol=0.0, atol=2e-6)
        np.testing.assert_allclose(found.jacobian, seen.jacobian, rtol=0.0, atol=2e-8)
        np.testing.assert_allclose(found.angular_jacobian, seen.angular_jacobian, rtol=0.0, atol=1e-12)
        np.testing.assert_array_equal(found.centre_of_mass, seen.centre_of_mass)


@pytest.mark.slow
def test_coupled_joints_are_where_their_ratio_has_them() -> None:
    """The engine's own lag behind a little, which the driver of a hand does not tell."""
    apart = [np.abs(found.points - seen.points).max() for seen, found in both_seen(main_program(*FIXED))]
    assert 1e-6 < max(apart) < 5e-5


# Closed forms, of tips whose centres of mass are beside their links' origins

MASS, CENTRE_OF_MASS = 0.008, np.array([0.004, 0.003, -0.002])
FAINT = LoadCell(touch=Touch(begins=1e-9, ends=1e-9))


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """The Barrett hand with such tips."""
    return with_uneven_tips(tmp_path_factory.mktemp("uneven"))


class Pressed:
    """A hand somewhere, each fingertip of which presses on something with a force [N] along ``inward`` (k, 3)."""

    def __init__(self, robot: Robot, seed: int, sensing: LoadCell = FAINT) -> None:
        random = np.random.default_rng(seed)
        self.robot, self.rotation = robot, Rotation.random(random_state=seed).as_matrix()
        self.position, self.joints = random.normal(size=3), random.uniform(0.1, 0.5, len(robot.joints))
        self.inward = random.normal(size=(len(robot.contacts), 3))
        self.inward /= np.linalg.norm(self.inward, axis=-1, keepdims=True)
        self.hand = RealHand(robot, sensing, self.position, self.rotation)

    def tared(self) -> Pressed:
        """The same, by cells whose zero is zero."""
        self.hand.tare([self.reading(-1.0)])
        return self

    @property
    def points(self) -> Array:
        """Where the tips touch, (k, 3)."""
        links, shapes = self._links, [contact.shape for contact in self.robot.hand.contacts.values()]
        centres = [link.point(np.array(shape.centre)) for link, shape in zip(links, shapes, strict=True)]
        radii = np.array([shape.radius for shape in shapes])
        return self.position + np.array(centres) @ self.rotation.T + radii[:, None] * self.inward

    @property
    def _links(self) -> list[LinkMotion]:
        return FingertipMotion(self.robot).links(self.joints)

    def loads(self, push: float) -> Array:
        """Of the weights of the tips, and of what pushes back, about the origins of the links."""
        wrenches = []
        for link, point, inward in zip(self._links, self.points, self.inward, strict=True):
            rotation, origin = self.rotation @ link.rotation, self.position + self.rotation @ link.origin
            weight, force = MASS * GRAVITY * DOWN, -push * inward
            moment = np.cross(rotation @ CENTRE_OF_MASS, weight) + np.cross(point - origin, force)
            wrenches.append(np.concatenate([(weight + force) @ rotation, moment @ rotation]))
        return np.array(wrenches)

    def reading(self, time: float, push: float = 0.0, bias: Array | float = 0.0) -> Reading:
        """With the same bias of all cells."""
        return Reading(time, self.joints, self.loads(push) + bias)


EACH_SEED = pytest.mark.parametrize("seed", range(4))


@EACH_SEED
def test_weight_is_no_touch_in_any_pose(robot: Robot, seed: int) -> None:
    """Tared in another one."""
    at, other = Pressed(robot, seed), Pressed(robot, seed + 1)
    at.joints, other.joints = other.joints, at.joints
    at.tared().joints = other.joints
    assert not at.hand.observe(at.reading(0.0)).touching.any()
    without = replace(at.reading(0.1), wrenches=np.zeros((3, 6)))
    assert at.hand.observe(without).touching.all()


@EACH_SEED
def test_contacts_are_where_tips_press(robot: Robot, seed: int) -> None:
    """Into the object, and with the force on it."""
    at = Pressed(robot, seed).tared()
    seen = at.hand.observe(at.reading(7.5, push=0.8))
    assert seen.time == 7.5
    assert seen.touching.all()
    np.testing.assert_allclose(seen.points, at.points, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(seen.normals, at.inward, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(seen.forces, 0.8 * at.inward, rtol=0.0, atol=1e-9)


@EACH_SEED
def test_taring_takes_the_mean_of_what_is_read_at_rest(robot: Robot, seed: int) -> None:
    at, bias = Pressed(robot, seed), np.array([0.5, -0.2, 0.3, 4e-3, 1e-3, -2e-3])
    at.hand.tare([at.reading(time, bias=share * bias) for time, share in ((0.0, 0.5), (0.02, 1.5), (0.04, 1.0))])
    assert not at.hand.observe(at.reading(0.06, bias=bias)).touching.any()
    seen = at.hand.observe(at.reading(0.08, push=0.8, bias=bias))
    np.testing.assert_allclose(seen.points, at.points, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(seen.forces, 0.8 * at.inward, rtol=0.0, atol=1e-9)
    at.hand.tare([at.reading(0.1)])
    assert not at.hand.observe(at.reading(0.12)).touching.any()


@EACH_SEED
def test_jacobians_are_the_differences_of_what_is_seen(robot: Robot, seed: int) -> None:
    """Of the tips' centres, which contacts that do not touch report, and of the tips' turns."""
    at, step = Pressed(robot, seed, LoadCell()).tared(), 1e-6
    seen = at.hand.observe(at.reading(0.0))
    for joint in range(len(at.joints)):
        moved = []
        for sign, time in ((-1.0, 0.1), (1.0, 0.2)):
            shifted = at.joints + sign * step * np.eye(len(at.joints))[joint]
            moved.append(at.hand.observe(Reading(time + joint, shifted, at.loads(0.0))))
        before, after = moved
        velocity = (after.points - before.points) / (2.0 * step)
        np.testing.assert_allclose(seen.jacobian[..., joint], velocity, rtol=0.0, atol=1e-8)
        turns = [Rotation.from_rotvec(each.orientations) for each in moved]
        spin = (turns[1] * turns[0].inv()).as_rotvec() / (2.0 * step)
        np.testing.assert_allclose(seen.angular_jacobian[..., joint], spin, rtol=0.0, atol=1e-8)


def test_a_contact_that_is_lost_keeps_its_normal(robot: Robot) -> None:
    at = Pressed(robot, 1).tared()
    at.hand.observe(at.reading(0.0, push=0.8))
    seen = at.hand.observe(at.reading(0.02))
    assert not seen.touching.any()
    assert not seen.forces.any()
    np.testing.assert_allclose(seen.normals, at.inward, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("times", [[0.02, 0.04, 0.06], [0.06], [0.005, 0.013, 0.06]])
def test_the_filter_knows_how_late_a_reading_is(robot: Robot, times: list[float]) -> None:
    """A step of force is followed as a first-order filter does, whichever readings were lost."""
    at = Pressed(robot, 2, LoadCell(filter=0.05, touch=FAINT.touch)).tared()
    at.hand.observe(at.reading(0.0))
    for time in times:
        seen = at.hand.observe(at.reading(time, push=1.0))
    expected = 1.0 - np.exp(-times[-1] / 0.05)
    np.testing.assert_allclose(np.linalg.norm(seen.forces, axis=-1), expected, rtol=1e-9)


def test_flaws_of_simulated_cells_are_left_out(robot: Robot) -> None:
    at = Pressed(robot, 3, LoadCell(force_noise=0.1, force_bias=1.0, force_drift=0.1, latency=0.1, filter=0.0)).tared()
    assert not at.hand.observe(at.reading(0.0)).touching.any()
    seen = at.hand.observe(at.reading(0.02, push=0.8))
    np.testing.assert_allclose(seen.forces, 0.8 * at.inward, rtol=0.0, atol=1e-9)


# Readings that are none


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"joints": np.full(10, np.nan)}, "joints of the reading hold what is no number"),
        ({"wrenches": np.full((3, 6), np.inf)}, "wrenches of the reading hold what is no number"),
        ({"joints": np.zeros(9)}, r"joints of a reading must be \(10,\), not \(9,\)"),
        ({"wrenches": np.zeros((2, 6))}, r"wrenches of a reading must be \(3, 6\), not \(2, 6\)"),
        ({"time": 0.0}, "comes after"),
        ({"time": np.nan}, "comes after"),
        ({"time": np.inf}, "comes after"),
    ],
)
def test_what_is_no_reading_leaves_nothing_behind(robot: Robot, changes: dict[str, object], said: str) -> None:
    sensing = LoadCell(filter=0.05)
    at, other = Pressed(robot, 2, sensing).tared(), Pressed(robot, 2, sensing).tared()
    for each in (at, other):
        each.hand.observe(each.reading(0.0))
    with pytest.raises(ValueError, match=said):
        at.hand.observe(replace(at.reading(0.02), **changes))
    found, meant = (each.hand.observe(each.reading(0.04, push=1.0)) for each in (at, other))
    np.testing.assert_array_equal(found.forces, meant.forces)


def test_there_is_no_zero_without_a_reading(robot: Robot) -> None:
    with pytest.raises(ValueError, match="reading at rest"):
        Pressed(robot, 0).hand.tare([])


def test_there_is_nothing_to_observe_without_a_zero(robot: Robot) -> None:
    """Cells that read nothing would be taken to touch, for the weight of the tips is taken off. Nothing is changed."""
    at = Pressed(robot, 0)
    with pytest.raises(ValueError, match="tare the hand on readings at rest"):
        at.hand.observe(at.reading(0.0))
    at.hand.tare([at.reading(0.0)])
    assert not at.hand.observe(at.reading(0.02)).touching.any()


# Where the hand stands


MIRRORED = np.diag([1.0, 1.0, -1.0])


@pytest.mark.parametrize(
    ("position", "rotation", "said"),
    [
        (None, None, "gantry stands where you say: give position"),
        (np.zeros(3), None, "gantry stands where you say: give position"),
        (None, np.eye(3), "gantry stands where you say: give position"),
        (np.zeros(3), MIRRORED, "rotation is left-handed"),
        (np.zeros(3), 2.0 * np.eye(3), "its columns unit vectors at right angles"),
        (np.zeros(3), np.eye(3) + 0.01 * np.eye(3, k=1), "its columns unit vectors at right angles"),
        (np.zeros(3), np.full((3, 3), np.nan), "its columns unit vectors at right angles"),
        (np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), r"rotation must be \(3, 3\)"),
        (np.zeros(2), np.eye(3), "position must be three numbers"),
        (np.array([0.0, np.inf, 0.0]), np.eye(3), "position must be three numbers"),
    ],
)
def test_a_hand_stands_at_a_pose(position: Array | None, rotation: Array | None, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        hand_of(main_program(), position, rotation)


def test_a_pose_may_be_rounded_and_be_lists() -> None:
    """To four digits."""
    turned = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    program = main_program()
    exact, rounded = hand_of(program, np.ones(3), turned), hand_of(program, [1, 1, 1], turned.round(4).tolist())
    reading = Reading(0.0, np.zeros(len(program.robot.joints)), np.zeros((3, 6)))
    for hand in (exact, rounded):
        hand.tare([reading])
    one, other = (hand.observe(replace(reading, time=1.0)) for hand in (exact, rounded))
    np.testing.assert_allclose(one.points, other.points, rtol=0.0, atol=1e-4)


def test_an_arm_stands_on_its_base_whatever_pose_is_given() -> None:
    program = main_program("scene.mount=wam")
    joints, nothing = np.full(len(program.robot.joints), 0.2), np.zeros((3, 6))
    seen = []
    for hand in (hand_of(program), hand_of(program, np.ones(3), MIRRORED)):
        hand.tare([Reading(0.0, joints, nothing)])
        seen.append(hand.observe(Reading(1.0, joints, nothing)).points)
    np.testing.assert_array_equal(*seen)


@pytest.mark.parametrize("sensing", ["skin", "proximity", "exact"])
def test_contacts_are_sensed_by_load_cells(sensing: str) -> None:
    with pytest.raises(DiagnosticError, match="a real hand is read by its load cells"):
        hand_of(main_program(f"scene.sensing={sensing}"))
