"""What a spec declares for its formulas, taken from the document as far as it can be read.

The checker works on a faulty document too, so that faults of formulas are reported along with all others.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from graspdsl.diagnostics import SourceText
from graspdsl.notation.names import canonical
from graspdsl.places.document import Document, Path
from graspdsl.spec.models import LARGEST_PARAMETER


@dataclass(frozen=True, slots=True)
class Entry:
    """A key and its text value, each with its places, the path of the value, and what else is said of a controller."""

    key: SourceText
    value: SourceText
    path: Path
    equation: str = ""
    about: str = ""


@dataclass(frozen=True, slots=True)
class PhaseEntry:
    """A phase's formula and which conditions end it."""

    formula: SourceText
    path: Path
    conditions: Mapping[str, object]


@dataclass(frozen=True, slots=True)
class Declarations:
    """The scene's names, and the entries of ``resources``, ``controllers``, ``parameters`` and ``program``.

    A parameter whose value could not be read, which has had its complaint, is None. ``unread`` are the names of
    resources whose declarations are no texts, which have had theirs too.
    """

    hand: SourceText
    names_hand: bool
    mount: SourceText
    world: SourceText
    object: SourceText | None
    object_path: Path
    holds: bool
    senses_gravity: bool
    displacement: str
    resources: tuple[Entry, ...]
    controllers: tuple[Entry, ...]
    parameters: Mapping[str, tuple[float, ...] | None]
    phases: tuple[PhaseEntry, ...]
    document: Document | None = None
    unread: tuple[str, ...] = ()


def default_scene() -> Declarations:
    """The scene of expressions outside a spec: the Barrett hand, γ1 the thumb, and Γ = {γ1, <γ2, γ3>}."""
    resources = {"γ1": "finger-3", "γ2": "finger-1", "γ3": "finger-2", "Γ": "{γ1, <γ2, γ3>}"}
    return Declarations(
        hand=SourceText.of("barrett"),
        names_hand=False,
        mount=SourceText.of("gantry"),
        world=SourceText.of("bullet"),
        object=None,
        object_path=(),
        holds=False,
        senses_gravity=True,
        displacement="sliding",
        resources=tuple(Entry(SourceText.of(k), SourceText.of(v), ()) for k, v in resources.items()),
        controllers=(),
        parameters={"κ_f": (0.5,)},
        phases=(),
    )


def declarations_of(document: Document) -> Declarations:
    """What can be read of a document, whatever else is wrong with it."""
    fallback = default_scene()
    scene = document.data.get("scene")
    inline = isinstance(scene, dict) and isinstance(scene.get("object"), dict)
    object_path: Path = ("scene", "object", "like") if inline else ("scene", "object")
    return Declarations(
        hand=_text(document, ("scene", "hand")) or fallback.hand,
        names_hand=isinstance(scene, dict) and "hand" in scene,
        mount=_text(document, ("scene", "mount")) or fallback.mount,
        world=_text(document, ("scene", "world")) or fallback.world,
        object=_text(document, object_path),
        object_path=object_path,
        holds=_holds(document),
        senses_gravity=_senses_gravity(document),
        displacement="probing" if _mapping(document, "control").get("displacement") == "probing" else "sliding",
        resources=_entries(document, "resources"),
        controllers=_entries(document, "controllers"),
        parameters=_parameters(document),
        phases=_phases(document),
        document=document,
        unread=_unread(document),
    )


def _senses_gravity(document: Document) -> bool:
    """Where the object's centre of mass is, is known of a held object and of a floating world's."""
    scene = document.data.get("scene")
    return not isinstance(scene, dict) or scene.get("world") == "floating" or _holds(document)


def _holds(document: Document) -> bool:
    scene = document.data.get("scene")
    thing = scene.get("object") if isinstance(scene, dict) else None
    return isinstance(thing, dict) and thing.get("held") is True


def _text(document: Document, path: Path) -> SourceText | None:
    try:
        return document.source_text(path) if isinstance(document.get(path), str) else None
    except KeyError:
        return None


def _mapping(document: Document, key: str) -> Mapping[str, object]:
    value = document.data.get(key)
    return value if isinstance(value, dict) else {}


def _entries(document: Document, section: str) -> tuple[Entry, ...]:
    entries = []
    for key, value in _mapping(document, section).items():
        path: Path = (section, key, "is") if isinstance(value, dict) else (section, key)
        text = _text(document, path)
        said = [value.get(name) if isinstance(value, dict) else None for name in ("equation", "about")]
        if text is not None:
            words = (word if isinstance(word, str) else "" for word in said)
            entries.append(Entry(document.key_source_text((section, key)), text, path, *words))
    return tuple(entries)


def _unread(document: Document) -> tuple[str, ...]:
    declared = _mapping(document, "resources").items()
    return tuple(canonical(name) for name, meaning in declared if not isinstance(meaning, str))


def _parameters(document: Document) -> dict[str, tuple[float, ...] | None]:
    found: dict[str, tuple[float, ...] | None] = {}
    for key, value in _mapping(document, "parameters").items():
        listed = value if isinstance(value, list) else [value]
        numbers = [n for n in listed if isinstance(n, int | float) and not isinstance(n, bool)]
        sound = numbers and len(numbers) == len(listed) and all(abs(n) <= LARGEST_PARAMETER for n in numbers)
        found[canonical(key)] = tuple(map(float, numbers)) if sound else None
    return found


def _phases(document: Document) -> tuple[PhaseEntry, ...]:
    program = document.data.get("program")
    phases = []
    for index, phase in enumerate(program if isinstance(program, list) else []):
        path: Path = ("program", index, "run")
        text = _text(document, path)
        if text is not None and isinstance(phase, dict):
            until = phase.get("until")
            phases.append(PhaseEntry(text, path, until if isinstance(until, dict) else {}))
    return tuple(phases)
