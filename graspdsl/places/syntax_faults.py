"""Says in plain words what is wrong with a text that is not YAML, and what to write instead."""

from __future__ import annotations

import re
from collections.abc import Callable

from yaml.error import MarkedYAMLError

from graspdsl.diagnostics import Diagnostic
from graspdsl.places.positions import Lines
from graspdsl.places.wording import quoted, shortened

# What came before a value on its line: list dashes and a key with its colon.
_LABEL = re.compile(r"\s*(?:- +)*(?:[^\s:#][^:#]*: +)?")


class _Scene:
    """One complaint of PyYAML: its words, where it noticed (``at``), where what it was reading began (``since``)."""

    def __init__(self, error: MarkedYAMLError, lines: Lines) -> None:
        self.lines = lines
        self.problem = error.problem or ""
        self.context = error.context or ""
        mark = error.problem_mark or error.context_mark
        self.at = min(mark.index if mark else 0, len(lines.text))
        self.since = error.context_mark.index if error.context_mark else self.at
        self.before = lines.line_before(self.at)

    def fault(self, code: str, message: str, hint: str | None, start: int | None = None, end: int = 0) -> Diagnostic:
        start = self.at if start is None else start
        return Diagnostic(code, message, self.lines.span(start, end), hint)

    def value(self) -> tuple[int, str]:
        """Where the value on this line begins, behind its key, and its text."""
        line_start = self.at - len(self.before)
        label = _LABEL.match(self.lines.text, line_start)
        start = label.end() if label else line_start
        return start, self.lines.rest_of_line(start)

    def unquoted(self, message: str, start: int | None = None) -> Diagnostic:
        """The fault of a text that needs quotes, from ``start`` to the end of its line."""
        if start is None:
            start, text = self.value()
        else:
            text = self.lines.rest_of_line(start)
        hint = f"put the text in quotes: {quoted(text)}"
        return self.fault("unquoted-text", message, hint, start, start + len(text))


def _tab_or_sign(scene: _Scene) -> Diagnostic:
    sign = scene.lines.text[scene.at : scene.at + 1]
    if sign == "\t":
        if not scene.before.strip(" -"):
            return scene.fault("tab-indentation", "a tab cannot indent YAML", "use spaces: two for each level")
        return scene.fault("tab", "a tab cannot stand here", "use a space")
    return scene.unquoted(f"a text that begins with '{sign}' needs quotes", scene.at)


def _second_colon(scene: _Scene) -> Diagnostic:
    if re.search(r":\s", scene.before):
        return scene.unquoted("YAML takes the second ': ' of this line for another key")
    start = scene.at - len(scene.before.lstrip())
    above = scene.lines.text[: scene.at - len(scene.before)].rstrip().split("\n")[-1]
    if len(above) - len(above.lstrip()) == len(scene.before) - len(scene.before.lstrip()):
        message = f"the line above is no 'key: value': {shortened(above)!r}"
        return scene.fault("no-key", message, "a key needs a colon and a blank behind it", start, scene.at)
    message = "this line is indented deeper than the line above, which already has a value"
    return scene.fault("bad-indentation", message, "give it the indentation of the keys it belongs to", start, scene.at)


def _no_colon(scene: _Scene) -> Diagnostic:
    text = scene.lines.rest_of_line(scene.since)
    message = f"this is no 'key: value': {shortened(text)!r}"
    hint = "a key needs a colon and a blank behind it"
    return scene.fault("no-key", message, hint, scene.since, scene.since + len(text))


def _block_indicator(scene: _Scene) -> Diagnostic:
    sign = scene.lines.text[scene.since : scene.since + 1]
    return scene.unquoted(f"YAML takes '{sign}' at the start of a value for the start of a text block", scene.since)


def _open_quote(scene: _Scene) -> Diagnostic:
    sign = scene.lines.text[scene.since : scene.since + 1]
    return scene.fault("open-quote", f"this {sign} is never closed", f"close the text with {sign}", scene.since)


def _escape(scene: _Scene) -> Diagnostic:
    letter = scene.lines.text[scene.at : scene.at + 1]
    start = scene.lines.text.rfind("\\", 0, scene.at + 1)
    inside = scene.lines.rest_of_line(scene.since + 1).split('"')[0]
    hint = f"in single quotes a backslash is just a backslash: {quoted(inside)}"
    message = f"'\\{letter}' means nothing in double quotes"
    if "hexadecimal" in scene.problem:
        message = "this escape needs more hexadecimal digits"
    return scene.fault("bad-escape", message, hint, start, scene.at + 1)


def _open_bracket(scene: _Scene) -> Diagnostic:
    sign = scene.lines.text[scene.since : scene.since + 1]
    other = "}" if sign == "{" else "]"
    if scene.lines.place(scene.at)[0] == scene.lines.place(scene.since)[0] and scene.lines.rest_of_line(scene.at):
        message = f"YAML reads a {'mapping' if sign == '{' else 'list'} from this '{sign}' on, and cannot go on here"
        hint = f"write ',' or '{other}' here; a formula or a set of resources needs quotes around it"
        return scene.fault("open-bracket", message, hint)
    hint = f"close it with '{other}'; a formula or a set of resources needs quotes around it"
    return scene.fault("open-bracket", f"this '{sign}' is not closed", hint, scene.since)


def _text_after_value(scene: _Scene) -> Diagnostic:
    start, text = scene.value()
    if start < scene.at and scene.before.strip(" -"):
        if text[:1] in ("'", '"'):
            rest = scene.lines.rest_of_line(scene.at)
            message = f"nothing may follow the closing quote, but {shortened(rest)!r} does"
            hint = "put all of it between the quotes"
            return scene.fault("text-after-value", message, hint, scene.at, scene.at + len(rest))
        return scene.unquoted("YAML reads the start of this as a list or a mapping, and then text follows")
    if text[:1] in ("]", "}"):
        return scene.fault("yaml-syntax", f"this '{text[0]}' closes nothing", "remove it, or open it first")
    line = scene.lines.place(scene.since)[0]
    message = f"this line does not belong to the block that begins on line {line}"
    hint = "give it the same indentation as the lines it belongs with"
    return scene.fault("bad-indentation", message, hint, scene.at, scene.at + len(scene.lines.rest_of_line(scene.at)))


def _list_item(scene: _Scene) -> Diagnostic:
    if scene.before.strip():
        hint = "begin the list on a line of its own; a text that begins with '- ' needs quotes"
        return scene.fault("misplaced-item", "a list item cannot begin here", hint)
    return scene.fault("misplaced-item", "a list item cannot stand between keys", "check the indentation")


def _complex_key(scene: _Scene) -> Diagnostic:
    return scene.unquoted("YAML takes a '? ' here for the start of a key", scene.at)


def _alias(scene: _Scene) -> Diagnostic:
    sign = scene.lines.text[scene.since : scene.since + 1]
    if sign not in ("*", "&"):
        sign = scene.lines.text[scene.at : scene.at + 1]
        scene.since = scene.at
    what = "an alias, a reference to an anchor" if sign == "*" else "an anchor, a name for what follows"
    return scene.unquoted(f"YAML takes '{sign}' for the start of {what}", scene.since)


def _unknown_alias(scene: _Scene) -> Diagnostic:
    name = scene.lines.rest_of_line(scene.at).split()[0]
    hint = f"define it first as &{name[1:]}; a text that begins with '*' needs quotes"
    message = f"there is no anchor for {shortened(name)}"
    return scene.fault("unknown-alias", message, hint, scene.at, scene.at + len(name))


def _second_anchor(scene: _Scene) -> Diagnostic:
    line = scene.lines.place(scene.since)[0]
    message = f"this anchor already stands for something else, on line {line}"
    return scene.fault("repeated-anchor", message, "give it another name")


def _tag(scene: _Scene) -> Diagnostic:
    return scene.unquoted("YAML takes '!' at the start of a value for a tag", scene.since)


def _directive(scene: _Scene) -> Diagnostic:
    hint = "remove the line; a text that begins with '%' needs quotes"
    return scene.fault("bad-directive", "YAML takes a line that begins with '%' for a directive", hint)


def _several_documents(scene: _Scene) -> Diagnostic:
    hint = "put each document in a file of its own, or remove the '---'"
    return scene.fault("several-documents", "a second YAML document begins here", hint)


def _separator(scene: _Scene) -> Diagnostic:
    message = "a document separator stands inside the text that begins with this quote"
    return scene.fault("open-quote", message, "close the quote", scene.since)


def _no_value(scene: _Scene) -> Diagnostic:
    sign = scene.lines.text[scene.at : scene.at + 1]
    if not sign.strip():
        opening = max(scene.lines.text.rfind("[", 0, scene.at), scene.lines.text.rfind("{", 0, scene.at))
        if "flow" in scene.context and opening >= 0:
            scene.since = opening
            return _open_bracket(scene)
        return scene.fault("yaml-syntax", "a value is missing here", None)
    return scene.fault("yaml-syntax", f"a value cannot begin with '{sign}'", "a text that begins with it needs quotes")


def _stray(scene: _Scene) -> Diagnostic:
    text = scene.lines.rest_of_line(scene.at)
    if not text:
        return _directive(scene)
    message = f"the document has ended, but {shortened(text)!r} follows"
    hint = "remove it, or check the brackets before it"
    return scene.fault("text-after-value", message, hint, end=scene.at + len(text))


# The first row whose words are all in PyYAML's complaint applies.
_TABLE: tuple[tuple[str, Callable[[_Scene], Diagnostic]], ...] = (
    ("cannot start any token", _tab_or_sign),
    ("mapping values are not allowed", _second_colon),
    ("mapping keys are not allowed", _complex_key),
    ("sequence entries are not allowed", _list_item),
    ("could not find expected ':'", _no_colon),
    ("while scanning a block scalar", _block_indicator),
    ("unexpected end of stream", _open_quote),
    ("unexpected document separator", _separator),
    ("while scanning a double-quoted scalar", _escape),
    ("expected ',' or", _open_bracket),
    ("expected <block end>", _text_after_value),
    ("undefined alias", _unknown_alias),
    ("duplicate anchor", _second_anchor),
    ("while scanning an ", _alias),
    ("expected a single document", _several_documents),
    ("expected '<document start>'", _stray),
    ("directive", _directive),
    ("version 1.* is required", _directive),
    ("duplicate tag handle", _directive),
    ("undefined tag handle", _tag),
    (" tag", _tag),
    ("expected the node content", _no_value),
)


def syntax_fault(error: MarkedYAMLError, lines: Lines) -> Diagnostic:
    """The diagnostic of a text that PyYAML's reader refused."""
    scene = _Scene(error, lines)
    words = f"{scene.context} {scene.problem}"
    for sign, explain in _TABLE:
        if sign in words:
            return explain(scene)
    return scene.fault("yaml-syntax", f"this is not YAML: {scene.problem or 'it cannot be read'}", None)
