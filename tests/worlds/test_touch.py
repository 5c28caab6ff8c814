"""Every tactile sensor in the simulator: against its truth, tared, late, with hysteresis, on tips of other shapes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.compiler.complaints import Complaints
from graspdsl.compiler.program import program_of
from graspdsl.compiler.scene_check import check_sensing
from graspdsl.hands.descriptions import HERE, Contact, Robot
from graspdsl.hands.fingertips import EllipsoidTip
from graspdsl.objects.ellipsoid import SmoothEllipsoid
from graspdsl.spec.loading import read_spec
from graspdsl.spec.sensing import Exact, LoadCell, Proximity, Skin, TactileSensor, Touch
from graspdsl.trials.setup import settings_of
from graspdsl.worlds.kind import Anchor
from graspdsl.worlds.protocol import Observation
from graspdsl.worlds.rigid.world import RigidWorld
from graspdsl.worlds.touch.compliance import STIFFNESS

from .scenes import (
    MAIN,
    ROBOT,
    bullet_world,
    grasped,
    main_program,
    moved,
    numbers,
    opened,
    run_phase,
    settings,
    side_start,
    still,
    with_uneven_tips,
)

pytestmark = pytest.mark.slow

PERFECT = {"load-cell": LoadCell(), "skin": Skin(), "proximity": Proximity(), "exact": Exact()}
FLAWED = {
    "load-cell": LoadCell(force_noise=0.02, moment_noise=2e-4, force_bias=0.5, moment_bias=5e-3, latency=0.02),
    "skin": Skin(taxel_noise=2e-3, taxel_bias=0.02, taxel_quantum=2e-3, latency=0.02),
    "proximity": Proximity(distance_noise=5e-5, direction_noise=0.05, distance_quantum=1e-5, latency=0.01),
}
FORCE_ERROR = {"proximity": 0.05}  # N: a dent tells nothing of the damping in the tip, which friction makes last
DAMPED = {"proximity": 0.15}  # N, of 30 N·s/m at 5 mm/s
ONLY_NORMAL = ("skin", "proximity")  # which feel no friction
DENT = 5e-4  # m: what a soft tip gives way


def errors(seen: Observation, world: RigidWorld) -> tuple[float, float]:
    """The largest distance [m] of sensed from true points and angle [rad] between normals."""
    truth = world.truth()
    normals = np.einsum("ki,ki->k", seen.normals, truth.normals)
    return np.linalg.norm(seen.points - truth.points, axis=1).max(), np.arccos(np.minimum(1.0, normals)).max()


def normal_forces(vectors: Array, normals: Array) -> Array:
    """The parts of forces (k, 3) along normals."""
    return np.asarray(np.einsum("ki,ki->k", vectors, normals))


def rested(world: RigidWorld, seen: Observation, ticks: int = 40) -> Observation:
    """What is seen after some ticks without motion."""
    for _ in range(ticks):
        seen = world.step(still())
    return seen


@pytest.mark.parametrize("name", PERFECT)
@pytest.mark.parametrize("roll", [0.0, 0.6])
def test_a_perfect_sensor_agrees_with_the_truth_at_rest(name: str, roll: float) -> None:
    with opened(bullet_world(settings(sensing=PERFECT[name]))) as world:
        seen = rested(world, grasped(world, side_start(roll=roll), main_program()))
        point, angle = errors(seen, world)
        assert point < DENT
        assert angle < 0.02
        truth = world.truth()
        pressed = normal_forces(truth.forces, truth.normals)
        np.testing.assert_allclose(normal_forces(seen.forces, seen.normals), pressed, atol=FORCE_ERROR.get(name, 0.01))
        assert pressed.min() > 0.2


@pytest.mark.parametrize("name", ["skin", "proximity"])
def test_what_feels_pressure_feels_no_friction(name: str) -> None:
    with opened(bullet_world(settings(sensing=PERFECT[name]))) as world:
        seen = rested(world, grasped(world, side_start(roll=0.6), main_program()))
        across = np.linalg.norm(np.cross(seen.forces, seen.normals), axis=1)
        truth = world.truth()
        assert np.linalg.norm(np.cross(truth.forces, truth.normals), axis=1).max() > 0.05
        assert across.max() < 1e-9


@pytest.mark.parametrize("name", FLAWED)
def test_a_flawed_sensor_is_near_the_truth(name: str) -> None:
    with opened(bullet_world(settings(sensing=FLAWED[name]))) as world:
        seen = rested(world, grasped(world, side_start(roll=0.3), main_program()))
        found = []
        for _ in range(60):
            seen = world.step(still())
            found.append(errors(seen, world))
        points, angles = np.array(found).T
        assert np.median(points) < 1.5e-3
        assert np.median(angles) < 0.08
        assert angles.std() > 1e-4  # there is noise


@pytest.mark.parametrize("name", FLAWED)
def test_noise_comes_from_the_seed_alone(name: str) -> None:
    shown = []
    for seed in (3, 3, 4):
        with opened(bullet_world(settings(sensing=FLAWED[name]))) as world:
            world.reset(side_start(), seed)
            shown.append(numbers(rested(world, world.step(moved(base_1=0.05, base_2=0.05, base_3=0.05)), 10)))
    assert shown[0] == shown[1]
    if name == "proximity":  # which feels before it touches
        assert shown[0] != shown[2]


@pytest.mark.parametrize("perfect", [LoadCell(rate=500.0), Skin(rate=500.0)])
def test_taring_takes_the_bias_away(perfect: LoadCell | Skin) -> None:
    """With a bias and no noise, every number is that of the same sensor without the bias."""
    bias = {"force_bias": 0.5, "moment_bias": 5e-3} if isinstance(perfect, LoadCell) else {"taxel_bias": 0.05}
    shown = []
    for sensing in (perfect.model_copy(update={"tare": 0.5}), perfect.model_copy(update={"tare": 0.5, **bias})):
        with opened(bullet_world(settings(sensing=sensing.model_copy(update={"filter": 0.0})))) as world:
            seen = [world.reset(side_start(), 5)]
            seen += [world.step(moved(base_1=0.01, base_2=0.01, base_3=0.01)) for _ in range(40)]
            assert seen[-1].touching.any()
            shown.append(seen)
    for clean, tared in zip(*shown, strict=True):
        np.testing.assert_allclose(tared.forces, clean.forces, atol=1e-9)
        np.testing.assert_allclose(tared.points, clean.points, atol=1e-9)


def test_the_time_to_tare_is_counted_apart() -> None:
    with opened(bullet_world(settings(sensing=LoadCell(force_bias=0.1)))) as world:
        assert world.info.tare_s == 0.5
        assert world.reset(side_start(), 0).time == 0.0
    with opened(bullet_world(settings(sensing=LoadCell(tare=0.2)))) as world:
        assert world.info.tare_s == 0.2
    with opened(bullet_world(settings())) as world:
        assert world.info.tare_s == 0.0


@pytest.mark.parametrize("kind", [LoadCell, Skin, Proximity])
def test_latency_shows_the_force_of_ticks_before(kind: type[LoadCell | Skin | Proximity]) -> None:
    shown = []
    for latency in (0.0, 0.04):
        with opened(bullet_world(settings(sensing=kind(latency=latency)))) as world:
            world.reset(side_start(), 0)
            seen = [world.step(moved(base_1=0.01, base_2=0.01, base_3=0.01)) for _ in range(40)]
            shown.append([np.linalg.norm(now.forces, axis=1) for now in seen])
    prompt, late = np.array(shown)
    assert prompt[-1].max() > 1.0
    np.testing.assert_allclose(late[2:], prompt[:-2], atol=2e-3)  # the weight of a tip that turns is told late


@pytest.mark.parametrize("name", PERFECT)
def test_a_touch_ends_below_where_it_begins(name: str) -> None:
    sensing = PERFECT[name].model_copy(update={"touch": Touch(begins=0.6, ends=0.2)})
    with opened(bullet_world(settings(sensing=sensing, anchor=Anchor.WORLD))) as world:
        world.reset(side_start(), 0)
        pressed, touched = [], []
        for direction in [1] * 440 + [-1] * 200:
            seen = world.step(moved(base_3=3.5e-4 * direction))
            truth = world.truth()
            felt = normal_forces(truth.forces, truth.normals) if name in ONLY_NORMAL else truth.forces
            pressed.append(np.nan_to_num(np.linalg.norm(felt.reshape(3, -1), axis=1))[2])
            touched.append(bool(seen.touching[2]))
    began, ended = touched.index(True), len(touched) - touched[::-1].index(True)
    assert all(touched[began:ended])
    slack = DAMPED.get(name, 0.02)
    assert max(pressed[:began]) < 0.6 + slack
    assert pressed[began] > 0.6 - slack
    assert min(pressed[began:ended]) > 0.2 - slack
    assert pressed[ended] < 0.2 + slack
    assert max(pressed[:began]) > 0.3  # it was pressed as hard before the touch began
    assert min(pressed[began:ended]) < 0.3  # as it was when the touch had not ended yet


def test_proximity_knows_the_normal_before_it_touches() -> None:
    with opened(bullet_world(settings(sensing=Proximity(range=0.05)))) as world:
        ahead = world.reset(side_start(roll=0.4), 0)
        assert not ahead.touching.any()
        touch = grasped(world, side_start(roll=0.4), main_program())
        angles = np.arccos(np.einsum("ki,ki->k", ahead.normals, touch.normals))
        assert angles.max() < 0.35  # a finger swings round while it closes
    with opened(bullet_world(settings(sensing=Proximity(range=0.002)))) as world:
        blind = world.reset(side_start(roll=0.4), 0)
    assert np.linalg.norm(blind.normals - ahead.normals, axis=1).min() > 1e-3


def test_a_dent_tells_the_force() -> None:
    """The tips' stiffness is what the engine gives them."""
    assert Proximity().stiffness == STIFFNESS


def egg_tips(folder: Path, semi_axes: tuple[float, float, float]) -> Robot:
    """The Barrett hand with ellipsoids of these semi-axes [m] for fingertips."""
    mesh = SmoothEllipsoid(semi_axes).mesh(40)
    lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in mesh.vertices]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in mesh.faces]
    (folder / "egg.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    tree = ET.parse(HERE / ROBOT.hand.urdf)
    for link in tree.getroot().iter("link"):
        if link.get("name", "").startswith("tip-"):
            for geometry in link.iter("geometry"):
                geometry[:] = [ET.Element("mesh", filename="egg.obj")]
    tree.write(folder / "eggs.urdf")
    shape = EllipsoidTip(centre=(0.010, 0.0, 0.0), semi_axes=semi_axes)
    contacts = {
        name: Contact(link=known.link, cell=known.cell, ellipsoid=shape, finger=known.finger)
        for name, known in ROBOT.hand.contacts.items()
    }
    hand = ROBOT.hand.model_copy(update={"urdf": str(folder / "eggs.urdf"), "contacts": contacts})
    return Robot(hand=hand, mount=ROBOT.mount)


@pytest.mark.parametrize("name", PERFECT)
def test_ellipsoids_feel_where_they_touch(name: str, tmp_path: Path) -> None:
    robot = egg_tips(tmp_path, (0.0115, 0.010, 0.014))
    with opened(bullet_world(settings(robot=robot, sensing=PERFECT[name]))) as world:
        seen = rested(world, grasped(world, side_start(roll=0.3), main_program()))
        point, angle = errors(seen, world)
        assert point < 1e-3
        assert angle < 0.08  # the engine's ellipsoid has facets


def test_uneven_tips_weigh_nothing_at_rest(tmp_path: Path) -> None:
    """What a load cell feels is the contact alone, wherever the tip's own mass is."""
    with opened(bullet_world(settings(robot=with_uneven_tips(tmp_path)))) as world:
        seen = rested(world, grasped(world, side_start(roll=0.6), main_program()))
        np.testing.assert_allclose(seen.forces, world.truth().forces, atol=0.02)
        point, angle = errors(seen, world)
        assert point < 1e-3
        assert angle < 0.05


def without_cells(names: tuple[str, ...]) -> Robot:
    """The Barrett hand without these fingers' load cells."""
    contacts = {
        name: contact.model_copy(update={"cell": ""}) if name in names else contact
        for name, contact in ROBOT.hand.contacts.items()
    }
    return Robot(hand=ROBOT.hand.model_copy(update={"contacts": contacts}), mount=ROBOT.mount)


def complaints_about(robot: Robot, sensing: str) -> list[str]:
    """What is said of sensing with a robot."""
    reading = read_spec(MAIN.read_text("utf-8"), MAIN.name, (f"scene.sensing={sensing}",))
    complaints = Complaints(reading.document)
    check_sensing(reading.spec, reading.document, robot, complaints)
    return [f"{found.severity.value} {found.code}: {found.message}" for found in complaints.found]


def test_load_cells_that_a_hand_has_not_are_named() -> None:
    (said,) = complaints_about(without_cells(("finger-2",)), "load-cell")
    assert said.startswith("error not-sensed: ")
    assert said.endswith("finger-2 of the hand barrett has no load cell")
    (said,) = complaints_about(without_cells(("finger-1", "finger-3")), "load-cell")
    assert "finger-1 and finger-3 of the hand barrett have no load cell" in said
    assert complaints_about(without_cells(("finger-2",)), "skin") == []
    assert complaints_about(ROBOT, "load-cell") == []


@pytest.mark.parametrize("sensing", [Skin(), Proximity(), Exact()], ids=lambda sensing: type(sensing).__name__)
def test_hands_without_load_cells_feel_by_other_sensors(sensing: TactileSensor) -> None:
    robot = without_cells(("finger-1", "finger-2", "finger-3"))
    with opened(bullet_world(settings(robot=robot, sensing=sensing))) as world:
        grasped(world, side_start(), main_program())


def test_the_program_of_a_spec_senses_as_it_says() -> None:
    program = program_of(MAIN.read_text("utf-8"), MAIN.name, ("scene.sensing={skin: {pitch: 0.003}}",))
    with opened(bullet_world(settings(sensing=settings_of(program).sensing))) as world:
        seen = grasped(world, side_start(), program)
        seen = run_phase(world, program, 1, 20, seen)[-1]
        assert np.isfinite(seen.points).all()
