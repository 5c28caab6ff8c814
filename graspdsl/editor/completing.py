"""What may be written at a place: keys, values, the names of a formula, and its characters by their ASCII or LaTeX."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path as FilePath

from pydantic import BaseModel

from graspdsl.basis.effectors import EFFECTORS
from graspdsl.basis.entry import Entry
from graspdsl.basis.potentials import POTENTIALS
from graspdsl.basis.prelude import Definition, prelude
from graspdsl.basis.sensors import SENSORS
from graspdsl.compiler.resources import GRAVITY, is_formula
from graspdsl.diagnostics import Span
from graspdsl.editor.cursor import Cursor, cursor_at
from graspdsl.editor.keys import Value, joint_sets, keys_at, model_of, values_at
from graspdsl.editor.sheet import Place, robot_of, sheet_of
from graspdsl.hands.descriptions import Robot
from graspdsl.notation.characters import fold
from graspdsl.notation.greek import LETTERS
from graspdsl.notation.names import ascii_name, canonical
from graspdsl.notation.printer import to_unicode
from graspdsl.notation.syntax import Halt, Start, read
from graspdsl.places.document import Path
from graspdsl.places.files import with_plain_line_ends
from graspdsl.spec.models import Spec

SUBJECT_TO = "◁"
_SUBJECT_TO_SPELT = ("<|", "\\triangleleft", "\\lhd")
# What a name in a formula may have begun with: letters, or a command of LaTeX with its subscript.
_BEGUN = re.compile(r"(?:\\[A-Za-z]*(?:_\{?[\w,]*\}?)?|<\||[^\W\d]\w*)\Z")
_NOWHERE = "\0"  # what no formula holds: reading halts there, and tells what might stand in its place
_DECLARED = {"resources", "parameters"}  # sections whose keys are names


@dataclass(frozen=True, slots=True)
class Proposal:
    """What may be written: ``text`` in place of what is in ``span``, with its ``kind`` and lines on it.

    ``begun``: what stands there now, which an editor that filters what it shows has to let pass.
    """

    text: str
    kind: str
    span: Span
    begun: str
    detail: str = ""
    about: str = ""


def proposals(text: str, place: Place, folder: FilePath) -> list[Proposal]:
    """What may be written at a place; ``folder``: where the files are that the spec names."""
    text = with_plain_line_ends(text)
    model, cursor = model_of(text), cursor_at(text, place)
    if cursor.is_comment:
        return []
    asked = _Asked(text, place, folder, cursor, model)
    return list({(found.text, found.kind): found for found in asked.all()}.values())


class _Asked:
    """A question about a place."""

    def __init__(self, text: str, place: Place, folder: FilePath, cursor: Cursor, model: type[BaseModel]) -> None:
        self._text, self._place, self._folder, self._cursor, self._model = text, place, folder, cursor, model
        # A line that is begun may be what keeps the text from being read.
        self._sheet = (sheet_of(text) or sheet_of(_without_line(text, place[0]))) if model is Spec else None
        self._robot: Robot | None = None if self._sheet is None else robot_of(self._sheet.spec, folder)

    def all(self) -> Iterator[Proposal]:
        cursor, start = self._cursor, _start(self._cursor.path, self._cursor.in_value)
        if self._model is Spec and start is not None:
            yield from self._in_formula(start)
        if self._model is Spec and not cursor.in_value and cursor.path[:1] and cursor.path[0] in _DECLARED:
            yield from self._characters(names=())
        if not cursor.in_value:
            yield from self._keys()
        if cursor.in_value or (cursor.path and isinstance(cursor.path[-1], int)):
            values = values_at(self._model, cursor.path, self._robot, self._folder)
            yield from (self._of_value(value, "value") for value in values)

    def _of_value(self, value: Value, kind: str) -> Proposal:
        begun = self._cursor.begun.rpartition(" ")[2]
        return Proposal(value.text, kind, self._before(begun), begun, about=value.about)

    def _before(self, begun: str) -> Span:
        line, column = self._place
        return Span(line, column - len(begun), line, column)

    # --- keys -----------------------------------------------------------------------------------------------------

    def _keys(self) -> Iterator[Proposal]:
        path = self._cursor.path
        written = self._keys_written(path)
        for key, field in keys_at(self._model, path).items():
            if key not in written:
                needed = "needed" if field.is_required() else ""
                yield replace(self._of_value(Value(key, field.description or ""), "key"), text=f"{key}:", detail=needed)
        if path == ("trials", "start", "posture") and self._robot is not None:
            for joint in self._robot.hand.joints:
                yield replace(self._of_value(Value(joint, "a joint of the hand"), "key"), text=f"{joint}:")

    def _keys_written(self, path: Path) -> set[str]:
        if self._sheet is None or not self._sheet.document.has(path):
            return set()
        data = self._sheet.document.get(path)
        begun = self._cursor.begun.strip()
        return {key for key in data if key != begun} if isinstance(data, dict) else set()

    # --- formulas -------------------------------------------------------------------------------------------------

    def _in_formula(self, start: Start) -> Iterator[Proposal]:
        begun = self._begun()
        before = self._cursor.begun[: len(self._cursor.begun) - len(begun)]
        halt = read(fold(before) + _NOWHERE, start)
        if not isinstance(halt, Halt):
            return
        if start == "resources" and not before.strip() and not is_formula(self._cursor.begun or " "):
            yield from self._characters(names=())
            return
        yield from self._characters(self._names(halt))
        if halt.accepted & {"_SUBJECT_TO"}:
            yield from self._sign(SUBJECT_TO, "subject to: what is on its right has the higher priority")
        if "_THEN" in halt.accepted:
            yield from self._matching("then", "one controller to convergence, then the next", "value")

    def _begun(self) -> str:
        found = _BEGUN.search(self._cursor.begun)
        return found.group() if found else ""

    def _names(self, halt: Halt) -> Iterator[tuple[str, str, str]]:
        """The names that may stand where reading came to a halt: name, what it is, a line on it."""
        accepted, owner = halt.accepted, canonical(halt.owner)
        if "POTENTIAL" in accepted:
            yield from _entries(POTENTIALS.values(), "potential")
        if "ABBREVIATION" in accepted:
            for name, definition in self._definitions().items():
                yield name, to_unicode(definition.head), definition.about
        if "EFFECTOR" in accepted:
            fitting = POTENTIALS[owner].effectors if owner in POTENTIALS else tuple(EFFECTORS)
            yield from _entries((EFFECTORS[name] for name in fitting), "effector transform")
        if "SENSOR" in accepted:
            of_effector = [name for each in POTENTIALS.values() if owner in each.effectors for name in each.sensors]
            yield from _entries((SENSORS[name] for name in of_effector or SENSORS), "sensor transform")
        if "NAME" in accepted and "NUMBER" in accepted:
            parameters = (self._sheet.spec.parameters or {}) if self._sheet is not None else {}
            yield from ((canonical(name), "parameter", str(value)) for name, value in parameters.items())
        elif "NAME" in accepted:
            yield from self._resources(halt)

    def _definitions(self) -> dict[str, Definition]:
        return dict(prelude() if self._sheet is None else self._sheet.definitions)

    def _resources(self, halt: Halt) -> Iterator[tuple[str, str, str]]:
        resources = (self._sheet.spec.resources or {}) if self._sheet is not None else {}
        yield from ((canonical(name), "resource", str(meaning)) for name, meaning in resources.items())
        if halt.role != "EFFECTOR":
            yield GRAVITY, "gravity", "of sensors of a held object"
        if self._robot is not None and canonical(halt.owner) in ("τ_k", "σ_k"):
            yield from ((value.text, "joints", value.about) for value in joint_sets(self._robot))
        for formula in self._sheet.formulas if self._sheet is not None else ():
            if formula.entry == self._cursor.path[:2]:
                yield from ((name, "given where the controller is used", "") for name in formula.bound)

    # --- characters -----------------------------------------------------------------------------------------------

    def _characters(self, names: Iterable[tuple[str, str, str]]) -> Iterator[Proposal]:
        """Names that begin as what is written, in any spelling, and the letters that it spells."""
        for name, detail, about in names:
            yield from self._matching(name, about, "name", detail)
        begun = self._begun()
        plain = begun.removeprefix("\\").replace("{", "").replace("}", "").replace(",", "")
        if begun.isascii() and plain:
            spelt = canonical(plain)
            if spelt != plain and not spelt.isascii():
                yield Proposal(spelt, "character", self._before(begun), begun, detail=begun)
            for word, letter in LETTERS.items():
                if word.startswith(plain):
                    yield Proposal(letter, "character", self._before(begun), begun, detail=f"\\{word}")

    def _matching(self, name: str, about: str, kind: str, detail: str = "") -> Iterator[Proposal]:
        begun = self._begun()
        plain = begun.removeprefix("\\").replace("{", "").replace("}", "")
        spellings = (name, ascii_name(name), name.replace("_", ""))
        if any(spelling.startswith((plain, canonical(plain))) for spelling in spellings):
            yield Proposal(name, kind, self._before(begun), begun, detail, about)

    def _sign(self, sign: str, about: str) -> Iterator[Proposal]:
        begun = self._begun()
        tail = self._cursor.begun
        if tail.endswith("<") and not begun:
            begun = "<"
        if any(spelling.startswith(begun) for spelling in (sign, *_SUBJECT_TO_SPELT)):
            yield Proposal(sign, "character", self._before(begun), begun, "<|, \\triangleleft", about)


def _entries(entries: Iterable[Entry], what: str) -> Iterator[tuple[str, str, str]]:
    return ((entry.symbol, f"{what}, {entry.source}", entry.about) for entry in entries)


def _start(path: Path, in_value: bool) -> Start | None:
    """What a formula at a path is read as; None where there is none."""
    match path, in_value:
        case ((("program", int(), "run") | ("controllers", str()) | ("controllers", str(), "is")), True):
            return "expression"
        case ("resources", str()), True:
            return "resources"
        case ("controllers",), False:
            return "head"
    return None


def _without_line(text: str, line: int) -> str:
    rows = text.split("\n")
    return "\n".join([*rows[: line - 1], "", *rows[line:]])
