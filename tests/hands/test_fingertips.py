"""Declared fingertips: held against the geometry of the model, and what touches in the engine, whatever it has."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.compiler.program import program_of
from graspdsl.diagnostics import Diagnostic, Severity
from graspdsl.hands.description_files import DescriptionFileError
from graspdsl.hands.descriptions import HERE, Robot, mounts
from graspdsl.hands.fingertip_check import ALIKE
from graspdsl.hands.fingertips import reach
from graspdsl.hands.hand_files import FoundHand, hand_in
from graspdsl.places.files import SpecFolder
from graspdsl.trials.setup import trial_loop
from graspdsl.worlds.bullet.engine import pybullet
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.touch.compliance import LINEAR_FORCE, STIFFNESS

from .models import HAND, URDF, changed, write

BALL = '<collision><geometry><sphere radius="0.01"/></geometry></collision>'
LOOK = '<visual><geometry><sphere radius="0.011"/></geometry><material name="grey"/></visual>'
SPHERE = "sphere: {radius: 0.01}"
CAPSULE = "capsule: {radius: 0.01, length: 0.02, axis: [0, 1, 0]}"
ELLIPSOID = "ellipsoid: {centre: [0.002, 0, 0.001], semi_axes: [0.008, 0.011, 0.016], rpy: [0.3, -0.7, 1.1]}"
# The finger turns its tip towards x; the tip is fixed to it along z.
FRONT, BACK = '<origin xyz="0.008 0 0"/>', '<origin xyz="-0.008 0 0"/>'
BLOCK = '<geometry><box size="0.01 0.01 0.01"/></geometry>'
ENDS = "".join(
    f'<collision><origin xyz="0 {y} 0"/><geometry><sphere radius="0.01"/></geometry></collision>' for y in (0.01, -0.01)
)


def _geom(shape: str, origin: str = "") -> str:
    return f"<collision>{origin}<geometry>{shape}</geometry></collision>"


def _found(folder: Path, geometry: str, declared: str = SPHERE, looks: str = LOOK) -> FoundHand:
    urdf = changed(changed(URDF, (BALL, geometry)), (LOOK, looks))
    write(folder, urdf, changed(HAND, (SPHERE, declared)))
    return hand_in(SpecFolder(folder), "hand.yaml")


def _complaints(folder: Path, geometry: str, declared: str = SPHERE) -> tuple[Diagnostic, ...]:
    try:
        return _found(folder, geometry, declared).warnings
    except DescriptionFileError as error:
        return error.diagnostics


ALONG_Y = '<origin rpy="1.5707963267948966 0 0"/>'
AGREEING = {
    "the same sphere": (BALL, SPHERE),
    "a sphere of few digits": (_geom('<sphere radius="0.0100005"/>'), SPHERE),
    "the same capsule": (_geom('<capsule radius="0.01" length="0.02"/>', ALONG_Y), CAPSULE),
    "a capsule of three": (_geom('<cylinder radius="0.01" length="0.02"/>', ALONG_Y) + ENDS, CAPSULE),
    "a sphere and its back": (BALL + f"<collision>{BACK}{BLOCK}</collision>", SPHERE),
    "a sphere and what it is fixed by": (
        BALL + _geom('<box size="0.01 0.01 0.02"/>', '<origin xyz="0 0 -0.01"/>'),
        SPHERE,
    ),
    "nothing": ("", ELLIPSOID),
}


@pytest.mark.parametrize("name", AGREEING)
def test_a_fingertip_that_is_as_its_model_has_it_is_fine(name: str, tmp_path: Path) -> None:
    assert _complaints(tmp_path, *AGREEING[name]) == ()


DIFFERING = {
    "larger": (_geom('<sphere radius="0.02"/>'), SPHERE, "reaches 10 mm", "reaches 20 mm"),
    "a little larger": (_geom('<sphere radius="0.0103"/>'), SPHERE, "reaches 10 mm", "reaches 10.3 mm"),
    "smaller": (_geom('<sphere radius="0.004"/>'), SPHERE, "reaches 10 mm", "reaches 4 mm"),
    "elsewhere": (
        _geom('<sphere radius="0.01"/>', '<origin xyz="0.002 0 0"/>'),
        SPHERE,
        "reaches 10 mm",
        "reaches 12 mm",
    ),
    "a tube": (_geom('<cylinder radius="0.01" length="0.02"/>'), SPHERE, "reaches 10 mm", "reaches 14.1"),
    "a box": (_geom('<box size="0.02 0.02 0.02"/>'), SPHERE, "reaches 10 mm", "reaches 17.3"),
    "a front": (BALL + f"<collision>{FRONT}{BLOCK}</collision>", SPHERE, "reaches 10 mm", "reaches 14.8"),
    "a longer capsule": (
        _geom('<capsule radius="0.01" length="0.03"/>', ALONG_Y),
        CAPSULE,
        "reaches 20 mm",
        "reaches 25 mm",
    ),
}


@pytest.mark.parametrize("name", DIFFERING)
def test_a_fingertip_that_the_model_has_otherwise_is_one_error_with_both_numbers(name: str, tmp_path: Path) -> None:
    geometry, declared, *said = DIFFERING[name]
    (fault,) = _complaints(tmp_path, geometry, declared)
    assert (fault.code, fault.severity) == ("other-fingertip", Severity.ERROR)
    numbers = [float(re.findall(r"[\d.]+", words)[0]) for words in said]
    found = [float(number) for number in re.findall(r"reaches (-?[\d.]+) mm", fault.message)]
    assert found == pytest.approx(numbers, abs=0.15)
    assert fault.span is not None
    assert HAND.split("\n")[fault.span.line - 1][fault.span.column - 1 :].startswith(("sphere", "  "))


def test_the_hint_tells_the_sphere_of_the_model(tmp_path: Path) -> None:
    (fault,) = _complaints(tmp_path, _geom('<sphere radius="0.02"/>', '<origin xyz="0 0 0.003"/>'))
    assert fault.hint is not None
    assert "sphere: {centre: [0, 0, 0.003], radius: 0.02}" in fault.hint


@pytest.mark.parametrize(("facets", "fine"), [(32, True), (8, False)])
@pytest.mark.parametrize("name", ["ball.stl", "ball.obj"])
def test_a_mesh_stands_for_a_round_tip_up_to_its_facets(facets: int, fine: bool, name: str, tmp_path: Path) -> None:
    ball = trimesh.creation.uv_sphere(radius=10.0, count=[facets // 2, facets])
    ball.export(tmp_path / name)
    found = _complaints(tmp_path, _geom(f'<mesh filename="{name}" scale="0.001 0.001 0.001"/>'))
    assert [fault.code for fault in found] == ([] if fine else ["other-fingertip"])


def test_the_tolerance_is_what_a_fingertip_gives_way() -> None:
    assert pytest.approx(LINEAR_FORCE / STIFFNESS) == ALIKE


def test_a_fingertip_within_the_link_that_it_is_fixed_to_is_a_warning(tmp_path: Path) -> None:
    (warning,) = _complaints(tmp_path, "", "sphere: {centre: [0, 0, -0.02], radius: 0.004}")
    assert (warning.code, warning.severity) == ("hidden-fingertip", Severity.WARNING)
    assert "nowhere beyond finger" in warning.message


def test_fingertips_without_mass_are_one_warning(tmp_path: Path) -> None:
    write(tmp_path, changed(URDF, ('<mass value="0.01"/>', '<mass value="0"/>')))
    (warning,) = hand_in(SpecFolder(tmp_path), "hand.yaml").warnings
    assert (warning.code, warning.severity) == ("no-mass", Severity.WARNING)
    assert "no mass to the fingertips pad" in warning.message


def _far(engine: Any, client: int, hand: BulletHand, direction: Array) -> float:
    """How far [m] the first tip reaches along a direction (3,) in its frame, from a plate 0.05 m from its origin."""
    tip, (origin, rotation) = hand.tips[0], hand.tip_frames()[0]
    turned, _ = Rotation.align_vectors([rotation @ direction], [[0.0, 0.0, 1.0]])
    centre = (origin + rotation @ direction * 0.15).tolist()
    plate = engine.createCollisionShape(engine.GEOM_BOX, halfExtents=[0.1, 0.1, 0.1], physicsClientId=client)
    body = engine.createMultiBody(0.0, plate, -1, centre, turned.as_quat().tolist(), physicsClientId=client)
    points = engine.getClosestPoints(hand.body, body, 1.0, linkIndexA=tip.link, physicsClientId=client)
    engine.removeBody(body, client)
    return float(0.05 - min(point[8] for point in points))


BALL_OF_FACETS = _geom('<mesh filename="ball.stl"/>')


@pytest.mark.parametrize(
    ("geometry", "declared"), [("", SPHERE), ("", CAPSULE), ("", ELLIPSOID), (BALL_OF_FACETS, SPHERE)]
)
def test_the_declared_shape_is_what_touches_and_is_drawn(geometry: str, declared: str, tmp_path: Path) -> None:
    trimesh.creation.uv_sphere(radius=0.01, count=[16, 32]).export(tmp_path / "ball.stl")
    found = _found(tmp_path, geometry, declared, looks="")
    robot = Robot(hand=found.hand, mount=mounts()["gantry"])
    directions = np.random.default_rng(0).normal(size=(30, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    engine = pybullet()
    client = engine.connect(engine.DIRECT)
    try:
        hand = BulletHand(engine, client, robot, np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), 0.4)
        drawn = [shown[1] for shown in engine.getVisualShapeData(hand.body, physicsClientId=client)]
        assert hand.tips[0].link in drawn
        assert hand.tips[0].mass == pytest.approx(0.01)
        reached = [_far(engine, client, hand, direction) for direction in directions]
    finally:
        engine.disconnect(client)
    np.testing.assert_allclose(reached, reach(found.hand.contacts["pad"].shape, directions), atol=1e-4)


@pytest.mark.slow
def test_tip_frames_without_geometry_and_mass_grasp(tmp_path: Path) -> None:
    """As most public hands have them: the Barrett hand so converges where the one with geometry and mass does."""
    urdf = (HERE / "barrett.urdf").read_text("utf-8")
    (tmp_path / "barrett.urdf").write_text(
        re.sub(r'(<link name="tip-\d">).*?(</link>)', r"\1\2", urdf, flags=re.DOTALL)
    )
    (tmp_path / "hand.yaml").write_text((HERE / "barrett.yaml").read_text("utf-8"))
    spec = (HERE.parents[1] / "specs" / "towel_roll_two_contacts.yaml").read_text("utf-8")
    program = program_of(spec.replace("hand: barrett", "hand: hand.yaml"), "spec.yaml", folder=tmp_path)
    record = trial_loop(program).run(0, 2006).record
    assert record.outcome == "converged", record.detail
