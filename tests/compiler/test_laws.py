"""From gradients to commands: gains, units, gravity, posture, and what a held object changes."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.compiler.lowering import compile_controller
from graspdsl.compiler.program import examine_expression
from graspdsl.compiler.settings import Target
from graspdsl.hands.descriptions import joint_limits
from graspdsl.spec.program import Control
from graspdsl.worlds.protocol import Observation

from .observations import CONTACTS, FIRST, JOINTS, ROBOT, SECOND, TARGET, THUMB, WEIGHTS, command, compiled, observation

NAMES = list(ROBOT.joints)
RADIUS = 0.05
STEP = 0.01 * RADIUS
FREE = {"cap": 0.1}
DOWN = np.array([0.0, 0.0, -1.0])


def picked(*names: str) -> Array:
    """Which joints these are, or those of a joint set."""
    joints = [joint for name in names for joint in ROBOT.joint_sets[name]]
    return np.isin(np.arange(JOINTS), [NAMES.index(joint) for joint in joints])


def made_for(target: Target, formula: str, seen: Observation) -> Array:
    """The command for a target other than the default one."""
    phase, _ = examine_expression(formula)
    (stage,) = phase.stages
    return compile_controller(stage, phase.grasp, target).evaluate(seen).command.displacement


# --- gains ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [0.05, 0.2])
@pytest.mark.parametrize(
    ("probing", "settings", "step", "cap"),
    [
        (False, {}, 0.01, 0.015),
        (True, {}, 0.5 / 4, 0.15),
        (False, {"step": 3e-4, "cap": 7e-4}, None, None),
        (True, {"step": 3e-4, "cap": 7e-4}, None, None),
    ],
)
def test_default_step_and_cap_are_shares_of_the_curvature_radius(
    radius: float, probing: bool, settings: dict[str, float], step: float | None, cap: float | None
) -> None:
    """Small and for all alike when sliding; large, the step shared by the resources, for probes and floats."""
    way = "probing" if probing else "sliding"
    control = Control.model_validate({"curvature_radius": radius, "displacement": way, **settings})
    target = Target(ROBOT, TARGET.world, control)
    assert target.step(4) == pytest.approx(3e-4 if step is None else step * radius)
    assert target.cap == pytest.approx(7e-4 if cap is None else cap * radius)


@pytest.mark.parametrize("probing", [False, True])
def test_unit_net_force_moves_a_contact_by_a_step_in_each_space(probing: bool) -> None:
    """In metres; over the surface and in rotation by that over the curvature radius."""
    way = "probing" if probing else "sliding"
    seen, target = observation(), replace(TARGET, control=Control.model_validate({"displacement": way, **FREE}))
    step = target.step(1)
    across = seen.normals[FIRST] - seen.normals[FIRST] @ seen.normals[THUMB] * seen.normals[THUMB]
    for formula in ("φ_fr|τ_frx(γ1) σ_fr(γ2)", "φ_fr|τ_fr(γ1) σ_fr(γ2)"):
        moved = made_for(target, formula, seen)
        np.testing.assert_allclose(moved[THUMB], step * across, atol=1e-15)
        np.testing.assert_array_equal(moved[[FIRST, SECOND]], 0.0)
    turned = made_for(target, "φ_fr|τ_frr(γ1) σ_fr({γ2, γ_g})", seen)
    np.testing.assert_allclose(turned, target.step(2) / RADIUS * np.cross(DOWN, seen.normals[FIRST]), atol=1e-15)


def test_a_moment_weighs_as_a_force_at_the_curvature_radius() -> None:
    seen = observation()
    seen.points[FIRST] = [0.01, 0.02, -0.03]
    moment = np.cross(seen.points[FIRST], seen.normals[FIRST])
    across = np.cross(moment, seen.normals[THUMB])
    settings = {"origin": "world", "moment_gain": 3.0, **FREE}
    for formula in ("φ_mr|τ_mrx(γ1) σ_mr(γ2)", "φ_mr|τ_mr(γ1) σ_mr(γ2)"):
        moved = command(formula, seen, **settings)
        np.testing.assert_allclose(moved[THUMB], 3.0 * STEP / RADIUS * across, atol=1e-15)
    turned = command("φ_mr|τ_mrr(γ1) σ_mr({γ2, γ_g})", seen, **settings)
    weight = np.cross(seen.centre_of_mass, DOWN)
    about = np.cross(weight, moment) - np.cross(seen.centre_of_mass, np.cross(DOWN, moment + weight))
    np.testing.assert_allclose(turned, 3.0 * STEP / RADIUS**3 * about, atol=1e-14)


@pytest.mark.parametrize(
    ("formula", "virtual"),
    [("φ_w|τ_wx(Γ) σ_w(Γ)", "members"), ("φ_w|τ_wx(Γ) σ_w(Γ)", "common"), ("φ_w|τ_w(Γ) σ_w(Γ)", "members")],
)
def test_wrench_residual_is_the_plain_sum_of_force_and_moment(formula: str, virtual: str) -> None:
    """It has one gradient, and so nothing that would be subject to anything."""
    for seed in range(5):
        seen = observation(seed)
        wrench, force, moment = (
            command(f, seen, virtual=virtual, **FREE)
            for f in (formula, "φ_fr|τ_frx(Γ) σ_fr(Γ)", "φ_mr|τ_mrx(Γ) σ_mr(Γ)")
        )
        np.testing.assert_allclose(wrench, force + moment, atol=1e-14)


@pytest.mark.parametrize("potential", ["fr", "mr", "w"])
def test_members_that_move_as_one_do_so_in_space(potential: str) -> None:
    """Over the surface each takes the part of their common displacement along its own tangent plane (Eq. 4.34)."""
    for seed in range(5):
        seen = observation(seed)
        by_surface, by_x = (
            command(f"φ_{potential}|τ_{potential}{ending}(Γ) σ_{potential}(Γ)", seen, virtual="common", **FREE)
            for ending in ("", "x")
        )
        np.testing.assert_allclose(by_x[FIRST], by_x[SECOND], atol=1e-15)
        depth = np.sum(by_x * seen.normals, axis=-1, keepdims=True)
        np.testing.assert_allclose(by_surface, by_x - depth * seen.normals, atol=1e-14)


def test_spherical_coordinates_shorten_what_lies_along_their_circles_of_latitude() -> None:
    """The chapter's 4.4 through 4.27, worked out from the angles of each contact; the moment has no such factor."""
    for seed in range(5):
        seen = observation(seed)
        inward = seen.normals[THUMB]
        east = np.cross([0.0, 0.0, 1.0], -inward)
        latitude = np.linalg.norm(east)
        east = east / latitude
        settings = {"surface": "spherical", **FREE}
        plain, literal = (command("φ_fr|τ_frx(γ1) σ_fr(γ2)", seen, **more)[THUMB] for more in (FREE, settings))
        np.testing.assert_allclose(literal, plain + (latitude - 1) * (plain @ east) * east, atol=1e-14)
        np.testing.assert_allclose(command("φ_fr|τ_fr(γ1) σ_fr(γ2)", seen, **settings)[THUMB], literal, atol=1e-14)
        for formula in ("φ_mr|τ_mrx(γ1) σ_mr(γ2)", "φ_mr|τ_mr(γ1) σ_mr(γ2)"):
            plain, literal = (command(formula, seen, **more)[THUMB] for more in (FREE, settings))
            np.testing.assert_allclose(literal, plain, atol=1e-14)


# --- gravity ----------------------------------------------------------------------------------------------------


def test_gravity_pulls_at_the_residuals() -> None:
    """Eq. 4.35 to 4.37: one more contact, at the centre of mass, that presses down."""
    for seed in range(5):
        seen = observation(seed)
        tick = compiled("π_gx|γ1 {γ1, <γ2, γ_g>}").evaluate(seen)
        shares, normals = np.array([1.0, 0.5, 0.5]), np.vstack([seen.normals[[THUMB, FIRST]], DOWN])
        points = np.vstack([seen.points[[THUMB, FIRST]], seen.centre_of_mass])
        centre = shares @ points / 2.0
        np.testing.assert_allclose(tick.force_residual, shares @ normals, atol=1e-14)
        np.testing.assert_allclose(tick.moment_residual, shares @ np.cross(points - centre, normals), atol=1e-14)


def test_moments_may_be_about_the_object() -> None:
    for formula in ("π_gx|Γ Γ", "π_gx|γ1 {γ1, γ_g}"):
        seen = observation()
        tick = compiled(formula, origin="object").evaluate(seen)
        used = {THUMB: 1.0, FIRST: 0.5, SECOND: 0.5} if "γ_g" not in formula else {THUMB: 1.0}
        levers = [share * np.cross(seen.points[i] - seen.centre_of_mass, seen.normals[i]) for i, share in used.items()]
        np.testing.assert_allclose(tick.moment_residual, np.sum(levers, axis=0), atol=1e-14)


def object_turned(seen: Observation, turn: Rotation, about: Array) -> Observation:
    """What is sensed when the object turns about a point, with all contacts that are fixed to it."""
    return replace(
        seen,
        points=about + turn.apply(seen.points - about),
        normals=turn.apply(seen.normals),
        centre_of_mass=about + turn.apply(seen.centre_of_mass - about),
        orientations=(turn * Rotation.from_rotvec(seen.orientations)).as_rotvec(),
    )


SENSED = ["γ1", "{γ1, γ2, γ3}", "Γ", "{γ2, γ3}", "<γ2, γ3>"]
WEIGHED = ["{γ1, γ_g}", "{γ2, γ3, γ_g}", "{γ1, γ2, γ3, γ_g}", "{γ1, <γ2, γ3>, γ_g}", "{γ3, <γ1, γ_g>}"]
EACH_ORIGIN = pytest.mark.parametrize("origin", ["centroid", "object", "world"])
FORMS = [
    {"surface": surface, "virtual": virtual}
    for surface, virtual in product(("tangent", "spherical"), ("members", "common"))
]


@EACH_ORIGIN
@pytest.mark.parametrize("sensed", WEIGHED)
def test_an_object_turns_down_the_gradient_of_its_own_residuals(sensed: str, origin: str) -> None:
    """Eq. 4.38, 4.39 against differences of ε_fr and ε_mr as the object turns with all contacts of Γσ, whichever of
    them Γτ names. Moments about its own points do not mind about which point it turns."""
    for seed, (moved, form) in enumerate(product(SENSED, FORMS)):
        seen, settings = observation(seed), {**form, "origin": origin}
        about = np.zeros(3) if origin == "world" else np.random.default_rng(seed).normal(size=3)
        for kind, gain in (("force", 0.5 * STEP / RADIUS), ("moment", 0.5 * STEP / RADIUS**3)):
            potential = "fr" if kind == "force" else "mr"
            pipeline = compiled(f"φ_{potential}|τ_{potential}r({moved}) σ_{potential}({sensed})", **settings, **FREE)

            turns = [(axis, sign) for axis in np.eye(3) for sign in (1.0, -1.0)]
            after = [object_turned(seen, Rotation.from_rotvec(1e-5 * sign * axis), about) for axis, sign in turns]
            squared = [np.sum(getattr(pipeline.evaluate(one), f"{kind}_residual") ** 2) for one in after]
            slope = -np.diff(squared)[::2] / 2e-5
            turned = pipeline.evaluate(seen).command.displacement
            np.testing.assert_allclose(turned, -gain * slope, atol=1e-9)
            # about its own centre of mass an object's weight has no moment
            assert (np.linalg.norm(turned) > 1e-6) != (kind == "moment" and origin == "object")


@EACH_ORIGIN
@pytest.mark.parametrize("sensed", SENSED)
def test_without_gravity_nothing_turns(sensed: str, origin: str) -> None:
    """The gradient of Eq. 4.41 is always zero (end of Sec. 4.4.2), whichever contacts Γτ and Γσ name."""
    for seed, (moved, form) in enumerate(product(SENSED, FORMS)):
        for formula in (f"π_gθ|{moved} {sensed}", f"π_rgθ|{moved} {sensed}"):
            assert np.abs(command(formula, observation(seed), **form, origin=origin)).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("sensed", WEIGHED)
def test_a_held_object_turns_until_its_contacts_oppose_gravity(sensed: str) -> None:
    """The force residual falls all the way until their net presses straight up, whichever way it starts."""
    pipeline = compiled(f"φ_fr|τ_frr(γ1) σ_fr({sensed})", step=0.01, cap=0.1)
    for seed in range(5):
        seen, residuals = observation(seed), []
        for _ in range(600):
            tick = pipeline.evaluate(seen)
            residuals.append(np.linalg.norm(tick.force_residual))
            seen = object_turned(seen, Rotation.from_rotvec(tick.command.displacement), np.zeros(3))
        assert np.all(np.diff(residuals) < 1e-12)
        share = 0.5 if "<γ1, γ_g>" in sensed else 1.0
        pressing = tick.force_residual - share * DOWN
        np.testing.assert_allclose(pressing, -DOWN * np.linalg.norm(pressing), atol=1e-3)


def test_the_fingers_that_hold_an_object_keep_still() -> None:
    """The mount turns all; nothing waits for contacts."""
    held, seen = replace(TARGET, held=True), observation()
    formula = "π_rgθ|γ1 {γ1, γ_g}"
    free, fixed = (made_for(target, formula, seen) for target in (TARGET, held))
    fingers = picked("fingers")
    assert np.all(np.abs(free[fingers]) > 0.0)
    np.testing.assert_array_equal(fixed[fingers], 0.0)
    assert np.all(np.abs(fixed[~fingers]) > 0.0)
    seen.touching[:] = False
    np.testing.assert_array_equal(made_for(held, formula, seen), fixed)
    np.testing.assert_array_equal(made_for(TARGET, formula, seen), 0.0)


# --- orientation ------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_orientation_servo_reaches_its_reference_the_short_way_round() -> None:
    """On a wrist that turns a contact about fixed axes, from any orientation to any other."""
    rolls = picked("wrist-roll-x", "wrist-roll-y", "wrist-roll-z")
    ends = Rotation.random(5, random_state=2)
    for seed, end in enumerate(ends):
        seen = observation(seed)
        seen.angular_jacobian[:] = 0.0
        seen.angular_jacobian[:, :, rolls] = np.eye(3)
        reference = ", ".join(map(repr, end.as_rotvec().tolist()))
        pipeline = compiled(f"φ_r|τ_r(γ1) σ_r(γ1) ({reference})", damping=1e-6)
        angles = []
        for _ in range(400):
            now = Rotation.from_rotvec(seen.orientations[THUMB])
            angles.append((end * now.inv()).magnitude())
            turn = pipeline.evaluate(seen).command.displacement[rolls]
            seen.orientations[THUMB] = (Rotation.from_rotvec(turn) * now).as_rotvec()
        assert np.all(np.diff(angles) < 1e-9)
        assert angles[0] > 0.5
        assert angles[-1] < 1e-6


def test_orientation_reference_of_a_controller_is_one_step_of_it() -> None:
    seen = observation()
    by_controller = command("φ_r|τ_r(γ1) σ_r({γ1, γ_g}) (π_gθ|γ1 {γ1, γ_g})", seen, damping=1e-6, cap=0.1)
    turn = command("π_gθ|γ1 {γ1, γ_g}", seen, cap=0.1)
    np.testing.assert_allclose(seen.angular_jacobian[THUMB] @ by_controller, turn, rtol=1e-6, atol=1e-9)
    angle = np.linalg.norm(turn)
    capped = command("π_rgθ|γ1 {γ1, γ_g}", seen, damping=1e-6, cap=RADIUS * angle / 4)
    np.testing.assert_allclose(seen.angular_jacobian[THUMB] @ capped, turn / 4, rtol=1e-6, atol=1e-9)


# --- moments ----------------------------------------------------------------------------------------------------


def test_moment_servo_presses_as_the_force_servo_at_its_lever() -> None:
    """Admittance over r² times τ_mᵀ of the error; nothing for a contact that does not touch."""
    seen = observation()
    settings = {"origin": "world", "admittance": 1e-6}
    found = command("φ_m|τ_m(γ1) σ_m(γ1) (0, 0, 0.001)", seen, **settings)
    normal, lever = seen.normals[THUMB], seen.points[THUMB]
    error = np.array([0.0, 0.0, 0.001]) - np.cross(lever, (seen.forces[THUMB] @ normal) * normal)
    scaled = seen.jacobian[THUMB] * WEIGHTS
    task = np.cross(lever, normal)[:, None] * (normal @ scaled)
    np.testing.assert_allclose(found, WEIGHTS * (task.T @ error) * 1e-6 / RADIUS**2, rtol=1e-9)


def test_moment_servo_closes_fingers_as_fast_as_the_force_servo() -> None:
    """However an error is measured, a contact that does not touch comes nearer by so many metres a second."""
    seen = observation()
    seen.touching[:] = False
    by_force, by_moment = (command(f"φ_{a}|τ_{a}(γ1) σ_{a}(γ1) (0, 0, 0.001)", seen) for a in "fm")
    assert np.linalg.norm(by_force) > 1e-4
    np.testing.assert_array_equal(by_moment, by_force)


# --- posture ----------------------------------------------------------------------------------------------------


def _posture(formula: str, joints: Array, **settings: float) -> Array:
    seen = observation()
    seen.joints[:] = joints
    return command(formula, seen, **settings)


MIDDLE = np.mean(joint_limits(ROBOT), axis=0)
NEAR = MIDDLE + 1e-3 * np.linspace(-1.0, 1.5, JOINTS) * WEIGHTS / WEIGHTS.max()


@pytest.mark.parametrize(
    ("moved", "sensed"),
    [("all", "all"), ("all", "flexion"), ("fingers", "flexion"), ("flexion", "fingers"), ("wrist", "flexion")],
)
def test_posture_takes_back_a_share_of_the_error_of_joints_that_it_senses_and_moves(moved: str, sensed: str) -> None:
    found = _posture(f"φ_k|τ_k({moved}) σ_k({sensed})", NEAR, posture_gain=0.1)
    both = picked(moved) & picked(sensed)
    np.testing.assert_allclose(found, np.where(both, 0.1 * (MIDDLE - NEAR), 0.0), atol=1e-15)


def test_posture_reference_stands_in_the_order_of_its_set() -> None:
    wanted = MIDDLE + 1e-3
    reference = ", ".join(repr(float(wanted[NAMES.index(joint)])) for joint in ROBOT.joint_sets["fingers"])
    found = _posture(f"φ_k|τ_k(all) σ_k(fingers) ({reference})", MIDDLE, posture_gain=0.01)
    np.testing.assert_allclose(found, np.where(picked("fingers"), 1e-5, 0.0), atol=1e-12)


def test_posture_goes_slowly_however_far_it_is() -> None:
    """All joints are shortened alike."""
    near, far = (_posture("φ_k|τ_k(all) σ_k(all)", MIDDLE + scale * (NEAR - MIDDLE)) for scale in (1.0, 1e4))
    np.testing.assert_allclose(far / np.linalg.norm(far), near / np.linalg.norm(near), atol=1e-12)
    further = _posture("φ_k|τ_k(all) σ_k(all)", MIDDLE + 1e5 * (NEAR - MIDDLE))
    np.testing.assert_allclose(further, far, rtol=1e-9)


def test_posture_does_not_press() -> None:
    """Beneath the force objective, what is left of the posture's motion keeps the contacts' depth (Eq. 4.25)."""
    for seed in range(5):
        seen = observation(seed)
        press, both = (
            command(f, seen, nullspace="task") for f in ("π_close|Γ Γ", "φ_k|τ_k(all) σ_k(flexion) ◁ π_close|Γ Γ")
        )
        depth = np.einsum("ki,kin,n->k", seen.normals, seen.jacobian, both - press)
        assert np.linalg.norm(both - press) > 1e-6
        assert np.abs(depth).max() < 1e-9 * np.linalg.norm(both - press)


def test_posture_alone_is_monitored_over_all_contacts() -> None:
    phase, _ = examine_expression("φ_k|τ_k(all) σ_k(flexion)")
    assert phase.grasp.contacts == tuple(range(CONTACTS))
    seen = observation()
    tick = compiled("φ_k|τ_k(all) σ_k(flexion)").evaluate(seen)
    np.testing.assert_allclose(tick.force_residual, seen.normals.sum(axis=0), atol=1e-14)
