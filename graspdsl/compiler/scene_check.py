"""Do the parts of a scene go together: shapes, hands, sensing and starts that a world has."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graspdsl.compiler.complaints import Complaints
from graspdsl.compiler.declarations import Declarations
from graspdsl.diagnostics import listed
from graspdsl.hands.descriptions import Robot, hands
from graspdsl.objects.object_files import FILES
from graspdsl.objects.shapes import SHAPES, catalogue
from graspdsl.places.document import Document, Path
from graspdsl.spec.models import Spec
from graspdsl.spec.scene import InlineObject
from graspdsl.spec.sensing import Sensing
from graspdsl.worlds.kind import WorldKind
from graspdsl.worlds.kinds import WORLDS, worlds_with, worlds_without
from graspdsl.worlds.touch.sensors import TACTILE_SENSORS, sensor_for

if TYPE_CHECKING:
    from graspdsl.quality.grade import Grade

HAND_STARTS = ("roll", "height", "standoff", "yaw", "offset", "tilt", "posture")
START: Path = ("trials", "start")
PHYSICS: Path = ("scene", "physics")
DEVIATIONS = 4.0  # of the noise of a reading that a touch should begin above


def check_scene(spec: Spec, document: Document, complaints: Complaints) -> None:
    """Complain about what the scene's world has not, as far as a spec was read."""
    world = WORLDS.get(spec.scene.world)
    if world is not None:
        _Check(spec, document, complaints, world).all()


def check_sensing(spec: Spec, document: Document, robot: Robot, complaints: Complaints) -> None:
    """Complain about load cells that the hand has not; warn of a touch that noise alone would begin."""
    world = WORLDS[spec.scene.world]
    if not world.has("forces"):
        return
    sensor = world.sensor(spec.scene.sensing)
    path: Path = ("scene", "hand" if spec.scene.sensing is None else "sensing")
    without = [name for name, contact in robot.hand.contacts.items() if contact.link and not contact.cell]
    if sensor_for(sensor).needs_cells and without:
        message = (
            f"{listed(without)} of the hand {robot.hand.hand} {'have' if len(without) > 1 else 'has'} no load cell"
        )
        complaints.about(path)
        others = [name for name in world.senses if not TACTILE_SENSORS[name].needs_cells]
        hint = f"use sensing: {listed(others, 'or')}, or name the load cell's joint in the hand file"
        complaints.error("not-sensed", message, document.span(path), hint)
    noise = sensor.force_noise_at(world.rate)
    if isinstance(spec.scene.sensing, Sensing) and sensor.touch.begins < DEVIATIONS * noise:
        complaints.about(path)
        message = (
            f"a touch begins at {sensor.touch.begins:g} N, but the force of a reading has {noise:.2g} N of noise: "
            "fingers will feel touches that are none"
        )
        hint = f"let it begin above {DEVIATIONS * noise:.2g} N: 'touch: {{begins: …, ends: …}}', or lower the noise"
        complaints.warning("threshold-in-noise", message, document.span(path), hint)


def check_mount(spec: Spec, document: Document, robot: Robot, complaints: Complaints) -> None:
    """Complain about an object that a mount which holds objects does not hold."""
    thing = spec.scene.object
    if (
        robot.mount.holds
        and WORLDS[spec.scene.world].has("hand")
        and not (isinstance(thing, InlineObject) and thing.fixed)
    ):
        path: Path = ("scene", "object")
        complaints.about(path)
        message = f"another hand of the mount {robot.mount.mount} holds the object, which is not fixed here"
        hint = "fix it to that hand: object: {like: ball, fixed: true}"
        complaints.error("not-held", message, document.span(path), hint)


def hand_for_floating(scene: Declarations) -> str | None:
    """The hint for a scene of floating contacts that names no hand: which hands are bare contacts; else None."""
    world = WORLDS.get(scene.world or "")
    if scene.names_hand or scene.hand is None or world is None or world.has("hand"):
        return None
    bare = {name: list(hand.contacts) for name, hand in hands().items() if not hand.urdf}
    ways = listed((f"'hand: {name}' with {known[0]} to {known[-1]}" for name, known in bare.items()), "or")
    return f"the scene names no hand, which means {scene.hand.text}; for bare contacts add {ways}"


class _Check:
    def __init__(self, spec: Spec, document: Document, complaints: Complaints, world: WorldKind) -> None:
        self._spec, self._document, self._complaints, self._world = spec, document, complaints, world
        thing = spec.scene.object
        self._thing = thing if isinstance(thing, InlineObject) else None

    def all(self) -> None:
        self._without_effect()
        self._time_step()
        self._shape()
        self._hand()
        self._evaluation()
        self._grading()
        self._centre_of_mass()
        self._sensing()
        chosen = self._spec.trials.start.approach
        elsewhere = any(chosen in kind.approaches for kind in WORLDS.values())
        if elsewhere and chosen not in self._world.approaches:
            ways = listed(self._world.approaches, "or")
            hint = f"use {ways}" if len(self._world.approaches) > 1 else f"write approach: {ways}, or leave it out"
            message = f"the {self._world.name} world has no start {chosen!r}"
            self._error("start-not-in-world", message, (*START, "approach"), hint)

    def _time_step(self) -> None:
        """A tick is a whole number of steps of physics."""
        world, effort = self._world, self._world.effort_in(self._spec.scene.physics)
        if effort is None or effort.divides(world.rate):
            return
        message = f"a tick of the {world.name} world, {1.0 / world.rate:g} s, is no whole number of these steps"
        near = 1.0 / (world.rate * max(1, effort.steps(world.rate)))
        self._error("time-step-not-in-tick", message, (*PHYSICS, "time_step"), f"use {near:.5g}")

    def _without_effect(self) -> None:
        """Warn of settings that the scene passes over."""
        trials, handless = self._spec.trials, self._world.lacks.get("hand")
        idle = HAND_STARTS if handless else ("height",) if trials.start.approach == "top" else ()
        where = handless or "a hand from above has no height"
        for name in idle:
            if self._document.has((*START, name)):
                self._warn(f"{name} has no effect: {where}", (*START, name))
        for place, axis in enumerate(trials.grid or ()):
            if axis.parameter in idle:
                path: Path = ("trials", "grid", place, "parameter")
                self._warn(f"the grid's {axis.parameter} has no effect: {where}", path)
        gravity: Path = ("scene", "gravity")
        if (weightless := self._world.lacks.get("weight")) and self._document.has(gravity):
            self._warn(f"gravity has no effect: {weightless}", gravity)
        if self._world.effort is None and self._document.has(PHYSICS):
            self._warn(f"physics has no effect: the {self._world.name} world has no physics to be chosen", PHYSICS)
        friction: Path = ("scene", "friction")
        why = self._world.lacks.get("friction")
        rubs = self._spec.grading.contact != "frictionless"
        judged = rubs and any(grade.by_friction for _, grade in self._grades())
        if why and self._document.has(friction) and not judged:
            self._warn(f"friction has no effect: {why}, and none is judged by it", friction)

    def _warn(self, message: str, path: Path) -> None:
        self._complaints.about(path)
        self._complaints.warning("no-effect", message, self._document.key_span(path), "leave it out")

    def _shape(self) -> None:
        thing = self._spec.scene.object
        path: Path = ("scene", "object")
        edged = (*(name for name, kind in SHAPES.items() if kind.edged), *FILES)
        kinds = [kind for kind in edged if self._document.has((*path, kind))]
        if self._thing is not None and self._document.has((*path, "like")):
            thing, path = self._thing.like or "", (*path, "like")
        if isinstance(thing, str):
            body = catalogue().get(thing)
            kinds = [body.shape.name] if body and body.shape.edged else []
        for kind in kinds:
            if why := self._world.lacks.get("edges"):
                message = f"{why} on a {kind}: its edges have no normal"
                self._error("shape-not-in-world", message, path, "use a superquadric of exponent 8")

    def _hand(self) -> None:
        hand = hands().get(self._spec.scene.hand)
        if hand is not None and not hand.urdf and self._world.has("hand"):
            message = f"the hand {hand.hand} is bare contacts without a model"
            hint = f"use it in {worlds_without('hand')}, or another hand here"
            self._error("hand-not-in-world", message, ("scene", "hand"), hint)

    def _sensing(self) -> None:
        path: Path = ("scene", "sensing")
        for name, sensor in TACTILE_SENSORS.items():
            chosen = self._spec.scene.sensing == name or self._document.has((*path, name))
            if chosen and name not in self._world.senses:
                message = f"{self._world.contacts} have no {sensor.called}"
                self._error("not-sensed", message, path, f"use {listed(self._world.senses, 'or')}, or leave it out")

    def _grades(self) -> list[tuple[int, Grade]]:
        """The known grades under ``evaluate``, each with its place there."""
        if not self._spec.evaluate:
            return []
        from graspdsl.quality.grades import GRADES

        return [(place, GRADES[name]) for place, name in enumerate(self._spec.evaluate) if name in GRADES]

    def _evaluation(self) -> None:
        """A hand lifts and shakes an object that is free."""
        thing, other = self._thing, f"use a free object in {worlds_with('lifting')}"
        if "lifting" in self._world.lacks:
            why = self._world.lacks["lifting"]
        elif thing is not None and (thing.held or thing.fixed):
            why = f"the object is {'held' if thing.held else 'fixed'}"
        elif self._spec.scene.gravity == 0.0:
            why, other = "without gravity there is no weight to lift", "let the scene have gravity"
        else:
            return
        for place, grade in self._grades():
            if grade.handles:
                message = f"{grade.name} says nothing here: {why}"
                self._error("grade-not-in-world", message, ("evaluate", place), f"leave it out, or {other}")

    def _grading(self) -> None:
        """Warn of conventions that no grade judges by, or that the contact model has no use for."""
        if self._document.has(("grading",)) and all(grade.handles for _, grade in self._grades()):
            self._warn("grading has no effect: no grade under 'evaluate' judges by it", ("grading",))
            return
        contact = self._spec.grading.contact
        cones = any(grade.by_friction for _, grade in self._grades())
        idle = {
            "torsion": contact in ("hard", "frictionless") and f"{contact} contacts resist no turning",
            "edges": (contact == "frictionless" and "frictionless contacts have no friction cone")
            or (not cones and "no grade under 'evaluate' judges by friction cones"),
        }
        for name, why in idle.items():
            if why and self._document.has(("grading", name)):
                self._warn(f"{name} has no effect: {why}", ("grading", name))

    def _centre_of_mass(self) -> None:
        """It is known of an object that is held or that contacts float on."""
        thing = self._spec.scene.object
        held = self._thing is not None and self._thing.held
        message = self._world.lacks.get("holding")
        if message and held:
            self._error("held-not-in-world", message, ("scene", "object", "held"), "leave it out")
        known = self._world.knows_object or held or thing is None
        if self._spec.control.origin == "object" and not known:
            message = "moments cannot be taken about the object: its centre of mass is known only when it is held"
            hint = "use centroid, or add 'held: true' to the object"
            self._error("origin-not-sensed", message, ("control", "origin"), hint)

    def _error(self, code: str, message: str, path: Path, hint: str) -> None:
        self._complaints.about(path)
        self._complaints.error(code, message, self._document.span(path), hint)
