"""The contract of worlds: what each owes its controllers, whichever engine is behind it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields, replace
from typing import get_args

import numpy as np

from graspdsl.basis.spaces import GradientSpace
from graspdsl.contracts.keys import unsaid
from graspdsl.contracts.rule import Breach, contract
from graspdsl.declared import misdeclared
from graspdsl.diagnostics import listed
from graspdsl.hands.descriptions import robot
from graspdsl.objects.shapes import catalogue
from graspdsl.spec.scene import GRAVITY
from graspdsl.worlds.kind import Ability, Anchor, View, WorldKind, WorldSettings
from graspdsl.worlds.protocol import (
    PARTIES,
    Command,
    InfeasibleStartError,
    ManyWorld,
    Observation,
    Start,
    Truth,
    WitnessedWorld,
)
from graspdsl.worlds.start_pose import pose
from graspdsl.worlds.touch.sensors import TACTILE_SENSORS, sensor_for

ROBOT, BODY = robot("barrett", "gantry"), catalogue()["towel-roll"]
DRAWN = {"roll": 0.3, "yaw": 0.2, "tilt": 0.0, "height": 0.1, "standoff": 0.047, "offset": 0.0}
START = pose("side", DRAWN, BODY, ROBOT.hand.palm_surface)
WITHIN = Start(np.array([0.0, 0.0, -0.05]), np.eye(3), DRAWN)  # the hand in the table, beneath the object
SEED = 11
TICKS, SETTLED = 5, 50
STILL = 1e-3  # m, that contacts may give way
SMALL = 2e-3  # m or rad
OBEYED = 0.2  # of a command, that may be left undone once all has settled
MOVED = 0.05  # of what joints moved, that contacts may be off from their Jacobian
CLOSING, MOST_TICKS = 0.01, 300  # rad or m a tick
CANCELLED = 1e-2  # of the weight
AGREED, SOFT = 1e-6, 1e-3  # m, of exact sensors and of all others
TRIALS = 3


def declared(kind: WorldKind) -> Iterator[Breach]:
    """A world says what it carries out and what it lacks, each with a reason that messages can take."""
    yield from misdeclared(kind, WorldKind)
    if not kind.rate > 0.0:
        yield f"its rate is {kind.rate}", "give ticks a second"
    if not kind.sliding:
        yield "it carries out no gradient", "name the spaces that it carries out, such as GradientSpace.CARTESIAN"
    if not (kind.sliding <= kind.probing or kind.probes("probing")):
        yield "by probing it carries out less than by sliding, and does not probe", "let probing hold what sliding does"
    if not kind.approaches:
        yield "it has no starts", "name its approaches"
    for ability in kind.lacks:
        if ability not in get_args(Ability):
            yield f"it lacks {ability!r}", f"a world may lack {listed(get_args(Ability), 'or')}"
    for ability, reason in kind.lacks.items():
        if not reason or not reason[0].islower() or reason.endswith("."):
            yield f"it lacks {ability}: {reason!r}", "say why as part of a sentence, without a full stop"


def told(kind: WorldKind) -> Iterator[Breach]:
    """A docstring, and lines for lists, say what it is."""
    yield from unsaid(type(kind), "name", "about", "pace", "contacts")


def senses(kind: WorldKind) -> Iterator[Breach]:
    """Its sensors are in the table, and the first is what contacts feel through where nothing is said."""
    unknown = [name for name in kind.senses if name not in TACTILE_SENSORS]
    if unknown or not kind.senses:
        yield f"it senses by {listed(unknown) or 'nothing'}", f"name {listed(TACTILE_SENSORS, 'or')}"
        return
    for choice, name in ((None, kind.senses[0]), *zip(kind.senses, kind.senses, strict=True)):
        if sensor_for(kind.sensor(choice)).name != name:
            yield f"where {choice or 'nothing'} is said it does not sense by {name}", "leave sensor() as it is"


def info(kind: WorldKind) -> Iterator[Breach]:
    """A world is made for the hand's contacts, and its joints where it has any, at the rate of its kind."""
    with _made(kind) as (world, _):
        found = world.info
        joints = tuple(ROBOT.joints) if kind.has("hand") else ()
        if found.rate != kind.rate:
            yield f"info.rate is {found.rate}, the kind's {kind.rate}", "give both the same"
        if found.contacts != ROBOT.contacts:
            yield f"its contacts are {found.contacts}", "take settings.robot.contacts, in their order"
        if found.joints != joints:
            yield f"its joints are {found.joints}", "take those of settings.robot, or lack a hand"
        if not np.shape(found.lower) == np.shape(found.upper) == (len(found.joints),):
            yield "its limits are of another shape than its joints", "give lower and upper (n,)"
        elif not (found.lower <= found.upper).all():
            yield "a lower limit lies above the upper one", "give lower and upper in m or rad"


def observation(kind: WorldKind) -> Iterator[Breach]:
    """An observation has the promised shapes: finite, unit normals, flags, no force where nothing touches."""
    for probes in _ways(kind):
        with _made(kind, probes=probes) as (world, space):
            k, n = len(world.info.contacts), len(world.info.joints)
            shapes = {
                **dict.fromkeys(("points", "normals", "forces", "orientations"), (k, 3)),
                **dict.fromkeys(("jacobian", "angular_jacobian"), (k, 3, n)),
                **dict.fromkeys(("centre_of_mass", "weight"), (3,)),
                "touching": (k,),
                "joints": (n,),
            }
            for seen in _run(world, space):
                wrong = [name for name, shape in shapes.items() if np.shape(getattr(seen, name)) != shape]
                if wrong:
                    name = wrong[0]
                    yield (
                        f"{name} has the shape {np.shape(getattr(seen, name))}",
                        f"give {shapes[name]}: k contacts, n joints",
                    )
                    return
                known = set(shapes) - {"centre_of_mass", "weight"}
                if not all(np.isfinite(getattr(seen, name)).all() for name in known):
                    yield "what is sensed is not finite", "raise WorldCrashError for numbers that are none"
                elif seen.touching.dtype != bool:
                    yield f"touching is of {seen.touching.dtype}", "give flags"
                elif np.abs(np.linalg.norm(seen.normals, axis=1) - 1.0).max() > 1e-9:
                    yield "normals are no unit vectors", "divide them by their lengths"
                elif seen.forces[~seen.touching].any():
                    yield "a contact that does not touch feels a force", "let it be 0"
                else:
                    continue
                return


def truth(kind: WorldKind) -> Iterator[Breach]:
    """The truth has the promised shapes, a rotation and a unit axis."""
    with _made(kind) as (world, _):
        world.reset(START, SEED)
        found, k = world.truth(), len(world.info.contacts)
        shapes = {
            **dict.fromkeys(("points", "normals", "forces"), (k, 3)),
            **dict.fromkeys(("object_position", "object_axis"), (3,)),
            "object_rotation": (3, 3),
            "object_lean": (),
            "loads": (len(PARTIES), 6),
        }
        for name, shape in shapes.items():
            if np.shape(getattr(found, name)) != shape:
                yield f"{name} of the truth has the shape {np.shape(getattr(found, name))}", f"give {shape}"
                return
        if np.abs(found.object_rotation @ found.object_rotation.T - np.eye(3)).max() > 1e-6:
            yield "object_rotation is no rotation", "give the axes of the body's frame as columns"
        if abs(np.linalg.norm(found.object_axis) - 1.0) > 1e-6:
            yield "object_axis is no unit vector", "give the body's major_axis, in the world"
        for name in ("touching_links", "table_links", "stopped_joints"):
            if not isinstance(getattr(found, name), tuple):
                yield f"{name} is no tuple", "give names, or ()"


def time(kind: WorldKind) -> Iterator[Breach]:
    """A trial begins at 0 s, and a tick takes one over the rate."""
    for probes in _ways(kind):
        with _made(kind, probes=probes) as (world, space):
            times = [seen.time for seen in _run(world, space)]
            if times[0] != 0.0 or not np.allclose(np.diff(times), 1.0 / kind.rate):
                yield f"the times of its first ticks are {times} s", "count ticks from 0, divided by the rate"


def repeats(kind: WorldKind) -> Iterator[Breach]:
    """The same start, seed and commands give the same observations, to the last bit."""
    for probes in _ways(kind):
        with _made(kind, probes=probes) as (world, space):
            first, again = _run(world, space), _run(world, space)
            if not all(same(*pair) for pair in zip(first, again, strict=True)):
                yield "a trial does not repeat", "build it anew at a reset; draw from the seed and from nothing else"
            elif same(first[0], first[-1]):
                yield "nothing changes as it is commanded", "carry commands out"


def still(kind: WorldKind) -> Iterator[Breach]:
    """Told to keep still, it does."""
    with _made(kind) as (world, space):
        seen = world.reset(START, SEED)
        later = _stepped(world, _command(world, space, 0.0), SETTLED)
        gone = np.linalg.norm(later.points - seen.points, axis=1).max()
        if not gone <= STILL:
            yield f"told to keep still, a contact goes by {1000 * gone:.3g} mm", "let a command of zero move nothing"


def obeys(kind: WorldKind) -> Iterator[Breach]:
    """A small command is carried out once all has settled: of joints, or along the surface."""
    with _made(kind) as (world, space):
        seen = world.reset(START, SEED)
        command = _command(world, space, SMALL)
        if space == "x":  # what floats keeps to the surface
            across = (command.displacement * seen.normals).sum(axis=1, keepdims=True) * seen.normals
            command = replace(command, displacement=command.displacement - across)
        world.step(command)
        later = _stepped(world, _command(world, space, 0.0), SETTLED)
        moved = later.joints - seen.joints if space == "q" else later.points - seen.points
        left = np.linalg.norm(moved - command.displacement) / np.linalg.norm(command.displacement)
        if not left <= OBEYED:
            yield f"{left:.0%} of a small command in {space} is not carried out", "let displacements be in m or rad"


def jacobian(kind: WorldKind) -> Iterator[Breach]:
    """Contacts that do not touch move as the Jacobian says of how the joints moved."""
    with _made(kind) as (world, space):
        seen = world.reset(START, SEED)
        if space != "q":
            return
        for joint in range(len(world.info.joints)):
            step = np.zeros(len(world.info.joints))
            step[joint] = SMALL * (1 if seen.joints[joint] + SMALL < world.info.upper[joint] else -1)
            world.step(Command("q", step))
            later = _stepped(world, Command("q", 0.0 * step), SETTLED // 2)
            free = ~(seen.touching | later.touching)
            moved, turned = later.points - seen.points, later.joints - seen.joints
            said = 0.5 * (seen.jacobian + later.jacobian) @ turned
            if np.abs(moved - said)[free].max(initial=0.0) > MOVED * np.abs(moved)[free].max(initial=0.0) + 1e-5:
                yield f"contacts do not move as the Jacobian of {world.info.joints[joint]} says", "give ∂x/∂q (k, 3, n)"
                return
            seen = later


def refuses(kind: WorldKind) -> Iterator[Breach]:
    """A command in a space that it cannot carry out is refused with a ValueError."""
    for probes in _ways(kind):
        with _made(kind, probes=probes) as (world, space):
            world.reset(START, SEED)
            try:
                world.step(replace(_command(world, space, SMALL), space="no such space"))
            except ValueError:
                return
            yield "it takes a command in a space that there is not", "raise ValueError"


def agrees(kind: WorldKind) -> Iterator[Breach]:
    """Where a contact touches, its true point, normal and force are what an exact sensor senses, if there is one."""
    exact = "exact" in kind.senses
    with _made(kind, "exact" if exact else None) as (world, _):
        seen = world.reset(START, SEED)
        closes = np.array([CLOSING * joint.closes for joint in ROBOT.joints.values()])
        for _ in range(MOST_TICKS if world.info.joints else 0):
            if seen.touching.all():
                break
            seen = world.step(Command("q", closes))
        found = world.truth()
        touching = seen.touching & np.isfinite(found.points[:, 0])
        if not np.array_equal(touching, seen.touching):
            yield "what is felt to touch does not truly touch", "let truth and observation be of the same tick"
        elif not touching.any():
            yield "no contact ever touches", "let closing fingers touch the object"
        pairs = ((found.points, seen.points), (found.normals, seen.normals), (found.forces, seen.forces))
        for what, (true, felt) in zip(("points", "normals", "forces"), pairs if exact else pairs[:1], strict=False):
            if np.abs(true - felt)[touching].max(initial=0.0) > (AGREED if exact else SOFT):
                yield f"true {what} are not those that are sensed", "in the world; normals into, forces on the object"


def balance(kind: WorldKind) -> Iterator[Breach]:
    """What acts on the object is told whole or not at all; of a free one at rest it cancels."""
    with _made(kind) as (world, _):
        world.reset(START, SEED)
        loads = world.truth().loads
        if np.isnan(loads).all():
            return
        if not np.isfinite(loads).all():
            yield "it tells a part of what acts on the object", "give all of the loads, or NaN for all"
            return
        weight = BODY.mass * GRAVITY
        if np.abs(loads[PARTIES.index("gravity")] - [0.0, 0.0, -weight, 0.0, 0.0, 0.0]).max() > AGREED:
            yield f"gravity is not the weight of {weight:.3g} N", "in the world, z upwards; moments about its centre"
        if kind.has("motion") and np.abs(loads.sum(axis=0)).max() > CANCELLED * weight:
            yield "what acts on an object at rest does not cancel", "give the forces on the object, of every party"


def infeasible(kind: WorldKind) -> Iterator[Breach]:
    """A start with the hand in the table is refused with an InfeasibleStartError; others can be taken up after it."""
    with _made(kind) as (world, _):
        try:
            world.reset(WITHIN, SEED)
        except InfeasibleStartError:
            pass
        else:
            if kind.has("hand"):
                yield "it takes up a start in the table", "raise InfeasibleStartError"
        if world.reset(START, SEED).time != 0.0:
            yield "it takes up no start after one that it could not", "build the scene anew at each reset"


def closing(kind: WorldKind) -> Iterator[Breach]:
    """It can be closed twice, and reset again."""
    with _made(kind) as (world, _):
        first = world.reset(START, SEED)
        world.close()
        world.close()
        if not same(world.reset(START, SEED), first):
            yield "once closed it begins otherwise", "let close give back what reset takes"


def side_by_side(kind: WorldKind) -> Iterator[Breach]:
    """Trials side by side are each what it is alone, to the last bit, and stay so when others are over, and others
    join."""
    with _made(kind) as (world, space), _made(kind) as (other, _):
        if kind.together > 1 and not isinstance(world, ManyWorld):
            yield (
                f"it says that it runs {kind.together} trials at once",
                "write join, observe and keep, or together = 1",
            )
        if not isinstance(world, ManyWorld):
            return
        alone = [_run(other, space, SEED + trial) for trial in range(TRIALS)]
        for trial in range(TRIALS):
            world.join(START, SEED + trial)
        began = dict.fromkeys(range(TRIALS), 0)
        for tick in range(TICKS + 1):
            many = world.observe()
            if tick == TICKS - 1:
                del began[1]
                world.keep(np.array([0, 2]))
                many = world.observe()
            for row, (trial, first) in enumerate(began.items()):
                if not same(many.row(row), alone[trial][tick - first]):
                    yield f"trial {trial} of {len(began)} is not what it is alone", "keep the rows apart: (..., k, 3)"
                    return
            command = _command(world, space, SMALL, tick)
            shape = (len(began), *command.displacement.shape)
            if tick == TICKS - 1:
                world.join(START, SEED + 1)
                began[1] = TICKS
            world.step(replace(command, displacement=np.broadcast_to(command.displacement, shape)))


def studio(kind: WorldKind) -> Iterator[Breach]:
    """A stored row is shown: a picture of it, in which something can be seen."""
    settings = _settings(kind)
    with _made(kind) as (world, _):
        seen, found = world.reset(START, SEED), world.truth()
    row = {
        "points": seen.points,
        "joints": seen.joints,
        "object_position": found.object_position,
        "object_rotation": found.object_rotation,
    }
    shown = kind.studio(View(settings, START if kind.has("hand") else None, [0, 1], [0, 1]))
    try:
        shown.show(row)
        picture = shown.picture(shown.camera(64, 48))
    finally:
        shown.close()
    if picture.shape != (48, 64, 3) or picture.min() == picture.max():
        yield f"its picture is of {picture.shape}, or empty", "give (height, width, 3), 0 to 255"
    if shown.is_open:
        yield "its studio is open after it was closed", "mend is_open"


RULES = contract(
    declared,
    told,
    senses,
    info,
    observation,
    truth,
    time,
    repeats,
    still,
    obeys,
    jacobian,
    refuses,
    agrees,
    balance,
    infeasible,
    closing,
    side_by_side,
    studio,
    wording=(told,),
)


def same(one: Observation | Truth, other: Observation | Truth) -> bool:
    """Whether two observations, or two truths, agree to the last bit."""
    pairs = ((getattr(one, field.name), getattr(other, field.name)) for field in fields(one))
    return all(np.array_equal(np.asarray(a), np.asarray(b), equal_nan=_has_nan(a)) for a, b in pairs)


def _has_nan(value: object) -> bool:
    return np.asarray(value).dtype.kind == "f"


def _ways(kind: WorldKind) -> list[bool]:
    """Whether it probes, in the ways in which it displaces contacts."""
    return sorted({False, kind.probes("probing")})


def _settings(kind: WorldKind, sensor: str | None = None, *, probes: bool = False) -> WorldSettings:
    anchor = Anchor.NONE if kind.has("motion") else Anchor.WORLD
    return WorldSettings(ROBOT, BODY, 0.4, kind.sensor(sensor), anchor, probes)


@contextmanager
def _made(kind: WorldKind, sensor: str | None = None, *, probes: bool = False) -> Iterator[tuple[WitnessedWorld, str]]:
    """A world and a space that it carries out a tick at a time; closed at the end."""
    world = kind.make(_settings(kind, sensor, probes=probes))
    try:
        yield world, "q" if GradientSpace.JOINTS in kind.sliding else "x"
    finally:
        world.close()


def _command(world: WitnessedWorld | ManyWorld, space: str, size: float, seed: int = 0) -> Command:
    """A random command of a size [m or rad] in each coordinate."""
    shape = (len(world.info.contacts), 3) if space == "x" else (len(world.info.joints),)
    return Command(space, size * np.random.default_rng(seed).uniform(-1.0, 1.0, shape))


def _run(world: WitnessedWorld, space: str, seed: int = SEED) -> list[Observation]:
    """The first observations of a trial that is commanded at random."""
    return [world.reset(START, seed), *(world.step(_command(world, space, SMALL, tick)) for tick in range(TICKS))]


def _stepped(world: WitnessedWorld, command: Command, ticks: int) -> Observation:
    """What is seen after some ticks of the same command."""
    for _ in range(ticks):
        seen = world.step(command)
    return seen
