"""Controllers for a loop of one's own: what they are called with, what they give back, and what they refuse."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from compiler.observations import observation

import graspdsl as g
from graspdsl.compiler.program import program_of_expression
from graspdsl.hands import descriptions
from graspdsl.hands.descriptions import joint_limits
from graspdsl.hands.fingertip_motion import FingertipMotion

GRASP = "π_s|Γ Γ (π_gx|Γ Γ)"
HANDS = ["barrett", "trio", "points"]


@pytest.fixture(scope="module")
def controller() -> g.Controller:
    """The chapter's grasp controller on the Barrett hand."""
    return g.compile(GRASP, hand="barrett")


def test_a_tick_is_that_of_the_pipeline_that_runs(controller: g.Controller) -> None:
    [[pipeline]] = program_of_expression(GRASP).pipelines()
    for seed in range(3):
        tick, expected = controller(observation(seed)), pipeline.evaluate(observation(seed))
        np.testing.assert_array_equal(tick.command.displacement, expected.command.displacement)
        np.testing.assert_array_equal(tick.force_residual, expected.force_residual)
        assert (tick.ranks, tick.force_error) == (expected.ranks, expected.force_error)
        assert tick.disturbances == expected.disturbances


def test_it_says_what_it_is_of(controller: g.Controller) -> None:
    assert controller.contacts == ("finger-1", "finger-2", "finger-3")
    assert len(controller.joints) == 10
    assert (controller.space, g.compile("π_gx|Γ Γ").space) == ("q", "x")
    assert controller.units["command"].startswith("rad")
    assert g.compile("π_gx|Γ Γ").units["command"] == "m"
    assert controller.units.keys() == {
        *(field.name for field in fields(g.Observation)),
        *(field.name for field in fields(controller(controller.example()))),
    }
    assert repr(controller) == f"<Controller {GRASP}: barrett on gantry, 3 contacts, commands in q>"


def test_a_formula_is_as_good_as_its_text(controller: g.Controller) -> None:
    composed = g.parse("φ_mr|τ_mrx(Γ) σ_mr(Γ)").subject_to("φ_fr|τ_frx(Γ) σ_fr(Γ)")
    seen = controller.example()
    one, other = g.compile(composed)(seen), g.compile(str(composed))(seen)
    np.testing.assert_array_equal(one.command.displacement, other.command.displacement)


# What it is compiled for


def test_resources_and_parameters_are_the_users(controller: g.Controller) -> None:
    """The same under other names."""
    named = {"γ_a": "finger-3", "γ_b": "finger-1", "γ_c": "finger-2", "Γ_m": "{γ_a, <γ_b, γ_c>}"}
    other = g.compile("π_s|Γ_m Γ_m (π_gx|Γ_m Γ_m)", resources=named, parameters={"κ_f": 0.5})
    seen = observation(2)
    np.testing.assert_array_equal(other(seen).command.displacement, controller(seen).command.displacement)
    stronger = g.compile(GRASP, parameters={"κ_f": 2.0})
    assert stronger(controller.example()).force_error == pytest.approx(2.0 - 1.0)
    assert controller(controller.example()).force_error == pytest.approx(1.0 - 0.5)


def test_a_vector_may_be_an_array() -> None:
    place = np.array([0.1, 0.2, 0.3])
    by_name = g.compile("φ_p|τ_p(γ1) σ_p(γ1) (x_ref)", parameters={"x_ref": place})
    written = g.compile("φ_p|τ_p(γ1) σ_p(γ1) (0.1, 0.2, 0.3)")
    seen = observation(4)
    np.testing.assert_array_equal(by_name(seen).command.displacement, written(seen).command.displacement)


def test_control_is_that_of_a_spec() -> None:
    seen = observation(5)
    usual, halved = (g.compile("π_gx|Γ Γ", control=control)(seen) for control in ({"cap": 0.01}, {"cap": 0.005}))
    longest = [np.linalg.norm(tick.command.displacement, axis=1).max() for tick in (usual, halved)]
    np.testing.assert_allclose(longest, [0.01, 0.005])


def test_a_surface_that_is_not_known_is_a_sphere_wherever_it_lies() -> None:
    """Moved as a whole, a grasp slides as before; S is (I − n nᵀ) / r of the ball that the example holds."""
    controller = g.compile("φ_w|τ_wsx(Γ) σ_w(Γ)")
    here = controller.example()
    there = replace(here, points=here.points + np.array([1.0, -2.0, 0.5]))
    assert np.allclose(controller(here).command.displacement, controller(there).command.displacement, atol=1e-12)
    [step] = [number for number, step in enumerate(controller.pipeline.steps) if step.label == "S"]
    normal, turns = here.normals[0], controller.pipeline.values(there)[step][0]
    tangent = np.cross(normal, [0.0, 0.0, 1.0])
    assert np.allclose(turns @ normal, 0.0)
    assert np.allclose(turns @ tangent, tangent / 0.05)


def test_all_contacts_of_another_hand_have_names() -> None:
    trio = g.compile("π_gx|Γ Γ", hand="trio", mount="wam")
    assert trio.program.spec.resources == {"γ1": "digit-1", "γ2": "digit-2", "γ3": "digit-3", "Γ": "{γ1, γ2, γ3}"}
    assert len(trio.joints) == 7 + 6


def test_a_hand_file_is_as_good_as_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    hands = Path(descriptions.__file__).parent
    for suffix in ("yaml", "urdf"):
        text = (hands / f"trio.{suffix}").read_text("utf-8").replace("hand: trio", "hand: mine")
        Path(f"mine.{suffix}").write_text(text.replace("trio.urdf", "mine.urdf"), "utf-8")
    seen = g.compile("π_gx|Γ Γ", hand="trio").example()
    expected = g.compile("π_gx|Γ Γ", hand="trio")(seen).command.displacement
    for name in ("mine.yaml", Path("mine.yaml")):
        found = g.compile("π_gx|Γ Γ", hand=name)
        np.testing.assert_array_equal(found(seen).command.displacement, expected)


def test_an_object_is_held_where_the_formula_turns_it() -> None:
    turning = "π_rgθ|Γ {γ1, γ_g}"
    seen = g.compile(turning).example()
    assert np.linalg.norm(seen.weight) == pytest.approx(0.5 * 9.81)
    np.testing.assert_allclose(np.linalg.norm(seen.points - seen.centre_of_mass, axis=1).std(), 0.0, atol=1e-9)
    assert np.isnan(g.compile(GRASP).example().weight).all()
    assert np.isfinite(g.compile(GRASP, held=True).example().weight).all()


# The example


@pytest.mark.parametrize("mount", ["gantry", "wam"])
@pytest.mark.parametrize("hand", HANDS)
def test_the_example_is_a_grasp_of_a_ball(hand: str, mount: str) -> None:
    controller = g.compile("π_gx|Γ Γ", hand=hand, mount=mount)
    seen = controller.example()
    assert {name: np.shape(getattr(seen, name)) for name in controller.shapes} == controller.shapes
    # All normals meet in one point, as far from each contact as from every other.
    normals = seen.normals
    toward = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    centre = np.linalg.solve(toward.sum(axis=0), np.einsum("kij,kj->i", toward, seen.points))
    away = centre - seen.points
    np.testing.assert_allclose(np.linalg.norm(np.cross(away, normals), axis=1), 0.0, atol=1e-8)
    radii = np.einsum("ki,ki->k", away, normals)
    np.testing.assert_allclose(radii, radii[0], atol=1e-8)
    assert radii[0] == pytest.approx(controller.program.spec.control.curvature_radius, rel=0.1)
    assert seen.touching.all()
    np.testing.assert_allclose(seen.forces, normals)
    tick = controller(seen)
    assert np.isfinite(tick.command.displacement).all()
    for field in fields(seen):
        np.testing.assert_array_equal(getattr(controller.example(), field.name), getattr(seen, field.name))


@pytest.mark.parametrize("hand", ["barrett", "trio"])
def test_the_jacobians_of_the_example_are_those_of_its_contact_points(hand: str) -> None:
    """Against central differences of points that are fixed in the fingertips' links."""
    controller = g.compile("π_gx|Γ Γ", hand=hand)
    seen, motion = controller.example(), FingertipMotion(controller.program.robot)
    lower, upper = joint_limits(controller.program.robot)
    assert ((np.array(lower) <= seen.joints) & (seen.joints <= np.array(upper))).all()
    links = motion.links(seen.joints)
    fixed = [link.rotation.T @ (point - link.origin) for link, point in zip(links, seen.points, strict=True)]

    def places(joints: Any) -> Any:
        return np.array([link.point(place) for link, place in zip(motion.links(joints), fixed, strict=True)])

    step = 1e-6
    for joint in range(len(seen.joints)):
        moved = np.zeros(len(seen.joints))
        moved[joint] = step
        difference = (places(seen.joints + moved) - places(seen.joints - moved)) / (2.0 * step)
        np.testing.assert_allclose(seen.jacobian[:, :, joint], difference, atol=1e-9)


# What is refused


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"points": np.zeros((2, 3))}, r"points: expected the shape \(3, 3\), found \(2, 3\)"),
        ({"jacobian": np.zeros((3, 3, 9))}, r"jacobian: expected the shape \(3, 3, 10\), found \(3, 3, 9\)"),
        ({"touching": [True]}, r"touching: expected the shape \(3,\), found \(1,\)"),
        ({"joints": [math.nan] * 10}, "joints: expected finite numbers, found nan"),
        ({"normals": 2.0 * np.eye(3)}, "normals: expected unit vectors into the object, found one of length 2"),
        ({"normals": [[0, 0, math.nan]] * 3}, "normals: expected finite numbers, found nan"),
        ({"points": [["a"] * 3] * 3}, "points: expected numbers"),
        ({"points": [[1.0], [2.0, 3.0]]}, "points: expected numbers"),
        ({"points": 1j * np.ones((3, 3))}, "points: expected numbers"),
        ({"forces": np.ma.masked_less(np.zeros((3, 3)), 1.0)}, "forces: expected numbers"),
        ({"jacobian": np.full((3, 3, 10), 1e300)}, "the command is no finite number"),
    ],
)
def test_an_observation_of_something_else_is_refused(
    controller: g.Controller, given: dict[str, Any], said: str
) -> None:
    with np.errstate(all="ignore"), pytest.raises(ValueError, match=said):
        controller(replace(controller.example(), **given))


def test_lists_are_as_good_as_arrays(controller: g.Controller) -> None:
    seen = controller.example()
    lists = replace(seen, **{field.name: np.asarray(getattr(seen, field.name)).tolist() for field in fields(seen)})
    np.testing.assert_array_equal(controller(lists).command.displacement, controller(seen).command.displacement)


def test_what_is_not_read_may_be_unknown(controller: g.Controller) -> None:
    """Where an object is that nobody holds."""
    assert np.isnan(controller.example().centre_of_mass).all()
    held = g.compile("π_rgθ|Γ {γ1, γ_g}")
    with pytest.raises(ValueError, match="centre_of_mass: expected finite numbers"):
        held(replace(held.example(), centre_of_mass=np.full(3, math.nan)))


@pytest.mark.parametrize(
    ("formula", "given", "said"),
    [
        ("π_s|Γ Γ (π_g|Γ Γ)", {}, r"^formula:1:10: error\[wrong-reference\]"),
        ("π_s|Γ", {}, r"^formula:1:6: error"),
        ("π_close|Γ Γ then π_gx|Γ Γ", {}, r"^formula: error\[several-controllers\]: 'then' makes 2 controllers"),
        (GRASP, {"hand": "baret"}, r"error\[unknown-hand\](.|\n)*\| +\^+\n  hint: did you mean barrett\?$"),
        (GRASP, {"mount": "crane"}, r"error\[unknown-mount\]: there is no mount 'crane'"),
        (GRASP, {"hand": "nowhere.yaml"}, r"there is no file nowhere\.yaml"),
        (GRASP, {"resources": {"γ1": "finger-9"}}, r"error\[unknown-contact\](.|\n)*γ1: finger-9"),
        (GRASP, {"parameters": {"κ_f": "much"}}, r"error\[wrong-form\]: expected a number or a list of numbers"),
        (GRASP, {"parameters": {}}, r"error\[missing-parameter\]"),
        (GRASP, {"control": {"stride": 1}}, r"error\[unknown-key\]: 'control' has no key 'stride'"),
        (GRASP, {"control": {"step": 5}}, r"error\[out-of-range\]"),
    ],
)
def test_mistakes_are_told_with_their_places(formula: str, given: dict[str, Any], said: str) -> None:
    with pytest.raises(g.DiagnosticError, match=said):
        g.compile(formula, **given)
