"""Another name for a controller, a resource or a parameter, wherever it stands in a spec."""

from __future__ import annotations

from collections.abc import Sequence

from graspdsl.compiler.definitions import used_in
from graspdsl.diagnostics import DiagnosticError, Fix, Span
from graspdsl.editor.names import CONTROLLER, PARAMETER, RESOURCE, Use, definition_of, names_in, use_at, uses_in
from graspdsl.editor.sheet import Place, Sheet, sheet_of
from graspdsl.notation.names import ascii_name, canonical, latex_name
from graspdsl.notation.parser import parse_head, parse_resources
from graspdsl.notation.tree import Expression, Name
from graspdsl.places.files import with_plain_line_ends
from graspdsl.places.positions import Lines

_LIKE = {CONTROLLER: "π_mine", RESOURCE: "γ4, Γ_m or thumb", PARAMETER: "κ_f or x_ref"}


class RenamingError(Exception):
    """Why a name cannot be changed, or cannot become another."""


def renamable(text: str, place: Place) -> tuple[str, Span]:
    """The name at a place as it is written there, and where. Raises RenamingError where it cannot be changed."""
    sheet, use = _named(text, place)
    return _written(Lines(sheet.text), use.span), use.span


def renamed(text: str, place: Place, name: str) -> tuple[Fix, ...]:
    """The edits that give the thing at a place another name, where it is defined and wherever it is used.

    A use in ASCII stays in ASCII. Raises RenamingError, with the reason, where that cannot be done.
    """
    sheet, use = _named(text, place)
    new = _good(use.what, name)
    if not use.entry:
        _refuse_needed(sheet, use)
    uses = uses_in(sheet)
    _refuse_clash(sheet, uses, use, new)
    lines = Lines(sheet.text)
    # A set that LaTeX has once for both sides of a bar is used twice in one place.
    places = dict.fromkeys(each.span for each in uses if each.is_of(use))
    edits = tuple(Fix(span, _spelt(new, _written(lines, span))) for span in places)
    after = sheet_of(applied(sheet.text, edits))
    expected = [(each.what, new if each.is_of(use) else each.name, each.entry == ()) for each in uses]
    if after is None or [(each.what, each.name, each.entry == ()) for each in uses_in(after)] != expected:
        raise RenamingError(f"{new} would be read as something else here: choose another name")
    return edits


def applied(text: str, edits: Sequence[Fix]) -> str:
    """The text after edits, no two of which overlap."""
    rows = text.split("\n")
    starts = [0]
    for row in rows:
        starts.append(starts[-1] + len(row) + 1)
    for edit in sorted(edits, key=lambda edit: edit.span, reverse=True):
        span = edit.span
        start, end = starts[span.line - 1] + span.column - 1, starts[span.end_line - 1] + span.end_column - 1
        text = text[:start] + edit.text + text[end:]
    return text


def _named(text: str, place: Place) -> tuple[Sheet, Use]:
    sheet = sheet_of(with_plain_line_ends(text))
    if sheet is None:
        raise RenamingError("the file cannot be read: mend it first")
    use = use_at(sheet, place)
    if use is None:
        raise RenamingError("there is no name of a controller, a resource or a parameter here")
    for formula in sheet.formulas:
        if formula.tree is None:
            raise RenamingError(f"the formula on line {formula.span.line} cannot be read: mend it first")
    if definition_of(sheet, use) is None:
        what = use.what or "name"
        raise RenamingError(f"the {what} {use.name} is not defined in this file: it keeps its name")
    return sheet, use


def _good(what: str, name: str) -> str:
    """The canonical spelling of a name that a thing may have."""
    read = name.strip()
    try:
        tree = parse_head(read).name if what == CONTROLLER else parse_resources(read)
    except DiagnosticError as error:
        reason = error.diagnostics[0].message
        raise RenamingError(f"{name!r} cannot be the name of a {what}, as {_LIKE[what]} can: {reason}") from None
    if not isinstance(tree, Name) or tree.text != canonical(read):
        raise RenamingError(f"{name!r} is not the name of a {what}, as {_LIKE[what]} is")
    return tree.text


def _refuse_needed(sheet: Sheet, use: Use) -> None:
    """Refuse another name for what a controller of elsewhere takes by its name, as π_s does the force κ_f."""
    trees = [formula.tree for formula in sheet.formulas if formula.start == "expression"]
    for tree in trees:
        assert tree is None or isinstance(tree, Expression)
        for definition in used_in(tree, sheet.definitions):
            if definition.in_prelude and definition.body is not None and use.name not in definition.parameters:
                taken = {name.text for what, name in names_in(definition.body) if what == use.what}
                if use.name in taken:
                    used = definition.head.name.text
                    raise RenamingError(f"{used}, which is used here, takes {use.name} by this name: it keeps it")


def _refuse_clash(sheet: Sheet, uses: Sequence[Use], use: Use, new: str) -> None:
    if new == use.name:
        return
    if use.what == CONTROLLER and new in sheet.definitions:
        where = "in the prelude" if sheet.definitions[new].in_prelude else "in this file"
        raise RenamingError(f"{new} is defined already, {where}: choose another name")
    if use.what == RESOURCE and new == "γ_g":
        raise RenamingError("γ_g is gravity: choose another name")
    for other in uses:
        if other.name == new and (other.defines or other.what == use.what):
            what = "given where a controller is used" if other.entry else f"a {other.what} of this file"
            raise RenamingError(f"{new} is {what} already: choose another name")


def _written(lines: Lines, span: Span) -> str:
    return lines.text.split("\n")[span.line - 1][span.column - 1 : span.end_column - 1]


def _spelt(name: str, before: str) -> str:
    """A name in the spelling of the one that it takes the place of."""
    if "\\" in before:
        return latex_name(name)
    return ascii_name(name) if before.isascii() and not canonical(before).isascii() else name
