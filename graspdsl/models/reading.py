"""A model out of a file, URDF or MJCF."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from graspdsl.arrays import Array
from graspdsl.diagnostics import known_names_hint, listed
from graspdsl.models.compiled import Compiled, compiled
from graspdsl.models.following import followed
from graspdsl.models.inertia import physical
from graspdsl.models.joint_kinds import CONTINUOUS, FIXED, PRISMATIC, REVOLUTE
from graspdsl.models.mjcf import mjcf_for_compiler
from graspdsl.models.model import UNSTATED_EFFORT, Frame, Joint, Link, Model, Solid
from graspdsl.models.source import Complaints, Prepared, check_numbers, prepared
from graspdsl.models.strengths import efforts
from graspdsl.models.urdf import moderate, urdf_for_compiler
from graspdsl.places.files import SpecFolder, refusal
from graspdsl.places.wording import shortened
from graspdsl.places.xml_files import PlacedElement, place_in, xml_tree

if TYPE_CHECKING:
    import mujoco

WORLD = "world"
MACRO = re.compile(r"\{[^}]*xacro|xacro:")
FARTHEST = 10.0  # m
HEAVIEST = 100.0  # kg
WEIGHTLESS = 1e-9  # kg; the compiler gives as much as 1e-14 to what has none
LIGHT = 1e-3  # kg: what a link is given that moves and has no mass
SHARE = 0.01  # of a body's mass, for each of the links that stand for its joints but the last
DIGITS = 12  # of places [m] and rotations


def read_model(files: SpecFolder, name: str, root: str = "") -> Model:
    """The model in a URDF or MJCF file, which is named as a spec names files; only what is below ``root``, where that
    is named.

    The compiler of MuJoCo reads it. Bodies of MJCF become links of the same name, in the same frame with all joints at
    0; a body with several joints, or with one elsewhere than at its origin, hangs on a chain of links, one for each. A
    body that floats freely is held. Raises DiagnosticError with what is wrong in the file.
    """
    return model_in(files.read(name), files, name, root)


def model_in(content: bytes, files: SpecFolder, name: str, root: str = "") -> Model:
    """The model in the content of a file, as ``read_model`` has it."""
    tree = xml_tree(content, name)
    complaints = Complaints()
    match tree.tag:
        case "robot":
            links, joints = _of_urdf(tree, files, name, root, complaints)
        case "mujoco":
            links, joints = _of_mjcf(tree, files, name, root, complaints)
        case other:
            message = f"{name} is no model: its root is <{shortened(other)}>, neither <robot> nor <mujoco>"
            hint = "name the file that includes it" if other == "mujocoinclude" else "name a URDF or a MJCF file"
            raise refusal("not-a-model", message, hint)
    complaints.refuse()
    _leave_out_circles(joints, complaints)
    _warn_of_motors(joints, complaints)
    return Model(next(iter(links)), links, joints, tuple(complaints.warnings))


Parts = tuple[dict[str, Link], dict[str, Joint]]


def _of_urdf(tree: PlacedElement, files: SpecFolder, name: str, root: str, complaints: Complaints) -> Parts:
    _refuse_macros(tree)
    urdf = urdf_for_compiler(tree, name, root, complaints)
    given = prepared(name, urdf.tree, urdf.meshes)
    found = compiled(given, files, name, complaints)
    links, joints = _Reading(found, given, complaints, urdf.before, urdf.held).model(urdf.root)
    _warn_of_weights(urdf.tree, links, complaints)
    return links, {joint: replace(made, mimic=urdf.mimics.get(joint)) for joint, made in joints.items()}


def _of_mjcf(tree: PlacedElement, files: SpecFolder, name: str, root: str, complaints: Complaints) -> Parts:
    mjcf = mjcf_for_compiler(tree, files, name, complaints)
    check_numbers(mjcf.tree, complaints)
    given = prepared(name, mjcf.tree, mjcf.meshes)
    found = compiled(given, files, name, complaints)
    links, joints = _Reading(found, given, complaints, {}, {}).model(_root(found.model, name, root))
    moderate(len(links), sum(joint.kind != FIXED for joint in joints.values()), name, bool(root))
    mimics, still = followed(found.model, given, joints, complaints)
    strong = efforts(found.model)
    for joint, made in joints.items():
        driven = replace(made, mimic=mimics.get(joint), effort=strong.get(joint, 0.0))
        joints[joint] = made.held(still[joint]) if joint in still else driven
    return links, joints


def _leave_out_circles(joints: dict[str, Joint], complaints: Complaints) -> None:
    """Of joints that follow one another in a circle none leads: each goes its own way."""
    circle = []
    for name in joints:
        seen, mimic = {name}, joints[name].mimic
        while mimic is not None and mimic.joint in joints and mimic.joint not in seen:
            seen.add(mimic.joint)
            mimic = joints[mimic.joint].mimic
        if mimic is not None and mimic.joint == name:
            circle.append(name)
    for name in circle:
        joints[name] = replace(joints[name], mimic=None)
    if circle:
        message = f"{_some(circle)} follow one another in a circle: that is left out"
        complaints.warn(joints[circle[0]].where, "left-out", message, "let all but one of them follow that one")


def _warn_of_weights(tree: ElementTree.Element, links: Mapping[str, Link], complaints: Complaints) -> None:
    """Other readers of URDF give no mass to a link that says nothing of it."""
    stated = {link.get("name") for link in tree.iterfind("link") if link.find("inertial") is not None}
    weighed = {name: link for name, link in links.items() if name not in stated and link.solids and link.mass > 0.0}
    if weighed:
        mass = 1000.0 * sum(link.mass for link in weighed.values())
        message = (
            f"{_some(list(weighed))} without <inertial> weigh what their geometry does as water, {mass:.3g} g in all"
        )
        complaints.warn(next(iter(weighed.values())).where, "weighed", message, "give each an <inertial>")


def _warn_of_motors(joints: Mapping[str, Joint], complaints: Complaints) -> None:
    """No motor is driven without a bound to its effort, and not every engine has friction in joints."""
    moving = {name: joint for name, joint in joints.items() if joint.kind != FIXED}
    weak = [name for name, joint in moving.items() if joint.effort == 0.0 and joint.limits is not None]
    if weak:
        used = f"up to {UNSTATED_EFFORT:g} N m, or N of a slide, is used"
        message = f"the model says no effort, or 0, of {_some(weak)}: {used}"
        hint = 'say how strong they are: effort="…" in <limit>, actuatorfrcrange="-… …" in MJCF'
        complaints.warn(moving[weak[0]].where, "no-effort", message, hint)
    rubbing = [name for name, joint in moving.items() if joint.friction > 0.0]
    if rubbing:
        message = f"the friction in {_some(rubbing)} has no effect in the bullet world: its joints have none"
        complaints.warn(moving[rubbing[0]].where, "no-effect", message, "give them damping, or leave it out")


def _some(names: Sequence[str]) -> str:
    return listed([*names[:5], *(["others"] if len(names) > 5 else [])])


def _refuse_macros(tree: PlacedElement) -> None:
    macro = next((element for element in tree.iter() if MACRO.match(element.tag)), None)
    if macro is not None:
        message = f"{place_in(tree.file, macro)}: this is a xacro file, not yet a URDF"
        raise refusal(
            "not-a-urdf", message, "expand it: pip install xacrodoc, then xacrodoc hand.urdf.xacro -o hand.urdf"
        )


def _root(model: mujoco.MjModel, file: str, root: str) -> str:
    """The body with which a robot begins: the named one, or the only one below which something moves."""
    names = [str(model.body(number).name) for number in range(model.nbody)]
    if root:
        if root not in names:
            message = f"there is no body {root!r} in the model"
            raise refusal("unknown-root", message, known_names_hint(root, names, "bodies"))
        return root
    tops = [number for number in range(1, model.nbody) if model.body_parentid[number] == 0]
    moving = [joint for joint in range(model.njnt) if model.jnt_type[joint] > 1]
    hinged = {int(model.body_rootid[model.jnt_bodyid[joint]]) for joint in moving}
    if len(hinged) > 1:  # what else moves in a scene has no motors
        motors = [joint for joint in moving if model.joint(joint).name in efforts(model)]
        driven = {int(model.body_rootid[model.jnt_bodyid[joint]]) for joint in motors}
        hinged = (hinged & driven) or hinged
    found = [names[number] for number in (hinged or tops)]
    if len(found) != 1:
        what = f"{len(found)} bodies of the world have joints" if hinged else f"the world has {len(found)} bodies"
        message = f"{file}: {what}, where a robot is one: {listed(found[:5]) or 'none'}"
        raise refusal("no-root", message, f"name one by root, or root: {WORLD} for all of them")
    return found[0]


class _Reading:
    """What the compiler made of a model, taken out of its arrays with all joints at 0, or where they are held."""

    def __init__(
        self,
        found: Compiled,
        given: Prepared,
        complaints: Complaints,
        before: Mapping[str, str],
        held: Mapping[str, float],
    ) -> None:
        import mujoco

        self._model, self._meshes, self._given, self._complaints = found.model, found.meshes, given, complaints
        self._before, self._held = before, held
        self._data = mujoco.MjData(self._model)
        for number in range(self._model.njnt):
            if self._model.jnt_type[number] > 1:  # neither free nor a ball
                place = held.get(self._model.joint(number).name, 0.0)
                self._data.qpos[self._model.jnt_qposadr[number]] = place
        mujoco.mj_kinematics(self._model, self._data)
        self._links, self._joints = dict[str, Link](), dict[str, Joint]()

    def model(self, root: str) -> tuple[dict[str, Link], dict[str, Joint]]:
        """Links and joints below a root, parents before children."""
        top = self._model.body(root).id
        inside = {top}
        parent = root
        if self._hinges(top):  # the first joint has to join the robot to something
            parent = f"{root}-base"
            self._links[parent] = Link(0.0, np.zeros(3), np.zeros((3, 3)), (), self._given.place("body", root))
            self._hang(top, parent, self._body_frame(self._model.body_parentid[top]))
        else:
            self._links[root] = self._link(top)
        for body in range(top + 1, self._model.nbody):
            above = int(self._model.body_parentid[body])
            if above in inside and not (top == 0 and self._floats(body)):
                inside.add(body)
                self._hang(body, self._model.body(above).name, self._body_frame(above))
        self._weigh()
        self._check()
        return self._links, self._joints

    def _floats(self, body: int) -> bool:
        joints = self._of_body(body)
        return bool(joints) and self._model.jnt_type[joints[0]] == 0

    def _of_body(self, body: int) -> list[int]:
        first = int(self._model.body_jntadr[body])
        return list(range(first, first + int(self._model.body_jntnum[body]))) if first >= 0 else []

    def _hinges(self, body: int) -> list[int]:
        """The joints of a body that turn or slide and are not held."""
        found = [joint for joint in self._of_body(body) if self._model.jnt_type[joint] > 0]
        for joint in found:
            if self._model.jnt_type[joint] == 1:
                name = self._model.joint(joint).name
                where = self._given.place("joint", name)
                self._complaints.fault(
                    where, "unknown-joint-type", f"the joint {name} is a ball", "write three hinges in its place"
                )
        return [
            joint
            for joint in found
            if self._model.jnt_type[joint] > 1 and self._model.joint(joint).name not in self._held
        ]

    def _body_frame(self, body: int) -> Frame:
        return Frame(self._data.xpos[body].copy(), self._data.xmat[body].reshape(3, 3).copy())

    def _hang(self, body: int, parent: str, above: Frame) -> None:
        """Add a body to its parent, by a chain of its joints."""
        name, own, hinges = self._model.body(body).name, self._body_frame(body), self._hinges(body)
        link = self._link(body)
        carriers = []
        for number, joint in enumerate(hinges):
            frame = Frame(self._data.xanchor[joint].copy(), own.rotation)
            last = number == len(hinges) - 1
            at_origin = last and np.allclose(frame.place, own.place, rtol=0.0, atol=10.0**-DIGITS)
            child = name if at_origin else f"{name}-at-{self._model.joint(joint).name}"
            made = self._joint(joint, parent, child, above.inverse().then(frame))
            self._joints[self._model.joint(joint).name] = made
            if child != name:
                carriers.append((child, frame))
                self._links[child] = link  # in its place, before what hangs on it
            parent, above = child, frame
        if parent != name:
            fixed = self._before.get(name, f"{name}-fixed")
            where = self._given.place("body", name)
            at = self._held.get(fixed)
            limits = None if at is None else (at, at)
            frame = _tidy(above.inverse().then(own))
            self._joints[fixed] = Joint(FIXED, parent, name, frame, np.zeros(3), limits, 0.0, 0.0, 0.0, where)
        for child, frame in carriers:
            inner = frame.inverse().then(own)
            share = SHARE * link.mass, inner.place + link.centre, SHARE * link.inertia
            self._links[child] = Link(*share, (), link.where)
        rest = 1.0 - SHARE * len(carriers)
        self._links[name] = replace(link, mass=rest * link.mass, inertia=rest * link.inertia)

    def _joint(self, joint: int, parent: str, child: str, frame: Frame) -> Joint:
        model = self._model
        name = model.joint(joint).name
        where = self._given.place("joint", name)
        low, high = model.jnt_range[joint].tolist()
        limits = (low, high) if model.jnt_limited[joint] else None
        kind = PRISMATIC if model.jnt_type[joint] == 2 else CONTINUOUS if limits is None else REVOLUTE
        axis = self._data.xaxis[joint] @ self._body_frame(model.jnt_bodyid[joint]).rotation
        strongest = float(np.abs(model.jnt_actfrcrange[joint]).max()) if model.jnt_actfrclimited[joint] else 0.0
        dof = model.jnt_dofadr[joint]
        damping, friction = float(model.dof_damping[dof].max()), float(model.dof_frictionloss[dof])
        return Joint(kind, parent, child, _tidy(frame), _unit(axis), limits, strongest, damping, friction, where)

    def _link(self, body: int) -> Link:
        model = self._model
        mass = float(model.body_mass[body])
        mass = mass if mass > WEIGHTLESS else 0.0
        axes = _rotation(model.body_iquat[body])
        moments = model.body_inertia[body] if mass else np.zeros(3)
        solids = tuple(self._solids(body))
        looks = any(not solid.touches for solid in solids)
        seen = tuple(replace(solid, seen=not solid.touches or not looks) for solid in solids)
        where = self._given.place("body", model.body(body).name)
        return Link(mass, model.body_ipos[body].copy() if mass else np.zeros(3), axes * moments @ axes.T, seen, where)

    def _solids(self, body: int) -> Iterator[Solid]:
        import mujoco

        model = self._model
        first = int(model.body_geomadr[body])
        for geom in range(first, first + int(model.body_geomnum[body])):
            kind = KINDS.get(mujoco.mjtGeom(model.geom_type[geom]).name)
            if kind is None:  # a plane or a field is no part of a robot
                continue
            x, y, z = model.geom_size[geom].tolist()
            frame = Frame(model.geom_pos[geom].copy(), _rotation(model.geom_quat[geom]))
            mesh = None
            if kind == "mesh":
                number = int(model.geom_dataid[geom])
                mesh, put = self._meshes[number]
                # The compiler has moved the mesh to its centre of mass and turned it to its axes of inertia.
                moved = Frame(model.mesh_pos[number], _rotation(model.mesh_quat[number]))
                frame = frame.then(moved.inverse()).then(put)
            sizes = {
                "box": (2 * x, 2 * y, 2 * z),
                "sphere": (x,),
                "cylinder": (x, 2 * y),
                "capsule": (x, 2 * y),
                "ellipsoid": (x, y, z),
            }.get(kind, ())
            material = int(model.geom_matid[geom])
            rgba = (model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom]).tolist()
            colour = None if material < 0 and rgba == PLAIN else tuple(round(part, 4) for part in rgba)
            touches = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
            where = self._given.place("geom", model.geom(geom).name)
            yield Solid(kind, sizes, _tidy(frame), touches, True, colour, where, mesh)

    def _weigh(self) -> None:
        """Give a small mass to what moves and has none, and inertia to what turns and has none."""
        rigid = {name: name for name in self._links}
        masses = dict.fromkeys(self._links, 0.0)
        for joint in self._joints.values():
            if joint.kind == FIXED:
                rigid[joint.child] = rigid[joint.parent]
        for name, link in self._links.items():
            masses[rigid[name]] += link.mass
        light = [joint for joint in self._joints.values() if joint.kind != FIXED and masses[joint.child] == 0.0]
        for joint in light:
            link = self._links[joint.child]
            self._links[joint.child] = replace(link, mass=LIGHT, inertia=physical(np.zeros((3, 3)), LIGHT))
        if light:
            names = listed([joint.child for joint in light][:5])
            message = f"{names} move and have no mass: {1000 * LIGHT:g} g is given to each ({len(light)})"
            self._complaints.warn(light[0].where, "no-mass", message, "give each an <inertial> with its mass")

    def _check(self) -> None:
        """Complain about what is too large or too heavy to be a hand: most likely it is in other units."""
        for name, link in self._links.items():
            if link.mass > HEAVIEST:
                message = f"the mass of {name} is {link.mass:.4g} kg"
                self._complaints.fault(link.where, "out-of-range", message, "masses are in kilograms")
            for solid in link.solids:
                size = float(np.ptp(solid.mesh.corners, axis=0).max()) if solid.mesh else max(solid.sizes)
                if max(size, np.abs(solid.frame.place).max()) > FARTHEST and (solid.touches or not solid.mesh):
                    message = f"a {solid.kind} of {name} is {size:.4g} m large or as far away"
                    hint = 'lengths are in metres; a mesh in millimetres has scale="0.001 0.001 0.001"'
                    self._complaints.fault(solid.where, "out-of-range", message, hint)
        for name, joint in self._joints.items():
            if np.abs(joint.frame.place).max() > FARTHEST:
                message = f"the joint {name} is more than {FARTHEST:g} m away from the one before it"
                self._complaints.fault(joint.where, "out-of-range", message, "lengths are in metres")


KINDS = {f"mjGEOM_{kind.upper()}": kind for kind in ("box", "sphere", "cylinder", "capsule", "ellipsoid", "mesh")}
PLAIN = [0.5, 0.5, 0.5, 1.0]


def _rotation(quaternion: Array) -> Array:
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _unit(axis: Array) -> Array:
    """A unit vector as exactly one as it gets: Bullet asks that of axes."""
    rounded: Array = np.round(axis, DIGITS) + 0.0
    return rounded if np.linalg.norm(rounded) == 1.0 else axis / np.linalg.norm(axis)


def _tidy(frame: Frame) -> Frame:
    """A frame without the digits that rounding has left."""
    return Frame(np.round(frame.place, DIGITS) + 0.0, np.round(frame.rotation, DIGITS) + 0.0)
