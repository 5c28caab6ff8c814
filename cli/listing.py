"""What there is to write with, of graspdsl and of other packages: potentials, hands, worlds and so on."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from graspdsl.cli.inputs import sound
from graspdsl.cli.messages import complain, result, result_json
from graspdsl.cli.tables import laid_out, text_of
from graspdsl.report.tables import Column, Table

if TYPE_CHECKING:
    from graspdsl.compiler.program import Program

Rows = list[dict[str, str]]
BEGINNING = 4096  # characters of a file in which it says what it is


def show_list(kind: str, as_json: bool, spec: Path | None = None, *, allow_code: bool = False) -> None:
    """Print the entries of one kind; of controllers also those that a spec has of its own.

    What other packages offer and cannot be used is told on stderr.
    """
    from graspdsl.plugins.adoption import adopted_all

    complain("graspdsl", "", adopted_all([{"sensing": "touch"}.get(kind, kind)]))
    entries = KINDS[kind]() if spec is None else _controllers(sound(spec, allow_code=allow_code))
    if as_json:
        result_json({kind: entries})
        return
    rows = tuple(tuple(entry.values()) for entry in entries)
    result(text_of([laid_out(Table(kind, tuple(map(Column, entries[0])), rows))]))


def _potentials() -> Rows:
    from graspdsl.basis.potentials import POTENTIALS

    return [
        {
            "name": potential.symbol,
            "from": _from("potentials", potential.symbol),
            "equation": potential.equation,
            "sensors": ", ".join(potential.sensors),
            "effectors": ", ".join(potential.effectors),
            "about": potential.about,
        }
        for potential in POTENTIALS.values()
    ]


def _sensors() -> Rows:
    from graspdsl.basis.sensors import SENSORS

    return [
        {
            "name": sensor.symbol,
            "from": _from("sensors", sensor.symbol),
            "equation": sensor.equation,
            "task space": sensor.space.about,
            "about": sensor.about,
        }
        for sensor in SENSORS.values()
    ]


def _effectors() -> Rows:
    from graspdsl.basis.effectors import EFFECTORS

    return [
        {
            "name": effector.symbol,
            "from": _from("effectors", effector.symbol),
            "equation": effector.equation,
            "moves": effector.gradient_space.value,
            "about": effector.about,
        }
        for effector in EFFECTORS.values()
    ]


def _controllers(program: Program | None = None) -> Rows:
    from graspdsl.basis.prelude import prelude
    from graspdsl.notation.printer import to_unicode
    from graspdsl.plugins.kinds import OF_OTHERS

    own = {} if program is None else program.definitions
    known = {**prelude(), **OF_OTHERS, **own}
    return [
        {
            "controller": to_unicode(definition.head),
            "from": definition.by or ("graspdsl" if program is None or definition.in_prelude else program.source.name),
            "equation": definition.equation,
            "stands for": to_unicode(definition.body) if definition.body else "",
            "use it": definition.about,
        }
        for definition in known.values()
    ]


def _from(kind: str, name: str) -> str:
    from graspdsl.plugins.kinds import brought_by

    return brought_by(kind, name)


def _named(kind: str, entries: Iterable[tuple[str, str]]) -> Rows:
    return [{"name": name, "from": _from(kind, name), "about": about} for name, about in entries]


def _hands() -> Rows:
    from graspdsl.hands.descriptions import hands

    return [*_named("hands", ((name, hand.about) for name, hand in hands().items())), *_files_of("hand")]


def _files_of(kind: str) -> Rows:
    """Hand or mount files in this folder and in the folder hands or mounts below it."""
    from graspdsl.cli.inputs import HAND_FILE, MOUNT_FILE
    from graspdsl.places.folders import SUFFIXES

    found: Rows = []
    for path in sorted([*Path().glob("*"), *Path(f"{kind}s").glob("*")]):
        if path.suffix in SUFFIXES and path.is_file():
            with path.open(encoding="utf-8", errors="replace") as file:
                if (HAND_FILE if kind == "hand" else MOUNT_FILE).match(file.read(BEGINNING)):
                    found.append({"name": str(path), "from": "this folder", "about": f"a {kind} file found here"})
    return found


def _objects() -> Rows:
    from graspdsl.objects.shapes import catalogue

    return [
        {
            "name": name,
            "from": _from("objects", name),
            "size (cm)": " × ".join(f"{100 * length:.3g}" for length in body.shape.extent),
            "mass (kg)": f"{body.mass:g}",
            "about": body.about,
        }
        for name, body in catalogue().items()
    ]


def _worlds() -> Rows:
    from graspdsl.worlds.kinds import WORLDS

    return _named("worlds", ((name, world.about) for name, world in WORLDS.items()))


def _mounts() -> Rows:
    from graspdsl.hands.descriptions import mounts

    return [*_named("mounts", ((name, mount.about) for name, mount in mounts().items())), *_files_of("mount")]


def _sensing() -> Rows:
    from graspdsl.worlds.touch.sensors import TACTILE_SENSORS

    return _named("touch", ((name, sensor.about) for name, sensor in TACTILE_SENSORS.items()))


def _grades() -> Rows:
    from graspdsl.quality.grades import GRADES

    return _named("grades", ((name, grade.about) for name, grade in GRADES.items()))


def _shapes() -> Rows:
    from graspdsl.objects.shapes import SHAPES

    return [
        {
            "name": name,
            "from": _from("shapes", name),
            "keys": ", ".join(field.alias or key for key, field in shape.model_fields.items()),
            "about": shape.about,
        }
        for name, shape in SHAPES.items()
    ]


def _monitors() -> Rows:
    from graspdsl.spec.monitors import MONITORS

    return [
        {
            "name": name,
            "from": _from("monitors", name),
            "outcome": monitor.outcome.value,
            "about": monitor.description,
        }
        for name, monitor in MONITORS.items()
    ]


KINDS: Mapping[str, Callable[[], Rows]] = {
    "potentials": _potentials,
    "sensors": _sensors,
    "effectors": _effectors,
    "controllers": _controllers,
    "hands": _hands,
    "mounts": _mounts,
    "sensing": _sensing,
    "objects": _objects,
    "shapes": _shapes,
    "worlds": _worlds,
    "grades": _grades,
    "monitors": _monitors,
}
