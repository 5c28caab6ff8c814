"""What there is to write with: potentials, transforms, controllers, hands, mounts, sensing, objects, worlds, grades."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from graspdsl.cli.inputs import sound
from graspdsl.cli.messages import result, result_json
from graspdsl.cli.tables import laid_out, text_of
from graspdsl.report.tables import Column, Table

Rows = list[dict[str, str]]
BEGINNING = 4096  # characters of a file in which it says what it is


def show_list(kind: str, as_json: bool, spec: Path | None = None) -> None:
    """Print the entries of one kind; of controllers also those that a spec has of its own."""
    entries = KINDS[kind]() if spec is None else _controllers(spec)
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
        {"name": sensor.symbol, "equation": sensor.equation, "task space": sensor.space.about, "about": sensor.about}
        for sensor in SENSORS.values()
    ]


def _effectors() -> Rows:
    from graspdsl.basis.effectors import EFFECTORS

    return [
        {
            "name": effector.symbol,
            "equation": effector.equation,
            "moves": effector.gradient_space.value,
            "about": effector.about,
        }
        for effector in EFFECTORS.values()
    ]


def _controllers(spec: Path | None = None) -> Rows:
    from graspdsl.compiler.definitions import prelude
    from graspdsl.notation.printer import to_unicode

    known = prelude() if spec is None else sound(spec).definitions
    return [
        {
            "controller": to_unicode(definition.head),
            "equation": definition.equation,
            "stands for": to_unicode(definition.body) if definition.body else "",
            "use it": definition.about,
        }
        for definition in known.values()
    ]


def _named(entries: Iterable[tuple[str, str]]) -> Rows:
    return [{"name": name, "about": about} for name, about in entries]


def _hands() -> Rows:
    from graspdsl.hands.descriptions import hands

    found = [(str(path), "a hand file found here") for path in _hand_files()]
    return _named([*((name, hand.about) for name, hand in hands().items()), *found])


def _hand_files() -> list[Path]:
    """Hand files in this folder and in the folder hands below it."""
    from graspdsl.cli.inputs import HAND_FILE
    from graspdsl.hands.hand_files import SUFFIXES

    found = []
    for path in sorted([*Path().glob("*"), *Path("hands").glob("*")]):
        if path.suffix in SUFFIXES and path.is_file():
            with path.open(encoding="utf-8", errors="replace") as file:
                if HAND_FILE.match(file.read(BEGINNING)):
                    found.append(path)
    return found


def _objects() -> Rows:
    from graspdsl.objects.shapes import catalogue

    return [
        {
            "name": name,
            "size (cm)": " × ".join(f"{100 * length:.3g}" for length in body.shape.extent),
            "mass (kg)": f"{body.mass:g}",
            "about": body.about,
        }
        for name, body in catalogue().items()
    ]


def _worlds() -> Rows:
    from graspdsl.worlds.kinds import WORLDS

    return _named((name, world.about) for name, world in WORLDS.items())


def _mounts() -> Rows:
    from graspdsl.hands.descriptions import mounts

    return _named((name, mount.about) for name, mount in mounts().items())


def _sensing() -> Rows:
    from graspdsl.worlds.touch.sensors import TACTILE_SENSORS

    return _named((name, sensor.about) for name, sensor in TACTILE_SENSORS.items())


def _grades() -> Rows:
    from graspdsl.quality.grades import GRADES

    return _named((name, grade.about) for name, grade in GRADES.items())


KINDS: Mapping[str, Callable[[], Rows]] = {
    "potentials": _potentials,
    "sensors": _sensors,
    "effectors": _effectors,
    "controllers": _controllers,
    "hands": _hands,
    "mounts": _mounts,
    "sensing": _sensing,
    "objects": _objects,
    "worlds": _worlds,
    "grades": _grades,
}
