"""One tick of π_sgx on the Barrett hand, three contacts and ten joints, against what others take for the like of it:
mink and Pink, each a quadratic program with a frame task a fingertip and a posture task, and numpy by hand.
"""

from __future__ import annotations

import importlib
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from hand_written import SlideToGrasp
from measuring import Row, in_turn, medians, ratio_of

from graspdsl.api.examples import example_of
from graspdsl.arrays import Array
from graspdsl.backends import BACKENDS
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.program import Program, program_of
from graspdsl.worlds.mujoco.meshes import spec_of
from graspdsl.worlds.protocol import Observation
from graspdsl.worlds.rigid.assembly import joined

SPEC = Path(__file__).resolve().parents[1] / "specs" / "chapter" / "4_31_slide_to_grasp.yaml"
ROUNDS, EACH = 150, 10
SOLVER, POSTURE = "daqp", 1e-2  # the cost of the posture, where a fingertip's place costs one
FORWARD = np.array([0.0, 0.0, 5e-4])  # m, to where a fingertip shall go
BOUNDS = ("≤ 1.3", "≤ 0.8", "≤ 0.7")
ON = ("numpy", "casadi")

Tick = Callable[[], object]


def rows() -> Iterator[Row]:
    """The tick, on each backend, against each of them."""
    program = program_of(SPEC.read_text("utf-8"), SPEC.name)
    *_, (pipeline,) = program.pipelines()
    by_hand, seen = SlideToGrasp(program), example_of(program)
    tree, model = tree_of(program), model_of(program)
    moved = kinematics(program, model, seen.joints)
    pipelines = {name: replace(pipeline, backend=BACKENDS[name]) for name in ON}
    missing = {name: f"not installed: {name}" for name in ON if BACKENDS[name].missing}
    actions: dict[str, Tick] = {}
    for name in ON:
        if name not in missing:
            for other in observations(seen):
                given = pipelines[name].ticks(other, certified=False).displacement
                np.testing.assert_allclose(by_hand.command(other), given, rtol=0.0, atol=1e-12)
            actions |= ticks_on(name, pipelines[name], seen, moved)
    makers: dict[str, Callable[[], Tick]] = {
        "numpy by hand": lambda: lambda: by_hand.command(seen),
        f"mink with {SOLVER}": lambda: mink_tick(program, model, seen.joints),
        f"pink with {SOLVER}": lambda: pink_tick(program, tree, seen.joints),
    }
    for name, made in makers.items():
        try:
            actions[name] = made()
        except ModuleNotFoundError as error:
            missing[name] = f"not installed: {error.name}"
    times = in_turn(actions, ROUNDS, EACH)
    said = medians(times)
    for name, (peer, bound) in product(ON, zip(makers, BOUNDS, strict=True)):
        what = f"tick of π_sgx on {name}"
        if reason := missing.get(name) or missing.get(peer):
            yield Row(f"{what} / {peer}", note=reason)
            continue
        yield ratio_of(f"{what}, command alone / {peer}", times[f"command on {name}"], times[peer], bound, said)
        yield ratio_of(f"{what}, certified / {peer}", times[f"certified on {name}"], times[peer], "")
        if SOLVER in peer:
            kinematic = times[f"with kinematics on {name}"]
            yield ratio_of(f"{what}, with the kinematics that a peer does / {peer}", kinematic, times[peer], "")


def ticks_on(name: str, pipeline: Pipeline, seen: Observation, moved: Callable[[], Array]) -> dict[str, Tick]:
    """The ways to make a tick on a backend, by what they are called."""
    return {
        f"command on {name}": lambda: pipeline.ticks(seen, certified=False),
        f"certified on {name}": lambda: pipeline.evaluate(seen),
        f"with kinematics on {name}": lambda: pipeline.ticks(replace(seen, jacobian=moved()), certified=False),
    }


def observations(seen: Observation) -> Iterator[Observation]:
    """Many others about an observation: contacts anywhere, some away, joints at their limits."""
    random = np.random.default_rng(0)
    for _ in range(100):
        normals = random.normal(size=seen.normals.shape)
        yield replace(
            seen,
            points=seen.points + 0.01 * random.normal(size=seen.points.shape),
            normals=normals / np.linalg.norm(normals, axis=-1, keepdims=True),
            forces=random.normal(size=seen.forces.shape),
            touching=random.random(seen.touching.shape) < 0.9,
            joints=np.where(random.random(seen.joints.shape) < 0.1, 100.0, seen.joints),
            jacobian=seen.jacobian + 0.05 * random.normal(size=seen.jacobian.shape),
        )


def tree_of(program: Program) -> ET.Element:
    """The URDF of hand and mount with the ten driven joints alone: those that follow them stand still, so that all
    solve for as many."""
    tree = joined(program.robot)
    for joint in tree.iter("joint"):
        if joint.get("name") in program.robot.hand.couplings:
            joint.set("type", "fixed")
    return tree


def model_of(program: Program) -> mujoco.MjModel:
    """The same, as MuJoCo has it."""
    spec = spec_of(tree_of(program))
    spec.compiler.fusestatic = False
    return spec.compile()


def tips_of(program: Program) -> list[str]:
    """The links of the fingertips."""
    return [contact.link for contact in program.robot.hand.contacts.values()]


def places_of(program: Program, model: mujoco.MjModel) -> list[int]:
    """Where in the positions of a model the joints of a robot are."""
    return [int(model.joint(name).qposadr[0]) for name in program.robot.joints]


def kinematics(program: Program, model: mujoco.MjModel, joints: Array) -> Callable[[], Array]:
    """What makes the Jacobians (k, 3, n) of the fingertips of joint positions, as mink has them made by the engine."""
    data, places = mujoco.MjData(model), places_of(program, model)
    bodies = [model.body(tip).id for tip in tips_of(program)]
    jacobian = np.zeros((len(bodies), 3, model.nv))

    def made() -> Array:
        data.qpos[places] = joints
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        for row, body in enumerate(bodies):
            mujoco.mj_jac(model, data, jacobian[row], None, data.xpos[body], body)
        return jacobian[..., places]

    return made


def mink_tick(program: Program, model: mujoco.MjModel, joints: Array) -> Tick:
    """A tick of mink: where the joints are, and how they shall move."""
    mink: Any = importlib.import_module("mink")
    position = np.zeros(model.nq)
    position[places_of(program, model)] = joints
    configuration = mink.Configuration(model, position)
    tasks = [mink.FrameTask(tip, "body", position_cost=1.0, orientation_cost=0.0) for tip in tips_of(program)]
    for task in tasks:
        target = configuration.get_transform_frame_to_world(task.frame_name, "body")
        task.set_target(mink.SE3.from_rotation_and_translation(target.rotation(), target.translation() + FORWARD))
    posture = mink.PostureTask(model, cost=POSTURE)
    posture.set_target(position)

    def tick() -> object:
        configuration.update(position)
        return mink.solve_ik(configuration, [*tasks, posture], 1.0 / program.target.rate, SOLVER)

    return tick


def pink_tick(program: Program, tree: ET.Element, joints: Array) -> Tick:
    """A tick of Pink, the same."""
    pink: Any = importlib.import_module("pink")
    pinocchio: Any = importlib.import_module("pinocchio")
    model = pinocchio.buildModelFromXML(ET.tostring(tree, encoding="unicode"))
    position = pinocchio.neutral(model)
    for name, joint in zip(program.robot.joints, joints, strict=True):
        position[model.joints[model.getJointId(name)].idx_q] = joint
    configuration = pink.Configuration(model, model.createData(), position)
    tasks = [pink.FrameTask(tip, position_cost=1.0, orientation_cost=0.0) for tip in tips_of(program)]
    for task in tasks:
        target = configuration.get_transform_frame_to_world(task.frame).copy()
        target.translation = target.translation + FORWARD
        task.set_target(target)
    posture = pink.PostureTask(cost=POSTURE)
    posture.set_target(position)

    def tick() -> object:
        configuration.update(position)
        return pink.solve_ik(configuration, [*tasks, posture], 1.0 / program.target.rate, solver=SOLVER)

    return tick
