"""What a spec names of other packages, and of its own Python files: entered into the tables, or complained of."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import metadata
from pathlib import Path as FilePath
from typing import Any

from pydantic import TypeAdapter

from graspdsl.basis.prelude import Definition
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity, SourceText, Span, listed
from graspdsl.notation.latex import reading_of
from graspdsl.objects.object_files import FILES
from graspdsl.objects.shapes import SHAPES
from graspdsl.places.document import Document, Path, parse_document
from graspdsl.places.files import COPIES, RUN_MANIFEST, NamedFile, SpecFolder, read_text, refusal
from graspdsl.places.folders import SUFFIXES, names_a_file
from graspdsl.plugins.kinds import (
    BROUGHT,
    KINDS,
    OF_OTHERS,
    Key,
    Offer,
    Plugin,
    is_built_in,
    named_in,
    offered,
    words_in,
)
from graspdsl.plugins.loading import attempted, digest_of, enter, loaded, place_of, things_in
from graspdsl.spec.scene import InlineObject


@dataclass(frozen=True, slots=True)
class Adoption:
    """What a document names of other packages and of its own code: those things, the controllers among them, the files
    of its code, and complaints. ``failed``: a complaint for each name of which there is nothing to use. ``unread``:
    whether there is code of which nobody knows what it would define."""

    plugins: tuple[Plugin, ...] = ()
    controllers: Mapping[str, Definition] = field(default_factory=dict)
    files: tuple[NamedFile, ...] = ()
    faults: tuple[Diagnostic, ...] = ()
    failed: tuple[Diagnostic, ...] = ()
    unread: bool = False

    def explains(self, complaint: Diagnostic) -> bool:
        """Whether a complaint, that something is unknown, follows from one of these."""
        said = self.unread or any(_at_one_place(fault, complaint) for fault in self.failed)
        return complaint.code.startswith("unknown-") and said


def _at_one_place(first: Diagnostic, second: Diagnostic) -> bool:
    if first.span is None or second.span is None:  # of what is given on the command line, which the messages begin with
        return first.span is second.span and first.message.partition(": ")[0] == second.message.partition(": ")[0]
    return _start(first.span) < _end(second.span) and _start(second.span) < _end(first.span)


def _start(span: Span) -> tuple[int, int]:
    return span.line, span.column


def _end(span: Span) -> tuple[int, int]:
    return span.end_line, span.end_column


def adopted(document: Document, folder: FilePath, *, allow_code: bool = False) -> Adoption:
    """Enter into the tables what a document names of other packages and, where code is allowed, of its own files, which
    are in the folder."""
    reader = _Adopter(document, folder, allow_code=allow_code)
    reader.code()
    reader.all()
    return reader.adoption()


def adopted_in(formula: str) -> Adoption:
    """Enter into the tables what a formula outside a spec names."""
    reader = _Adopter()
    reader.formula(SourceText.of(formula), ())
    return reader.adoption()


def adopted_all(kinds: Iterable[str]) -> tuple[Diagnostic, ...]:
    """Enter into the tables all that is offered of some kinds; warnings of what cannot be."""
    reader = _Adopter()
    for offer in offered():
        if offer.kind in kinds:
            reader.want((offer.kind, offer.name), None, ())
    return tuple(
        Diagnostic(fault.code, fault.message, None, fault.hint, Severity.WARNING) for fault in reader.adoption().faults
    )


def tried(offer: Offer) -> tuple[Diagnostic, ...]:
    """Enter into its table what is offered, and what it needs; complaints where that cannot be."""
    if is_built_in((offer.kind, offer.name)):
        return (_taken((offer.kind, offer.name), offer.by),)
    reader = _Adopter()
    reader.want((offer.kind, offer.name), None, ())
    return reader.adoption().faults


def tried_file(path: FilePath) -> dict[Key, tuple[Diagnostic, ...]]:
    """Enter into their tables what a Python file, which is run, or a file of data has; complaints about each.

    Raises DiagnosticError where there is nothing that can be used.
    """
    if path.suffix not in SUFFIXES:
        _, things, warnings = things_in(path.name, SpecFolder(path.parent).read(path.name))
    else:
        keys, warnings = parse_document(read_text(path), path.name).data.keys(), ()
        kind = next((kind for key, kind in _BEGIN.items() if key in keys), "objects")
        read = KINDS[kind].read
        assert read is not None
        things = {(kind, name): thing for name, thing in read(path, path.name).items()}
    found: dict[Key, tuple[Diagnostic, ...]] = {}
    for key, thing in things.items():
        reader = _Adopter()
        if is_built_in(key):
            found[key] = (_taken(key, path.name),)
            continue
        if not reader.lacks(key, thing, path.name, None, (), things):
            enter(key, thing, Plugin(*key, path.name, "", ""))
        found[key] = (*warnings, *reader.adoption().faults)
    return found


def _taken(key: Key, by: str) -> Diagnostic:
    """The complaint about a thing with the name of a built-in one."""
    kind, name = key
    message = f"the {KINDS[kind].what} {name} of {by} is passed over: graspdsl has one of that name"
    return Diagnostic("plugin-passed-over", message, hint="give it another name")


_BEGIN = {"controllers": "controllers", "hand": "hands", "mount": "mounts"}  # what a file of data has, by a key in it


class _Adopter:
    def __init__(
        self, document: Document | None = None, folder: FilePath | None = None, *, allow_code: bool = False
    ) -> None:
        self._document, self._folder, self._allow_code = document, folder, allow_code
        self._code: set[Key] = set()
        self._faults: list[Diagnostic] = []
        self._used: dict[Key, Plugin] = {}
        self._seen: dict[Key, tuple[Span | None, Path]] = {}
        self._gone: dict[str, list[tuple[Plugin, Span | None, Path]]] = {}  # by what had them when a run was made
        self._files: tuple[NamedFile, ...] = ()
        self._unread = False
        self._offers: tuple[Offer, ...] | None = None

    def adoption(self) -> Adoption:
        """What became of all that was wanted."""
        if self._offers is not None:
            for key, (span, path) in self._seen.items():
                for offer in self._offers_of(key) if is_built_in(key) else ():
                    self._say([replace(_taken(key, offer.by), severity=Severity.WARNING)], span, path)
        failed = [fault for fault in self._faults if fault.severity is Severity.ERROR]
        for gone in self._gone.values():
            said = _missing([plugin for plugin, _, _ in gone])
            told = [self._placed(said, span, path) for _, span, path in gone]
            self._faults.append(told[0])
            failed += told
        controllers = {name: OF_OTHERS[name] for kind, name in self._used if kind == "controllers"}
        return Adoption(
            tuple(sorted(self._used.values())),
            controllers,
            self._files,
            tuple(self._faults),
            tuple(failed),
            self._unread,
        )

    def all(self) -> None:
        """All that the document names."""
        assert self._document is not None
        data = self._document.data
        scene = data.get("scene")
        if isinstance(scene, dict):
            for key, kind in (("world", "worlds"), ("mount", "mounts"), ("hand", "hands"), ("object", "objects")):
                if not (isinstance(name := scene.get(key), str) and kind in ("hands", "mounts") and names_a_file(name)):
                    self._text(kind, ("scene", key))
            self._text("objects", ("scene", "object", "like"))
            self._keys("shapes", ("scene", "object"), {*InlineObject.model_fields} - {*SHAPES})
            self._text("touch", ("scene", "sensing"))
            self._keys("touch", ("scene", "sensing"))
        self._keys("monitors", ("monitors",))
        for number in range(len(items) if isinstance(items := data.get("evaluate"), list) else 0):
            self._text("grades", ("evaluate", number))
        controllers = _mapping(data.get("controllers"))
        own = {name for head in controllers for _, name in named_in(head)[:1]}
        for head, entry in controllers.items():
            place: Path = ("controllers", head)
            self._formula_at((*place, "is") if isinstance(entry, dict) else place, own)
        for number, phase in enumerate(items if isinstance(items := data.get("program"), list) else ()):
            if isinstance(phase, dict):
                self._formula_at(("program", number, "run"), own)

    def _text(self, kind: str, path: Path) -> None:
        document = self._document
        assert document is not None
        if document.has(path) and isinstance(name := document.get(path), str):
            self.want((kind, name), document.span(path), path)

    def _keys(self, kind: str, path: Path, known: Iterable[str] = ()) -> None:
        document = self._document
        assert document is not None
        for name in _mapping(document.get(path)) if document.has(path) else ():
            if name not in known:
                self.want((kind, name), document.key_span((*path, name)), (*path, name))

    def _formula_at(self, path: Path, own: Iterable[str]) -> None:
        document = self._document
        assert document is not None
        if document.has(path) and isinstance(document.get(path), str):
            self.formula(document.source_text(path), path, own)

    def formula(self, text: SourceText, path: Path, own: Iterable[str] = ()) -> None:
        """What a formula names but for the document's own controllers."""
        reading, _ = reading_of(text)
        for (kind, name), (start, end) in words_in(reading.text):
            if name not in own:
                self.want((kind, name), reading.span(start, end), path)

    def want(self, key: Key, span: Span | None, path: Path) -> None:
        """See that a thing that is named at a place is in its table, and all that it needs; or complain."""
        if key in self._seen:
            return
        self._seen[key] = span, path
        kind, name = key
        if is_built_in(key):
            return
        plugin = BROUGHT.get(key)
        if key in self._code or (plugin is not None and plugin.version):
            self._use(key, span, path)
            return
        offers = self._offers_of(key)
        if len(offers) > 1:
            brought = listed(sorted(offer.by for offer in offers))
            message = f"{brought} each have a {KINDS[kind].what} {name}"
            self._say([Diagnostic("plugin-clash", message, span, "uninstall all but one of them")], span, path)
        elif offers:
            self._load(offers[0], span, path)
        elif (plugin := plugin or self._before().get(key)) is not None and (plugin.version or self._allow_code):
            self._gone.setdefault(plugin.by, []).append((plugin, span, path))

    def _load(self, offer: Offer, span: Span | None, path: Path) -> None:
        key = offer.kind, offer.name
        try:
            if offer.kind == "objects":
                self._shapes_of(place_of(offer), span, path)
            thing, warnings = loaded(offer)
            if self.lacks(key, thing, offer.by, span, path):
                return
            with attempted(f"{offer.said} cannot be read"):
                digest = digest_of(offer, thing)
            enter(key, thing, Plugin(*key, offer.distribution, offer.version, digest))
        except DiagnosticError as error:
            self._say(error.diagnostics, span, path)
            return
        self._say(warnings, span, path)
        self._use(key, span, path)

    def _use(self, key: Key, span: Span | None, path: Path) -> None:
        """Note that a thing of a table is used, and all that it needs."""
        kind, name = key
        self._used[key] = BROUGHT[key]
        for each in KINDS[kind].needs(KINDS[kind].table()[name]):
            self.want(each, span, path)

    def lacks(self, key: Key, thing: Any, by: str, span: Span | None, path: Path, beside: Container[Key] = ()) -> bool:
        """Whether a thing needs what is neither in a table nor beside it, which is complained of."""
        kind, name = key
        lacking = False
        with attempted(f"the {KINDS[kind].what} {name} of {by} does not say what it needs"):
            needs = list(KINDS[kind].needs(thing))
        for each in needs:
            if each in beside or each in self._seen:
                continue
            told = len(self._faults)
            self.want(each, span, path)
            if each[1] not in KINDS[each[0]].table():
                lacking = True
                if len(self._faults) == told:
                    what = f"the {KINDS[each[0]].what} {each[1]}, which there is not"
                    message = f"the {KINDS[kind].what} {name} of {by} needs {what}"
                    self._say([Diagnostic("plugin-unfit", message)], span, path)
        return lacking

    def _shapes_of(self, place: FilePath, span: Span | None, path: Path) -> None:
        """Of the objects in a file or a folder, the shapes that they are described by."""
        for file in [place] if place.is_file() else [file for file in place.glob("*") if file.suffix in SUFFIXES]:
            with contextlib.suppress(DiagnosticError):  # told when the objects are read
                for entry in parse_document(read_text(file), file.name).data.values():
                    for key in _mapping(entry).keys() - {"mass", "about", *FILES}:
                        self.want(("shapes", key), span, path)

    def code(self) -> None:
        """Enter what the document's own Python files define."""
        document = self._document
        assert document is not None
        names = document.get(("code",)) if document.has(("code",)) else None
        if not isinstance(names, list):
            return
        if not self._allow_code:
            span, hint = document.span(("code",)), "read what is in it; if you trust it, give --allow-code"
            message = f"this spec brings code of its own: {listed(map(str, names))}"
            self._say([Diagnostic("code-not-allowed", message, span, hint)], span, ("code",))
            self._unread = True
            return
        folder = SpecFolder(self._folder or FilePath())
        for number, name in enumerate(names):
            if isinstance(name, str):
                self._file(folder, name, ("code", number))
        self._files = tuple(folder.files)

    def _file(self, folder: SpecFolder, name: str, path: Path) -> None:
        assert self._document is not None
        span = self._document.span(path)
        try:
            if FilePath(name).is_absolute():
                raise refusal("outside-of-folder", "code is named by a relative path", "put it beside the spec")
            digest, things, warnings = things_in(name, folder.read(name))
            self._say(warnings, span, path)
            for key, thing in things.items():
                kind, own = key
                if is_built_in(key):
                    raise DiagnosticError([_taken(key, name)])
                if self.lacks(key, thing, name, span, path, things):
                    continue
                for offer in self._offers_of(key):
                    message = f"{offer.said} is passed over: {name} has one of that name"
                    self._say([Diagnostic("plugin-passed-over", message, severity=Severity.WARNING)], span, path)
                plugin = Plugin(kind, own, name, "", digest)
                if KINDS[kind].table().get(own) is not thing:
                    enter(key, thing, plugin)
                BROUGHT[key] = plugin
                self._code.add(key)
        except DiagnosticError as error:
            self._say(error.diagnostics, span, path)
            self._unread = True

    def _offers_of(self, key: Key) -> list[Offer]:
        if self._offers is None:
            self._offers = offered()
        return [offer for offer in self._offers if (offer.kind, offer.name) == key]

    def _before(self) -> dict[Key, Plugin]:
        """What the run used in whose folder the document is."""
        if self._folder is None:
            return {}
        place = self._folder.parent if self._folder.name == COPIES else self._folder
        try:
            listed_there = json.loads(read_text(place / RUN_MANIFEST))["plugins"]
            plugins = TypeAdapter(tuple[Plugin, ...]).validate_python(listed_there)
        except (DiagnosticError, ValueError, KeyError, TypeError):
            return {}
        return {(plugin.kind, plugin.name): plugin for plugin in plugins}

    def _say(self, faults: Iterable[Diagnostic], span: Span | None, path: Path) -> None:
        self._faults += [self._placed(fault, span, path) for fault in faults]

    def _placed(self, fault: Diagnostic, span: Span | None, path: Path) -> Diagnostic:
        placed = replace(fault, span=span, fixes=())
        return self._document.attributed(path, placed) if self._document else placed


def _missing(plugins: Sequence[Plugin]) -> Diagnostic:
    """The complaint about things that are not there any more, all of one distribution or file."""
    first, things = plugins[0], listed(f"the {KINDS[plugin.kind].what} {plugin.name}" for plugin in plugins)
    if not first.version:
        message = f"{first.distribution}, which this spec does not name, had {things}"
        hint = f"write code: [{first.distribution}], and allow it with --allow-code"
        return Diagnostic("plugin-missing", message, hint=hint)
    try:
        now = f"and {first.distribution} {metadata.version(first.distribution)}, which is installed now, has not"
    except metadata.PackageNotFoundError:
        now = "which is not installed now"
    message = f"this run was made with {first.by}, {now}: {things}"
    return Diagnostic("plugin-missing", message, hint=f"pip install {first.distribution}=={first.version}")


def _mapping(value: object) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}
