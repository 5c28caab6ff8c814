"""Do the parts of a scene go together: shapes, hands, sensing and starts that a world has."""

from __future__ import annotations

from graspdsl.compiler.complaints import Complaints
from graspdsl.compiler.declarations import Declarations
from graspdsl.diagnostics import known_names_hint, listed
from graspdsl.hands.descriptions import Robot, hands, joint_limits
from graspdsl.objects.shapes import catalogue
from graspdsl.quality.grade import Grade
from graspdsl.quality.grades import GRADES
from graspdsl.spec.constructing import Path
from graspdsl.spec.distributions import numbers_of
from graspdsl.spec.document import Document
from graspdsl.spec.models import Spec
from graspdsl.spec.validation import unknown_value
from graspdsl.worlds.kinds import WORLDS, WorldKind

HAND_STARTS = ("roll", "height", "standoff", "yaw", "offset", "tilt", "posture")
EDGED = ("box", "compound", "mesh", "urdf")
FELT_BY_HANDS = {"load-cell": "load cells", "skin": "skin", "proximity": "proximity sensors"}


def check_scene(document: Document, complaints: Complaints) -> None:
    """Complain about grades that there are not, and about what the scene's world has not."""
    for place, grade in _asked_grades(document):
        if grade not in GRADES:
            path: Path = ("evaluate", place)
            complaints.about(path)
            message, hint = unknown_value(list(GRADES), grade)
            complaints.error("unknown-value", message, document.span(path), hint)
    name = _value(document, ("scene", "world"))
    world = WORLDS.get(name) if isinstance(name, str) else None
    if world is None:
        return
    _Check(document, complaints, world).all()


def check_start_posture(spec: Spec, robot: Robot, document: Document, complaints: Complaints) -> None:
    """Complain about a start posture of joints that the hand has not, or beyond their limits."""
    limits = dict(zip(robot.joints, zip(*joint_limits(robot), strict=True), strict=True)) if robot.hand.urdf else {}
    for name, place in spec.trials.start.posture.items():
        path: Path = ("trials", "start", "posture", name)
        complaints.about(path)
        if name not in robot.hand.joints:
            message = f"the hand {robot.hand.hand} has no actuated joint {name!r}"
            hint = known_names_hint(name, robot.hand.joints, "joints")
            complaints.error("unknown-joint", message, document.key_span(path), hint)
            continue
        low, high = limits[name]
        beyond = [number for number in numbers_of(place) if not low <= number <= high]
        if beyond:
            message = f"{name} moves from {low:g} to {high:g}, found {beyond[0]:g}"
            complaints.error("out-of-range", message, document.span(path), "keep within the limits of the joint")


def hand_for_floating(scene: Declarations) -> str | None:
    """The hint for a scene of floating contacts that names no hand: which hands are bare contacts; else None."""
    world = WORLDS.get(scene.world.text)
    if scene.names_hand or world is None or not world.floats:
        return None
    bare = {name: list(hand.contacts) for name, hand in hands().items() if not hand.urdf}
    ways = listed((f"'hand: {name}' with {known[0]} to {known[-1]}" for name, known in bare.items()), "or")
    return f"the scene names no hand, which means {scene.hand.text}; for bare contacts add {ways}"


class _Check:
    def __init__(self, document: Document, complaints: Complaints, world: WorldKind) -> None:
        self._document, self._complaints, self._world = document, complaints, world

    def all(self) -> None:
        self._without_effect()
        self._shape()
        self._hand()
        self._evaluation()
        self._centre_of_mass()
        self._sensing()
        approach: Path = ("trials", "start", "approach")
        chosen = _value(self._document, approach)
        if chosen is not None and (chosen == "surface") != self._world.floats:
            hint = "write approach: surface, or leave it out" if self._world.floats else "use side or top"
            self._error("start-not-in-world", f"the {self._world.name} world has no start {chosen!r}", approach, hint)

    def _without_effect(self) -> None:
        """Warn of settings that the scene passes over."""
        start: Path = ("trials", "start")
        given = _value(self._document, start)
        names = given if isinstance(given, dict) else {}
        idle = HAND_STARTS if self._world.floats else ("height",) if names.get("approach") == "top" else ()
        for name in idle:
            if name in names:
                where = "floating contacts have no hand" if self._world.floats else "a hand from above has no height"
                self._warn(f"{name} has no effect: {where}", (*start, name))
        grid: Path = ("trials", "grid")
        axes = _value(self._document, grid)
        for place, axis in enumerate(axes if isinstance(axes, list) else []):
            mapped = axis.get("parameter") if isinstance(axis, dict) else None
            if mapped in idle:
                where = "floating contacts have no hand" if self._world.floats else "a hand from above has no height"
                self._warn(f"the grid's {mapped} has no effect: {where}", (*grid, place, "parameter"))
        friction: Path = ("scene", "friction")
        judged = any(grade.by_friction for _, grade in self._grades())
        if self._world.floats and _value(self._document, friction) is not None and not judged:
            self._warn("friction has no effect: floating contacts have none, and none is judged by it", friction)

    def _warn(self, message: str, path: Path) -> None:
        self._complaints.about(path)
        self._complaints.warning("no-effect", message, self._document.key_span(path), "leave it out")

    def _shape(self) -> None:
        thing = _value(self._document, ("scene", "object"))
        path: Path = ("scene", "object")
        if isinstance(thing, dict) and "like" in thing:
            thing, path = thing["like"], (*path, "like")
        if isinstance(thing, dict):
            kinds = [kind for kind in EDGED if kind in thing]
        else:
            body = catalogue().get(str(thing))
            kinds = [type(body.shape).__name__.lower()] if body else []
        for kind in kinds:
            if self._world.floats and kind in EDGED:
                message = f"contacts cannot float on a {kind}: its edges have no normal"
                self._error("shape-not-in-world", message, path, "use a superquadric of exponent 8")

    def _hand(self) -> None:
        path: Path = ("scene", "hand")
        hand = hands().get(str(_value(self._document, path) or "barrett"))
        if hand is not None and not hand.urdf and not self._world.floats:
            message = f"the hand {hand.hand} is bare contacts without a model"
            self._error("hand-not-in-world", message, path, "use it in the floating world, or another hand here")

    def _sensing(self) -> None:
        path: Path = ("scene", "sensing")
        chosen = _value(self._document, path)
        names = [chosen] if isinstance(chosen, str) else list(chosen) if isinstance(chosen, dict) else []
        for name, felt in FELT_BY_HANDS.items():
            if self._world.floats and name in names:
                self._error("not-sensed", f"floating contacts have no {felt}", path, "use exact, or leave it out")

    def _grades(self) -> list[tuple[int, Grade]]:
        """The known grades under ``evaluate``, each with its place there."""
        return [(place, GRADES[name]) for place, name in _asked_grades(self._document) if name in GRADES]

    def _evaluation(self) -> None:
        """A hand lifts and shakes an object that is free."""
        thing = _value(self._document, ("scene", "object"))
        anchors = [name for name in ("held", "fixed") if isinstance(thing, dict) and thing.get(name) is True]
        if self._world.floats:
            why = "floating contacts have no hand and their object no weight"
        elif anchors:
            why = f"the object is {anchors[0]}"
        else:
            return
        for place, grade in self._grades():
            if grade.handles:
                hint = "leave it out, or use a free object in the bullet world"
                self._error("grade-not-in-world", f"{grade.name} says nothing here: {why}", ("evaluate", place), hint)

    def _centre_of_mass(self) -> None:
        """It is known of an object that is held or that contacts float on."""
        held: Path = ("scene", "object", "held")
        if self._world.floats and _value(self._document, held) is True:
            message = "an object that contacts float on stays put: nothing holds it"
            self._error("held-not-in-world", message, held, "leave it out")
        origin: Path = ("control", "origin")
        known = self._world.floats or _value(self._document, held) is True
        if _value(self._document, origin) == "object" and not known:
            message = "moments cannot be taken about the object: its centre of mass is known only when it is held"
            self._error("origin-not-sensed", message, origin, "use centroid, or add 'held: true' to the object")

    def _error(self, code: str, message: str, path: Path, hint: str) -> None:
        self._complaints.about(path)
        self._complaints.error(code, message, self._document.span(path), hint)


def _asked_grades(document: Document) -> list[tuple[int, str]]:
    """The words under ``evaluate``, each with its place there."""
    given = _value(document, ("evaluate",))
    return [
        (place, name) for place, name in enumerate(given if isinstance(given, list) else []) if isinstance(name, str)
    ]


def _value(document: Document, path: Path) -> object:
    try:
        return document.get(path)
    except KeyError:
        return None
