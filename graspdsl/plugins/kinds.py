"""The kinds of things that other packages may bring, what the installed ones offer, and what is in the tables of it."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from graspdsl.basis.effectors import EFFECTORS, Effector
from graspdsl.basis.potentials import POTENTIALS, Potential
from graspdsl.basis.prelude import Definition, definitions_in, prelude
from graspdsl.basis.sensors import SENSORS, Sensor
from graspdsl.hands.descriptions import hands, mounts
from graspdsl.notation.latex import plain
from graspdsl.notation.names import canonical
from graspdsl.notation.printer import to_unicode
from graspdsl.objects.object_files import objects_in
from graspdsl.objects.shape import DescribedShape
from graspdsl.objects.shapes import SHAPES, catalogue
from graspdsl.spec.models import Spec
from graspdsl.spec.monitors import MONITORS, add_monitor
from graspdsl.spec.scene import InlineObject, Scene, add_shape
from graspdsl.spec.sensing import add_sensor
from graspdsl.spec.watching import Monitor
from graspdsl.worlds.kind import WorldKind
from graspdsl.worlds.kinds import WORLDS
from graspdsl.worlds.touch.fingertip_sensor import FingertipSensor
from graspdsl.worlds.touch.sensors import TACTILE_SENSORS

if TYPE_CHECKING:
    from graspdsl.hands.descriptions import Hand, Mount
    from graspdsl.quality.grade import Grade

Key = tuple[str, str]  # a kind, and a name of it


@dataclass(frozen=True, slots=True, order=True)
class Plugin:
    """A thing that a program uses of a distribution: its kind and name, the distribution and its version, and a hash of
    the file, or of the folder of files, that it was read from. For one of a spec's own Python file that file stands in
    place of the distribution, without a version."""

    kind: str
    name: str
    distribution: str
    version: str
    digest: str

    @property
    def by(self) -> str:
        """What brought it."""
        return f"{self.distribution} {self.version}".rstrip()


@dataclass(frozen=True, slots=True)
class Offer:
    """A thing that an installed distribution has: its kind and name, and where the distribution says that it is."""

    kind: str
    name: str
    value: str
    distribution: str
    version: str

    @property
    def by(self) -> str:
        """The distribution with its version."""
        return f"{self.distribution} {self.version}"

    @property
    def said(self) -> str:
        """What it is, for a message."""
        return f"the {KINDS[self.kind].what} {self.name} of {self.by}"


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of things that other packages may offer.

    ``what``: one of them, for messages; ``table``: those there are; ``enter``: how one more gets there. Of code,
    ``base`` gives the class that it is written from, ``named_by`` the attribute with its name, and ``makes`` says
    whether the table holds instances. Of data, ``read`` gives those that a file or a folder has. ``needs``: other
    things that one of them is nothing without.
    """

    what: str
    table: Callable[[], Mapping[str, Any]]
    enter: Callable[[str, Any], None]
    base: Callable[[], type] | None = None
    named_by: str = "name"
    makes: bool = True
    read: Callable[[FilePath, str], Mapping[str, Any]] | None = None
    needs: Callable[[Any], Iterable[Key]] = lambda _: ()


OF_OTHERS: dict[str, Definition] = {}  # controllers, beside those of the prelude


def _enter_shape(name: str, shape: type[DescribedShape]) -> None:
    if name in InlineObject.model_fields and name not in SHAPES:
        raise TypeError(f"{name} is another key of an object")
    add_shape(shape, (Spec,))


def _enter_touch(name: str, sensor: type[FingertipSensor]) -> None:
    add_sensor(name, sensor.model, (Scene, "sensing"), (Spec,))
    TACTILE_SENSORS[name] = sensor


def _transforms(potential: Potential) -> Iterator[Key]:
    for name in (*potential.sensors, *potential.references):
        yield "sensors", name
    for name in potential.effectors:
        yield "effectors", name


# What most specs have no use for is imported when it is asked for.


def _grades() -> dict[str, Grade]:
    from graspdsl.quality.grades import GRADES

    return GRADES


def _grade() -> type[Grade]:
    from graspdsl.quality.grade import Grade

    return Grade


def _hands_in(place: FilePath, by: str) -> Mapping[str, Hand]:
    from graspdsl.hands.hand_files import hands_in

    del by
    return hands_in(place)


def _mounts_in(place: FilePath, by: str) -> Mapping[str, Mount]:
    from graspdsl.hands.mount_files import mounts_in

    del by
    return mounts_in(place)


KINDS: Mapping[str, Kind] = {
    "potentials": Kind(
        "potential", lambda: POTENTIALS, POTENTIALS.__setitem__, lambda: Potential, "symbol", needs=_transforms
    ),
    "sensors": Kind("sensor transform", lambda: SENSORS, SENSORS.__setitem__, lambda: Sensor, "symbol"),
    "effectors": Kind("effector transform", lambda: EFFECTORS, EFFECTORS.__setitem__, lambda: Effector, "symbol"),
    "controllers": Kind(
        "controller",
        lambda: {**prelude(), **OF_OTHERS},
        OF_OTHERS.__setitem__,
        read=definitions_in,
        needs=lambda definition: named_in(to_unicode(definition.body)),
    ),
    "worlds": Kind(
        "world",
        lambda: WORLDS,
        WORLDS.__setitem__,
        lambda: WorldKind,
        needs=lambda world: (("touch", name) for name in world.senses),
    ),
    "touch": Kind("tactile sensor", lambda: TACTILE_SENSORS, _enter_touch, lambda: FingertipSensor, makes=False),
    "shapes": Kind("shape", lambda: SHAPES, _enter_shape, lambda: DescribedShape, makes=False),
    "mounts": Kind("mount", mounts, lambda name, mount: mounts().update({name: mount}), read=_mounts_in),
    "monitors": Kind(
        "monitor",
        lambda: MONITORS,
        lambda _, monitor: add_monitor(monitor, (Spec,)),
        lambda: Monitor,
        "key",
        makes=False,
    ),
    "grades": Kind("grade", _grades, lambda name, grade: _grades().update({name: grade}), _grade),
    "hands": Kind("hand", hands, lambda name, hand: hands().update({name: hand}), read=_hands_in),
    "objects": Kind(
        "object", catalogue, lambda name, body: catalogue().update({name: body}), read=lambda p, _: objects_in(p)
    ),
}
FORMULAS = {"φ_": "potentials", "σ_": "sensors", "τ_": "effectors", "π_": "controllers"}
_WORD = re.compile(r"[^\W\d]\w*")

BROUGHT: dict[Key, Plugin] = {}  # what is in the tables beside the built-in things


def spelt(kind: str, name: str) -> str:
    """A name as its table has it."""
    return canonical(name) if kind in FORMULAS.values() else name


def words_in(formula: str) -> Iterator[tuple[Key, tuple[int, int]]]:
    """The names in a formula in plain spelling by their kinds, each with where it begins and ends."""
    for word in _WORD.finditer(formula):
        name = canonical(word.group())
        if name[:2] in FORMULAS:
            yield (FORMULAS[name[:2]], name), word.span()


def named_in(formula: str) -> list[Key]:
    """What a formula names."""
    return [key for key, _ in words_in(plain(formula))]


def offered() -> tuple[Offer, ...]:
    """What the installed distributions offer, of all kinds; nothing is imported."""
    return tuple(
        Offer(kind, spelt(kind, entry.name), entry.value, *named)
        for kind, entry in _entries()
        if (named := _distribution_of(entry)) is not None
    )


def with_offered(kind: str, known: Iterable[str]) -> set[str]:
    """Names of a kind that are known, and those that the installed distributions offer."""
    return {*known, *(offer.name for offer in offered() if offer.kind == kind)}


def _entries() -> list[tuple[str, metadata.EntryPoint]]:
    """The entry points of all distributions, by kinds, but of those whose list of them cannot be read."""
    try:
        found = metadata.entry_points()
        return [(kind, entry) for kind in KINDS for entry in found.select(group=f"graspdsl.{kind}")]
    except Exception:  # each by itself, which takes longer: of two of one name the first on the path counts
        each = dict[str, metadata.EntryPoints]()
        for distribution in metadata.distributions():
            with contextlib.suppress(Exception):
                each.setdefault(distribution.name, distribution.entry_points)
        return [
            (kind, entry)
            for kind in KINDS
            for known in each.values()
            for entry in known.select(group=f"graspdsl.{kind}")
        ]


def _distribution_of(entry: metadata.EntryPoint) -> tuple[str, str] | None:
    """Its name and version; none of what is left of an uninstalled one, nor where these cannot be read."""
    with contextlib.suppress(Exception):
        if entry.dist is not None and entry.dist.name:
            return entry.dist.name, entry.dist.version
    return None


def brought_by(kind: str, name: str) -> str:
    """Where a thing in a table comes from: a distribution with its version, or graspdsl itself."""
    plugin = BROUGHT.get((kind, name))
    return "graspdsl" if plugin is None else plugin.by


def is_built_in(key: Key) -> bool:
    """Whether graspdsl itself has a thing."""
    kind, name = key
    return key not in BROUGHT and name in KINDS[kind].table()
