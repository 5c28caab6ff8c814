"""The kinds of things there are to write with, each as rows of a table: one source for the pages and the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from graspdsl.basis.effectors import EFFECTORS
from graspdsl.basis.potentials import POTENTIALS
from graspdsl.basis.prelude import Definition, prelude
from graspdsl.basis.sensors import SENSORS
from graspdsl.basis.spaces import GradientSpace
from graspdsl.hands.descriptions import Hand, Joint, Mount, Robot, hands, joint_limits, joint_units, mounts
from graspdsl.notation.printer import to_ascii, to_unicode
from graspdsl.objects.shapes import SHAPES, catalogue
from graspdsl.plugins.kinds import OF_OTHERS, brought_by
from graspdsl.reference.keys import Key, parts
from graspdsl.spec.monitors import MONITORS, OUTCOMES
from graspdsl.spec.shipped import shipped_specs
from graspdsl.worlds.kinds import WORLDS
from graspdsl.worlds.touch.sensors import TACTILE_SENSORS

Row = dict[str, str]
Rows = list[Row]


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of things: a line on it, its rows, all with the same columns, and which of these a terminal leaves out."""

    about: str
    rows: Callable[[], Rows]
    wide: tuple[str, ...] = ()


def _named(kind: str, name: str, **more: str) -> Row:
    return {"name": name, "from": brought_by(kind, name), **more}


def _keys() -> Rows:
    return [
        {
            "key": f"{part.place}.{key.name}".lstrip("."),
            "type": key.type,
            "unit": key.unit,
            "default": key.default,
            "values": ", ".join(key.values),
            "about": key.about,
        }
        for part in parts()
        for key in part.keys
    ]


def _of(place: str) -> dict[str, Key]:
    """The keys of a part of a spec."""
    return {key.name: key for part in parts() if part.place == place for key in part.keys}


def _potentials() -> Rows:
    return [
        _named(
            "potentials",
            potential.symbol,
            **{
                "equation": potential.equation,
                "task space": potential.space.about,
                "sensors": ", ".join(potential.sensors),
                "effectors": ", ".join(potential.effectors),
                "references": ", ".join(potential.references),
                "about": potential.about,
            },
        )
        for potential in POTENTIALS.values()
    ]


def _sensors() -> Rows:
    return [
        _named(
            "sensors",
            sensor.symbol,
            **{"equation": sensor.equation, "task space": sensor.space.about, "about": sensor.about},
        )
        for sensor in SENSORS.values()
    ]


def _effectors() -> Rows:
    return [
        _named(
            "effectors",
            effector.symbol,
            equation=effector.equation,
            moves=effector.gradient_space.value,
            about=effector.about,
        )
        for effector in EFFECTORS.values()
    ]


def _spaces() -> Rows:
    return [
        {
            "name": space.value,
            "effectors": ", ".join(name for name, effector in EFFECTORS.items() if effector.gradient_space is space),
            "about": space.about,
        }
        for space in GradientSpace
    ]


def controllers(own: Mapping[str, Definition] | None = None, source: str = "") -> Rows:
    """The prelude's controllers and those of packages; with those of a spec's ``own``, whose name is ``source``."""
    return [
        {
            "controller": to_unicode(definition.head),
            "from": definition.by or ("graspdsl" if own is None or definition.in_prelude else source),
            "equation": definition.equation,
            "stands for": to_unicode(definition.body) if definition.body else "",
            "in ASCII": to_ascii(definition.body) if definition.body else "",
            "use it": definition.about,
        }
        for definition in {**prelude(), **OF_OTHERS, **(own or {})}.values()
    ]


def _joints(robot: Robot, joints: Mapping[str, Joint]) -> str:
    """Joints with the ranges in which they move."""
    limits = dict(zip(robot.joints, zip(*joint_limits(robot), strict=True), strict=True))
    units = joint_units(robot)
    return ", ".join(f"{name} ({limits[name][0]:.3g} to {limits[name][1]:.3g} {units[name]})" for name in joints)


def _sets(sets: Mapping[str, Iterable[str]]) -> str:
    return "; ".join(f"{name}: {', '.join(joints)}" for name, joints in sets.items())


def hand_row(name: str, hand: Hand, by: str) -> Row:
    """What formulas and specs may name of a hand: its contacts, joints and joint sets."""
    robot = Robot(hand=hand, mount=next(iter(mounts().values())))
    return {
        "name": name,
        "from": by,
        "contacts": ", ".join(hand.contacts),
        "joint sets": ", ".join(hand.joint_sets),
        "joints": _joints(robot, hand.joints) if robot.has_model else "",
        "sets of joints": _sets(hand.joint_sets),
        "about": hand.about,
    }


def mount_row(name: str, mount: Mount, by: str) -> Row:
    """What formulas and specs may name of a mount: its joints and joint sets."""
    hand = next(hand for hand in hands().values() if hand.urdf)
    return {
        "name": name,
        "from": by,
        "joint sets": ", ".join(mount.joint_sets),
        "joints": _joints(Robot(hand=hand, mount=mount), mount.joints),
        "sets of joints": _sets(mount.joint_sets),
        "holds": mount.holds,
        "about": mount.about,
    }


def _objects() -> Rows:
    return [
        _named(
            "objects",
            name,
            **{
                "size (cm)": " × ".join(f"{100 * length:.3g}" for length in body.shape.extent),
                "mass (kg)": f"{body.mass:g}",
                "worlds": _worlds_of(edged=body.shape.edged),
                "about": body.about,
            },
        )
        for name, body in catalogue().items()
    ]


def _worlds_of(*, edged: bool) -> str:
    """The worlds that take an object."""
    return ", ".join(name for name, world in WORLDS.items() if world.has("edges") or not edged)


def _shapes() -> Rows:
    return [
        _named(
            "shapes",
            name,
            keys=", ".join(field.alias or key for key, field in shape.model_fields.items()),
            worlds=_worlds_of(edged=shape.edged),
            about=shape.about,
        )
        for name, shape in SHAPES.items()
    ]


def _worlds() -> Rows:
    return [
        _named(
            "worlds",
            name,
            **{
                "ticks (Hz)": f"{world.rate:g}",
                "sliding": _letters(world.sliding),
                "probing": _letters(world.probing),
                "touch": ", ".join(world.senses),
                "approaches": ", ".join(world.approaches),
                "lacks": "; ".join(f"{ability}: {why}" for ability, why in world.lacks.items()),
                "about": world.about,
            },
        )
        for name, world in WORLDS.items()
    ]


def _letters(spaces: Iterable[GradientSpace]) -> str:
    return ", ".join(space.value for space in GradientSpace if space in spaces)


def _touch() -> Rows:
    return [
        _named(
            "touch",
            name,
            worlds=", ".join(world for world, kind in WORLDS.items() if name in kind.senses),
            keys=", ".join(field.alias or key for key, field in sensor.model.model_fields.items()),
            about=sensor.about,
        )
        for name, sensor in TACTILE_SENSORS.items()
    ]


def _grades() -> Rows:
    from graspdsl.quality.grades import GRADES

    return [
        _named("grades", name, about=grade.about, definition=" ".join(grade.definition.split()))
        for name, grade in GRADES.items()
    ]


def _specs() -> Rows:
    return [{"name": spec.name, "equation": spec.equation, "about": spec.about} for spec in shipped_specs().values()]


def _monitors() -> Rows:
    keys = _of("monitors")
    return [
        _named(
            "monitors",
            name,
            outcome=monitor.outcome.value,
            default=keys[name].default,
            unit=keys[name].unit,
            about=monitor.description,
        )
        for name, monitor in MONITORS.items()
    ]


def _outcomes() -> Rows:
    return [
        {
            "name": name,
            "monitor": ", ".join(key for key, monitor in MONITORS.items() if monitor.outcome is outcome),
            "about": outcome.means,
        }
        for name, outcome in OUTCOMES.items()
    ]


def _approaches() -> Rows:
    return [
        {"name": name, "worlds": ", ".join(w for w, kind in WORLDS.items() if name in kind.approaches), "about": line}
        for name, line in _of("trials.start")["approach"].values.items()
    ]


def _starts() -> Rows:
    return [
        {"key": name, "unit": key.unit, "default": key.default, "about": key.about}
        for name, key in _of("trials.start").items()
    ]


def _conditions() -> Rows:
    return [
        {"key": name, "unit": key.unit, "default": key.default, "about": key.about}
        for name, key in _of("program.until").items()
    ]


def _grammar() -> Rows:
    from graspdsl.reference import grammar

    return [{"rule": rule.name, "is": rule.ebnf, "about": rule.about} for rule in grammar.rules()]


def _diagnostics() -> Rows:
    from graspdsl.reference import diagnostics

    shown = [
        {
            "code": example.code,
            "severity": example.severity.value,
            "means": example.means,
            "about": example.section,
            "in": diagnostics.FORMS[example.form],
            "wrong": example.wrong,
            "right": example.right,
        }
        for example in diagnostics.examples().values()
    ]
    nothing = {"in": "", "wrong": "", "right": ""}
    rules = [
        {"code": code, "severity": "", "means": law, "about": "Contracts", **nothing}
        for code, law in diagnostics.rules().items()
    ]
    return [*shown, *rules]


KINDS: Mapping[str, Kind] = {
    "keys": Kind("every key of a spec, with type, unit, default and values", _keys),
    "controllers": Kind("abbreviations π: the prelude's, those of packages and of a SPEC", controllers, ("in ASCII",)),
    "potentials": Kind("potential functions φ: what a controller lowers", _potentials, ("references",)),
    "sensors": Kind("sensor transforms σ: from what is sensed to a task space", _sensors),
    "effectors": Kind("effector transforms τ: how what is sensed changes with what is moved", _effectors),
    "spaces": Kind("gradient spaces: what a controller moves", _spaces),
    "hands": Kind(
        "hands, with the contacts and joint sets that resources may name",
        lambda: [hand_row(name, hand, brought_by("hands", name)) for name, hand in hands().items()],
        ("joints", "sets of joints"),
    ),
    "mounts": Kind(
        "what carries a hand, with its joint sets",
        lambda: [mount_row(name, mount, brought_by("mounts", name)) for name, mount in mounts().items()],
        ("joints", "sets of joints"),
    ),
    "objects": Kind("objects of the catalogue", _objects),
    "shapes": Kind("shapes of objects that a spec describes", _shapes),
    "worlds": Kind("what trials run in, and what each lacks", _worlds, ("lacks",)),
    "sensing": Kind("tactile sensors, under scene.sensing", _touch, ("keys",)),
    "approaches": Kind("where the hand comes from, under trials.start.approach", _approaches),
    "starts": Kind("the numbers of a start, under trials.start", _starts),
    "conditions": Kind("end conditions of a phase, under until", _conditions),
    "monitors": Kind("what ends a trial that went wrong, under monitors", _monitors),
    "outcomes": Kind("how a trial can end", _outcomes),
    "grades": Kind("how final grasps are judged, under evaluate", _grades, ("definition",)),
    "specs": Kind("specs that ship, to begin from: graspdsl init --from NAME", _specs),
    "grammar": Kind("the rules of formulas, in EBNF", _grammar),
    "diagnostics": Kind(
        "every complaint by its code; 'graspdsl explain CODE' has its examples", _diagnostics, ("in", "wrong", "right")
    ),
}
OTHER_NAMES = {"touch": "sensing"}
