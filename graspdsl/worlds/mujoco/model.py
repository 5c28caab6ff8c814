"""A scene as MuJoCo compiles it: table, object and robot in one model."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from graspdsl.angles import turned_by_angles
from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot
from graspdsl.hands.fingertips import CapsuleTip, EllipsoidTip, FingertipShape, SphereTip
from graspdsl.models.model import UNSTATED_EFFORT
from graspdsl.objects.facets import Hull
from graspdsl.objects.shape import convex_parts
from graspdsl.objects.shapes import Body
from graspdsl.objects.surfaces.mesh import unit_sphere
from graspdsl.worlds.kind import Anchor, WorldSettings
from graspdsl.worlds.mujoco.meshes import spec_of
from graspdsl.worlds.protocol import TABLE_SIZE
from graspdsl.worlds.rigid.assembly import joined
from graspdsl.worlds.rigid.engine import OUT_OF_THE_WAY, ROLLING_RESISTANCE, stands_free, stands_still
from graspdsl.worlds.rigid.neighbours import links_of_hand, neighbours
from graspdsl.worlds.touch.surfaces import frame_about

ROLLS = 6  # the dimensions of a contact that resists rolling
TABLE, OBJECT, HELD = "table", "object", "held"
TIP = "tip:"  # before the names of what a fingertip has more than its link
LINK_FRICTION = 0.5  # of what else of the robot meets the object
# The driven joints: how stiffly they are held [N·m/rad, N/m], and the inertia of their motors [kg m², kg].
HINGE_STIFFNESS, SLIDE_STIFFNESS = 2000.0, 2e5
HINGE_ARMATURE, SLIDE_ARMATURE = 0.01, 0.1
CONTACT_SOLREF, CONTACT_SOLIMP = [0.006, 1.0], [0.95, 0.99, 0.001, 0.5, 2.0]
# Fingertips are soft. The engine adds a mass to a spring between two bodies, d / (1 - d) of theirs.
SOFT_IMPEDANCE = 0.02
# What slips drags on the surface by its speed [N·s/m], as far as friction goes, and on the normal by this: the engine's
# friction is that of a convex problem, in which what slides is lifted off.
DRAG, LIFT = 1e4, 1.0
WELD_SOLREF, WELD_SOLIMP = [0.004, 1.0], [0.99, 0.9999, 0.0001, 0.5, 2.0]
BARE_TIP = 0.005  # kg, of a fingertip without a link of its own
AROUND = 4  # rings of directions in which a rounded hull is blown up
ACTING = "acting:"  # before the names of the sensors of what acts on the object
_FIELD = mujoco.mjtConDataField
_FIELDS = (_FIELD.mjCONDATA_FORCE, _FIELD.mjCONDATA_TORQUE, _FIELD.mjCONDATA_POS)
_NET_FORCE = (sum(1 << int(field) for field in _FIELDS), 3, 1)  # of all contacts, as one
# Bits of what collides with what.
_TABLE, _OBJECT, _HAND, _ARM = 1, 2, 4, 8


@dataclass(frozen=True, slots=True)
class TipBody:
    """A fingertip: the body that carries its shape, and the site of its load cell."""

    body: str
    cell: str


def scene_spec(body: Body, table_friction: float, gravity: float, anchor: Anchor) -> mujoco.MjSpec:
    """A table, and an object on it with its shape's frame upright at the origin."""
    return _with_scene(mujoco.MjSpec(), body, table_friction, gravity, anchor)


def robot_spec(settings: WorldSettings) -> tuple[mujoco.MjSpec, list[TipBody]]:
    """Table, object and robot, the robot's root at the origin; and its fingertips."""
    robot = settings.robot
    tree = joined(robot)
    for link in tree.iterfind("link"):
        for looks in link.findall("visual"):
            link.remove(looks)
    spec = spec_of(tree)
    hand = links_of_hand(tree, robot)
    _drive(spec, hand)
    for pair in neighbours(tree, robot):
        if {*pair} <= {*hand}:  # no others would touch
            spec.add_exclude(bodyname1=pair[0], bodyname2=pair[1])
    tips = [_fingertip(spec, name, robot) for name in robot.contacts]
    _with_scene(spec, settings.body, settings.table_friction, settings.gravity, settings.anchor)
    _touch(spec, tips, settings.friction)
    _feel(spec, robot, tips)
    if settings.anchor is Anchor.HAND:
        weld = spec.add_equality(name=HELD, type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_BODY)
        weld.name1, weld.name2, weld.active = robot.hand.palm, OBJECT, False
        weld.solref, weld.solimp = WELD_SOLREF, WELD_SOLIMP
    return spec, tips


def _with_scene(
    spec: mujoco.MjSpec, body: Body, table_friction: float, gravity: float, anchor: Anchor
) -> mujoco.MjSpec:
    spec.compiler.fusestatic = False
    option = spec.option
    option.gravity = [0.0, 0.0, -gravity]
    option.integrator, option.cone = mujoco.mjtIntegrator.mjINT_IMPLICITFAST, mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = DRAG / LIFT
    # What leaves the realm of numbers is told, not begun anew.
    option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    half = [size / 2 for size in TABLE_SIZE]
    table = spec.worldbody.add_geom(name=TABLE, type=mujoco.mjtGeom.mjGEOM_PLANE, size=[half[0], half[1], 0.1])
    table.pos = [0.0, 0.0, 0.0 if stands_free(anchor) else -OUT_OF_THE_WAY]
    _collide(table, _TABLE, _OBJECT | _HAND | _ARM, table_friction)
    if body.shape.lies_round:
        table.condim, table.friction = ROLLS, [table_friction, 0.0, ROLLING_RESISTANCE]
    _put_object(spec, body, anchor)
    return spec


def _put_object(spec: mujoco.MjSpec, body: Body, anchor: Anchor) -> None:
    solid = body.shape.solid
    inertia = solid.inertia(body.mass)
    made = spec.worldbody.add_body(name=OBJECT, pos=[0.0, 0.0, body.shape.extent[2] / 2])
    made.explicitinertial, made.mass, made.ipos = True, body.mass, solid.centre
    made.fullinertia = [*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    if not stands_still(anchor):
        made.add_freejoint(name=OBJECT)
    for number, geom in enumerate(_object_geoms(spec, made, body)):
        geom.name = f"{OBJECT}-{number}"
        _collide(geom, _OBJECT, _TABLE | _HAND | _ARM, 0.0)  # the engine takes the larger friction of two


def _object_geoms(spec: mujoco.MjSpec, made: mujoco.MjsBody, body: Body) -> Iterator[mujoco.MjsGeom]:
    match body.shape.primitive:
        case "cylinder", (radius, top):
            yield made.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[radius, top, 0.0])
        case "box", half:
            yield made.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=list(half))
        case "sphere", (radius,):
            yield made.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0.0, 0.0])
        case _:
            for number, hull in enumerate(convex_parts(body.shape)):
                name = f"{OBJECT}-{number}"
                mesh = spec.add_mesh(name=name, uservert=blown_up(hull).ravel())
                mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
                yield made.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name)


def blown_up(hull: Hull) -> Array:
    """Vertices (v, 3) [m] of a polyhedron as large as a rounded hull: within its margin, and nearly so all round."""
    if hull.margin == 0.0:
        return hull.vertices
    from scipy.spatial import ConvexHull

    around = unit_sphere(AROUND).reshape(-1, 3)
    points = (hull.vertices[:, None] + hull.margin * around).reshape(-1, 3)
    return np.asarray(points[ConvexHull(points).vertices])


def _collide(geom: mujoco.MjsGeom, own: int, others: int, friction: float) -> None:
    geom.contype, geom.conaffinity = own, others
    geom.friction = [friction, 0.0, 0.0]
    geom.solref, geom.solimp = CONTACT_SOLREF, CONTACT_SOLIMP


def _drive(spec: mujoco.MjSpec, hand: Collection[str]) -> None:
    """Motors that hold every joint, and the weight of every link borne."""
    for link in spec.bodies[1:]:
        link.gravcomp = 1.0
        own, others = (_HAND, _TABLE | _OBJECT | _HAND) if link.name in hand else (_ARM, _TABLE | _OBJECT)
        for geom in link.geoms:
            _collide(geom, own, others, LINK_FRICTION)
    for joint in spec.joints:
        slides = joint.type == mujoco.mjtJoint.mjJNT_SLIDE
        joint.armature = SLIDE_ARMATURE if slides else HINGE_ARMATURE
        effort = float(joint.actfrcrange[1]) or UNSTATED_EFFORT
        motor = spec.add_actuator(name=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint.name)
        motor.set_to_position(SLIDE_STIFFNESS if slides else HINGE_STIFFNESS, dampratio=1.0)
        motor.forcelimited, motor.forcerange = mujoco.mjtLimited.mjLIMITED_TRUE, [-effort, effort]


def _fingertip(spec: mujoco.MjSpec, contact: str, robot: Robot) -> TipBody:
    """Make a fingertip of its declared shape, with a load cell before it."""
    said = robot.hand.contacts[contact]
    cell = f"{TIP}{said.link}"
    link = spec.body(said.link)
    for geom in list(link.geoms):
        spec.delete(geom)
    if not said.cell:  # its link is no fingertip alone
        link = link.add_body(name=cell, gravcomp=1.0)
        link.explicitinertial, link.mass, link.ipos = True, BARE_TIP, list(said.shape.centre)
        link.inertia = [0.4 * BARE_TIP * 0.01**2] * 3
    geom = tip_geom(link, said.shape)
    geom.name = cell
    _collide(geom, _HAND, _TABLE | _HAND, 0.0)
    link.add_site(name=cell, pos=link.ipos)
    for kind, sensor in (("force", mujoco.mjtSensor.mjSENS_FORCE), ("moment", mujoco.mjtSensor.mjSENS_TORQUE)):
        spec.add_sensor(name=f"{cell}-{kind}", type=sensor, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=cell)
    return TipBody(link.name, cell)


def _touch(spec: mujoco.MjSpec, tips: Sequence[TipBody], friction: float) -> None:
    """Fingertips meet the object as pairs of their own, whose softness a state of the model sets."""
    for tip in tips:
        for geom in spec.body(OBJECT).geoms:
            pair = spec.add_pair(name=f"{tip.cell}:{geom.name}", geomname1=tip.cell, geomname2=geom.name, condim=3)
            pair.friction = [friction, friction, 0.0, 0.0, 0.0]
            pair.solimp = [SOFT_IMPEDANCE, SOFT_IMPEDANCE, 0.001, 0.5, 1.0]


def _feel(spec: mujoco.MjSpec, robot: Robot, tips: Sequence[TipBody]) -> None:
    """Sensors of what acts on the object, force, moment and place: of the table, the whole robot, each fingertip."""
    kinds, root = mujoco.mjtObj, spec.body(robot.hand.root)
    while root.parent.name != "world":
        root = root.parent
    whole = [(TABLE, kinds.mjOBJ_GEOM), (root.name, kinds.mjOBJ_XBODY)]
    for name, kind in [*whole, *((tip.cell, kinds.mjOBJ_GEOM) for tip in tips)]:
        sensor = spec.add_sensor(name=f"{ACTING}{name}", type=mujoco.mjtSensor.mjSENS_CONTACT)
        sensor.objtype, sensor.objname, sensor.reftype, sensor.refname = kind, name, kinds.mjOBJ_BODY, OBJECT
        sensor.intprm = [*_NET_FORCE, *sensor.intprm[3:]]


def tip_geom(link: mujoco.MjsBody, shape: FingertipShape) -> mujoco.MjsGeom:
    """Give a link the shape of a fingertip."""
    kinds = mujoco.mjtGeom
    match shape:
        case SphereTip():
            geom = link.add_geom(type=kinds.mjGEOM_SPHERE, size=[shape.radius, 0.0, 0.0])
        case CapsuleTip():
            geom = link.add_geom(type=kinds.mjGEOM_CAPSULE, size=[shape.radius, shape.length / 2, 0.0])
            geom.quat = quaternion_of(frame_about(np.array(shape.axis)))
        case EllipsoidTip():
            geom = link.add_geom(type=kinds.mjGEOM_ELLIPSOID, size=list(shape.semi_axes))
            geom.quat = quaternion_of(turned_by_angles(shape.rpy))
    geom.pos = list(shape.centre)
    return geom


def quaternion_of(rotation: Array) -> Array:
    """The quaternion (4,), w first, of a rotation (3, 3)."""
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    return quaternion


def part_overlapping(spec: mujoco.MjSpec, model: mujoco.MjModel) -> bool:
    """Let links of the hand that overlap as the joints stand at zero not touch each other; whether there were any.

    Parts of a closed loop do that wherever they are.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    met = {
        tuple(sorted(model.body(model.geom_bodyid[geom]).name for geom in contact.geom))
        for contact in data.contact
        if contact.dist < 0.0 and (model.geom_contype[contact.geom] == _HAND).all()
    }
    for link, other in sorted(met):
        spec.add_exclude(bodyname1=link, bodyname2=other)
    return bool(met)
