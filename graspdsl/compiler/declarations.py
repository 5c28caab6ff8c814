"""What a spec declares for its formulas, as far as it could be read.

The checker works on a faulty spec too, so that faults of formulas are reported along with all others.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from graspdsl.diagnostics import SourceText
from graspdsl.notation.names import canonical
from graspdsl.places.document import Document, Path
from graspdsl.spec.models import ControllerDefinition, Spec
from graspdsl.spec.program import Until
from graspdsl.spec.scene import InlineObject
from graspdsl.worlds.kinds import WORLDS

HAND: Path = ("scene", "hand")
MOUNT: Path = ("scene", "mount")
OBJECT: Path = ("scene", "object")
DEFAULT_WORLD = "bullet"  # of expressions outside a spec


@dataclass(frozen=True, slots=True)
class Declaration:
    """A key and its text value, each with its places, the path of the value, and what else is said of a controller."""

    key: SourceText
    value: SourceText
    path: Path
    equation: str = ""
    about: str = ""


@dataclass(frozen=True, slots=True)
class PhaseEntry:
    """A phase's formula and the names of the conditions that end it."""

    formula: SourceText
    path: Path
    conditions: Collection[str]


@dataclass(frozen=True, slots=True)
class Declarations:
    """The scene's names, and the entries of ``resources``, ``controllers``, ``parameters`` and ``program``.

    A name or a parameter that could not be read, which has had its complaint, is None. ``unread`` are the names of
    resources whose declarations are no texts, which have had theirs too. ``holds`` and ``senses_gravity``: whether the
    object is held, and where its centre of mass is known; where the object or the world could not be read, they may be.
    ``weightless``: whether there is no gravity.
    """

    hand: SourceText | None
    mount: SourceText | None
    world: str | None
    object: SourceText | None = None
    object_path: Path = ()
    names_hand: bool = False
    holds: bool = False
    senses_gravity: bool = True
    weightless: bool = False
    displacement: str = "sliding"
    resources: tuple[Declaration, ...] = ()
    controllers: tuple[Declaration, ...] = ()
    parameters: Mapping[str, tuple[float, ...] | None] = field(default_factory=dict)
    phases: tuple[PhaseEntry, ...] = ()
    document: Document | None = None
    unread: tuple[str, ...] = ()


def default_scene() -> Declarations:
    """The scene of expressions outside a spec: the Barrett hand, γ1 the thumb, and Γ = {γ1, <γ2, γ3>}."""
    resources = {"γ1": "finger-3", "γ2": "finger-1", "γ3": "finger-2", "Γ": "{γ1, <γ2, γ3>}"}
    return Declarations(
        hand=SourceText.of("barrett"),
        mount=SourceText.of("gantry"),
        world=DEFAULT_WORLD,
        resources=tuple(Declaration(SourceText.of(k), SourceText.of(v), ()) for k, v in resources.items()),
        parameters={"κ_f": (0.5,)},
    )


def declarations_of(spec: Spec, document: Document) -> Declarations:
    """What a spec declares, each text with its places in the document; what could not be read is left out."""
    scene, thing, world = spec.scene, spec.scene.object, WORLDS.get(spec.scene.world)
    named, path = (thing.like, (*OBJECT, "like")) if isinstance(thing, InlineObject) else (thing, OBJECT)
    holds = thing is None or (isinstance(thing, InlineObject) and thing.held is not False)
    return Declarations(
        hand=_placed(document, HAND, scene.hand),
        mount=_placed(document, MOUNT, scene.mount),
        world=scene.world,
        object=_placed(document, path, named),
        object_path=path,
        names_hand=document.has(HAND),
        holds=holds,
        senses_gravity=world is None or world.knows_object or holds,
        weightless=scene.gravity == 0.0 and (world is None or world.has("weight")),
        displacement=spec.control.displacement or "sliding",
        resources=_entries(document, "resources", spec.resources),
        controllers=_entries(document, "controllers", spec.controllers),
        parameters={canonical(name): _vector(value) for name, value in spec.parameters.items()},
        phases=_phases(spec, document),
        document=document,
        unread=tuple(canonical(name) for name, meaning in spec.resources.items() if meaning is None),
    )


def _placed(document: Document, path: Path, text: str | None) -> SourceText | None:
    """A text with its places; those of a default count from 1:1."""
    if text is None:
        return None
    return document.source_text(path) if document.has(path) else SourceText.of(text)


def _entries(
    document: Document, section: str, entries: Mapping[str, str | ControllerDefinition]
) -> tuple[Declaration, ...]:
    found = []
    for key, entry in entries.items():
        path: Path = (section, key)
        if isinstance(entry, ControllerDefinition):
            path, body, said = (*path, "is"), entry.body, (entry.equation or "", entry.about or "")
        else:
            body, said = entry, ("", "")
        text = _placed(document, path, body)
        if text is not None:
            found.append(Declaration(document.key_source_text((section, key)), text, path, *said))
    return tuple(found)


def _vector(value: float | tuple[float, ...] | None) -> tuple[float, ...] | None:
    return value if value is None or isinstance(value, tuple) else (value,)


def _phases(spec: Spec, document: Document) -> tuple[PhaseEntry, ...]:
    found = []
    for index, phase in enumerate(spec.program):
        path: Path = ("program", index, "run")
        text = _placed(document, path, phase.run)
        if text is not None:
            conditions = [name for name in Until.model_fields if document.has(("program", index, "until", name))]
            found.append(PhaseEntry(text, path, conditions))
    return tuple(found)
