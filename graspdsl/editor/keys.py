"""The keys of spec, hand and mount files, and the values that may stand under them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from graspdsl.diagnostics import listed
from graspdsl.hands.descriptions import Hand, Mount, Robot, hands, mounts
from graspdsl.objects.shapes import catalogue
from graspdsl.places.document import Path
from graspdsl.places.folders import HAND_FILE, MOUNT_FILE, begins_as
from graspdsl.places.validation import kinds_at, slot
from graspdsl.places.wording import as_yaml
from graspdsl.quality.grades import GRADES
from graspdsl.spec.models import Spec
from graspdsl.spec.monitors import MONITORS
from graspdsl.worlds.kinds import WORLDS
from graspdsl.worlds.touch.sensors import TACTILE_SENSORS

_WORDS = {float: "a number", int: "a whole number", str: "text", bool: "true or false", dict: "a mapping"}


@dataclass(frozen=True, slots=True)
class Value:
    """What may be written, with a line on it."""

    text: str
    about: str = ""


def model_of(text: str) -> type[BaseModel]:
    """The model that the text of a file is held against."""
    return Hand if HAND_FILE.match(text) else Mount if MOUNT_FILE.match(text) else Spec


def keys_at(model: type[BaseModel], path: Path) -> Mapping[str, FieldInfo]:
    """The keys that the mapping at a path may have."""
    return slot(model, path).fields()


def described(model: type[BaseModel], path: Path) -> str | None:
    """What is to be known of the key at a path: what it takes, in which unit, its default, what it is for."""
    field = keys_at(model, path[:-1]).get(str(path[-1]))
    if field is None:
        return None
    unit = slot(model, path).unit
    takes = listed(dict.fromkeys(_kinds(kinds_at(model, path))), "or")
    rows = [f"**{path[-1]}**: {takes}" + (f" in {unit}" if unit and unit != "1" else "")]
    if field.is_required():
        rows.append("needed")
    elif (default := _default(field)) is not None:
        rows.append(f"by default {default}")
    if field.description:
        rows.append(field.description)
    return "\n\n".join(rows)


def _kinds(parts: Iterable[Any]) -> Iterator[str]:
    for part in parts:
        origin = get_origin(part)
        if origin is Literal:
            yield from (f"`{as_yaml(value)}`" for value in get_args(part))
        elif origin is tuple:
            yield "a list"
        elif (origin or part) in _WORDS:
            yield _WORDS[origin or part]
        elif isinstance(part, type) and issubclass(part, BaseModel):
            keys = list(part.model_fields.values())
            yield "a mapping" if len(keys) != 1 else f"`{{{next(iter(part.model_fields))}: …}}`"


def _default(field: FieldInfo) -> str | None:
    default = field.default
    if default is PydanticUndefined or default is None or isinstance(default, BaseModel) or default in ("", (), {}):
        return None
    return f"`{as_yaml(default)}`"


def values_at(model: type[BaseModel], path: Path, robot: Robot | None, folder: FilePath) -> list[Value]:
    """The values that may stand at a path, as far as they can be listed."""
    if model is Spec and (named := _named(path, robot, folder)) is not None:
        return named
    found = []
    for part in kinds_at(model, path):
        if get_origin(part) is Literal:
            found += [Value(as_yaml(value)) for value in get_args(part)]
        elif part is bool:
            found += [Value("true"), Value("false")]
    if path[:1] == ("monitors",) and len(path) == 2 and path[1] in MONITORS:
        found += [Value(str(word)) for word in ("off", *MONITORS[str(path[1])].words) if isinstance(word, str)]
    return list({value.text: value for value in found}.values())


def _named(path: Path, robot: Robot | None, folder: FilePath) -> list[Value] | None:
    match path:
        case ("scene", "hand"):
            return [*_about(hands()), *_files("hand", HAND_FILE, folder)]
        case ("scene", "mount"):
            return [*_about(mounts()), *_files("mount", MOUNT_FILE, folder)]
        case ("scene", "world"):
            return _about(WORLDS)
        case ("scene", "object") | ("scene", "object", "like"):
            return _about(catalogue())
        case ("scene", "sensing"):
            return _about(TACTILE_SENSORS)
        case ("evaluate", int()):
            return _about(GRADES)
        case ("resources", str()) if robot is not None:
            contacts = [Value(name, "a contact of the hand") for name in robot.contacts]
            return [*contacts, *joint_sets(robot)]
    return None


def joint_sets(robot: Robot) -> list[Value]:
    """The joint sets of a robot, each single joint too."""
    return [Value(name, f"joints: {listed(joints)}") for name, joints in robot.joint_sets.items()]


def _about(table: Mapping[str, Any]) -> list[Value]:
    return [Value(name, thing.about) for name, thing in table.items()]


def _files(kind: str, beginning: re.Pattern[str], folder: FilePath) -> list[Value]:
    """The files of a kind beside the spec."""
    files = [path for path in sorted(folder.glob("*")) if begins_as(beginning, path)]
    return [Value(path.name, f"a {kind} file beside the spec") for path in files]
