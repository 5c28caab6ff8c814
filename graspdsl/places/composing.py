"""YAML text to YAML nodes, within bounds: depth and number of nodes are checked before any tree is built.

Characters that are no YAML but look like it are told where they stand, and read over as what they were meant for. A
blank of another kind than the plain space, which web pages and word processors bring along, separates nothing in YAML;
and a backslash in double quotes begins an escape, which may swallow the first letter of a LaTeX command.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable
from typing import Protocol

from yaml.composer import Composer
from yaml.error import MarkedYAMLError
from yaml.events import (
    AliasEvent,
    CollectionEndEvent,
    CollectionStartEvent,
    Event,
    MappingStartEvent,
    ScalarEvent,
    SequenceStartEvent,
)
from yaml.nodes import Node, ScalarNode, SequenceNode
from yaml.parser import Parser
from yaml.reader import Reader
from yaml.resolver import BaseResolver
from yaml.scanner import Scanner
from yaml.tokens import ScalarToken

from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.places.positions import Lines
from graspdsl.places.syntax_faults import syntax_fault
from graspdsl.places.wording import quoted, shortened

MOST_FAULTS = 20

# Control characters, other line ends than \n, halves of surrogate pairs and the like; then what is nowhere seen: soft
# hyphens, marks of direction, widths of zero and byte order marks. What joins letters of some scripts may stand.
_FORBIDDEN = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff"
    "\xad\u034f\u061c\u115f\u1160\u17b4\u17b5\u180e\u200b\u202a-\u202e\u2060-\u206f\u3164\ufeff\uffa0]"
)
_LINE_ENDS = "\x0b\x0c\x85\u2028\u2029"

_BLANK = "[\xa0\u1680\u2000-\u200a\u200c-\u200f\u202f\u205f\u2800\u3000]"
_BLANKS = re.compile(f"{_BLANK}+")
# In a key's place, the blanks behind the colon; at the end of a plain text, those before a sign of YAML.
_BEHIND_COLON = re.compile(f"[^:]*:({_BLANK}+)")
_AT_END = re.compile(f"(?<!{_BLANK}){_BLANK}+(?= *(?:$|:(?: |$)))")
# How far a plain text may reach: up to a comment, which a blank comes before.
_ON_THE_LINE = re.compile(rf"[^\n#]*(?:(?<![ {_BLANK[1:]})#[^\n#]*)*")
_IN_BRACKETS = re.compile(rf"[^\n,\[\]{{}}#]*(?:(?<![ {_BLANK[1:]})#[^\n,\[\]{{}}#]*)*")
_FURTHEST_BACK = 200  # characters, to see what a text on the same line comes after

_GREEK = re.findall(
    r"\w+",
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi omicron pi rho sigma tau upsilon phi chi "
    "psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega",
)
# LaTeX commands in plain writing, which is shorter than the command with its backslash.
_TEX = {
    **{name: name for name in _GREEK},
    **{f"var{name}": name for name in ("epsilon", "theta", "kappa", "pi", "rho", "sigma", "phi")},
    **dict.fromkeys(("triangleleft", "lhd"), "<|"),
    **dict.fromkeys(("left", "right"), ""),
    "langle": "<",
    "rangle": ">",
    "mid": "|",
}
_ESCAPE = re.compile(rf"\\(?:({'|'.join(sorted(_TEX, key=len, reverse=True))})(?![A-Za-z])|.)", re.DOTALL)
_IN_DOUBLE_QUOTES = re.compile(r'"((?:[^"\\]|\\.)*)', re.DOTALL)
_ESCAPES = {
    "a": "a bell",
    "b": "a backspace",
    "e": "an escape character",
    "f": "a form feed",
    "n": "a line break",
    "r": "a carriage return",
    "t": "a tab",
    "v": "a vertical tab",
    "L": "a line end",
    "P": "a line end",
}


def named(character: str) -> str:
    """A character by its code point, with its name where it has one."""
    name = unicodedata.name(character, "")
    return f"U+{ord(character):04X}{name and f' ({name.lower()})'}"


def refuse_forbidden(lines: Lines) -> None:
    """Raises :class:`DiagnosticError` with every character that cannot stand in a YAML file."""
    faults, binary = [], "\0" in lines.text
    for bad in _FORBIDDEN.finditer(lines.text):
        character = bad.group()
        hint = "delete it: it is invisible, and was probably pasted along"
        if character in _LINE_ENDS:
            hint = "if a line ends here, delete it and press Enter"
        if binary:
            hint = "is this a binary file?"
        message = f"the character {named(character)} cannot stand in a YAML file"
        faults.append(Diagnostic("bad-character", message, lines.span(*bad.span()), hint))
        if binary or len(faults) == MOST_FAULTS:
            break
    if faults:
        raise DiagnosticError(faults)


class LenientScanner(Reader, Scanner):
    """PyYAML's scanner, which reads a blank of another kind as a space and a LaTeX command as its plain writing.

    Each is in ``faults``, once a stretch of blanks and once a text in quotes. :attr:`as_read` is what was read instead,
    as long as the text. Raises :class:`DiagnosticError` after ``MOST_FAULTS`` of them.
    """

    def __init__(self, lines: Lines) -> None:
        Reader.__init__(self, lines.text)
        Scanner.__init__(self)
        self.faults: list[Diagnostic] = []
        self._lines = lines

    @property
    def as_read(self) -> str:
        """The text with what was meant in place of what was written."""
        return str(self.buffer).removesuffix("\0")

    def scan_to_next_token(self) -> None:
        """Skips blanks of all kinds."""
        skip: Callable[[], None] = super().scan_to_next_token  # the stubs leave the scanner untyped
        skip()
        while self._read_blanks(self.pointer):
            skip()
        sign = self.peek()
        if sign == ":" or (sign == "-" and self._begins_line()):
            self._read_blanks(self.pointer + 1)

    def scan_plain(self) -> ScalarToken:
        """A plain text up to a blank of any kind that YAML's signs follow, or that follows a key's colon."""
        stretch = (_IN_BRACKETS if self.flow_level else _ON_THE_LINE).match(
            self.buffer, self.pointer, len(self.buffer) - 1
        )
        if stretch and _BLANKS.search(stretch.group()):
            self._read_separators(stretch.end())
        scan: Callable[[], ScalarToken] = super().scan_plain
        return scan()

    def scan_flow_scalar(self, style: str) -> ScalarToken:
        """A text in quotes, LaTeX commands in double quotes in plain writing."""
        if style == '"':
            self._read_latex()
        scan: Callable[[str], ScalarToken] = super().scan_flow_scalar
        return scan(style)

    def _read_separators(self, end: int) -> None:
        """Reads what separates a plain text, which ends there at the latest, from what comes next."""
        behind = _BEHIND_COLON.match(self.buffer, self.pointer, end)
        if behind and (self._begins_line() or (self.flow_level and self._before().rstrip()[-1:] in ("{", "[", ","))):
            self._read_blanks(behind.start(1))
        for blanks in _AT_END.finditer(self.buffer, self.pointer, end):
            self._read_blanks(blanks.start())

    def _before(self) -> str:
        near = self.buffer[max(0, self.pointer - _FURTHEST_BACK) : self.pointer]
        return str(near.rpartition("\n")[2])

    def _begins_line(self) -> bool:
        return not self._before().strip(" -")

    def _read_blanks(self, at: int) -> bool:
        """Reads blanks of another kind at this place as spaces; whether there were any."""
        found = _BLANKS.match(self.buffer, at)
        if found is None:
            return False
        message = f"{named(found.group()[0])} stands where YAML needs a plain space"
        self._add(Diagnostic("odd-blank", message, self._lines.span(*found.span()), "write a plain space instead"))
        self._write(at, " " * len(found.group()))
        return True

    def _read_latex(self) -> None:
        """Reads LaTeX commands of the text in double quotes that begins here in plain writing."""
        whole = _IN_DOUBLE_QUOTES.match(self.buffer, self.pointer)
        assert whole is not None
        commands = [escape for escape in _ESCAPE.finditer(whole.group(1)) if escape.group(1)]
        if not commands:
            return
        plain = _ESCAPE.sub(lambda escape: _plain(escape).rjust(len(escape.group())), whole.group(1))
        first = commands[0]
        start = whole.start(1) + first.start()
        letter = first.group(1)[0]
        what = f"is {_ESCAPES[letter]}" if letter in _ESCAPES else "means nothing"
        message = f"'\\{letter}' {what} in double quotes, so that this is no {first.group()}"
        plainly = quoted(_ESCAPE.sub(_plain, whole.group(1)))
        hint = f"write letters as they are or by their names, without backslashes: {plainly}"
        self._add(Diagnostic("bad-escape", message, self._lines.span(start, start + len(first.group())), hint))
        # A name that begins with a blank would be another name.
        blanks = len(plain) - len(plain.lstrip(" "))
        self._write(self.pointer, f'{" " * blanks}"{plain[blanks:]}')
        self.forward(blanks)

    def _add(self, fault: Diagnostic) -> None:
        self.faults.append(fault)
        if len(self.faults) == MOST_FAULTS:
            raise DiagnosticError(self.faults)

    def _write(self, at: int, text: str) -> None:
        self.buffer = self.buffer[:at] + text + self.buffer[at + len(text) :]


def _plain(escape: re.Match[str]) -> str:
    return _TEX.get(escape.group(1), escape.group())


DEPTH_LIMIT = 40
NODE_LIMIT = 10_000

# YAML 1.2's core schema: 1e-3 is a number, yes and 1:30 are text.
_KINDS = {
    "null": re.compile(r"~|null|Null|NULL|"),
    "bool": re.compile(r"true|True|TRUE|false|False|FALSE"),
    "int": re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+"),
    "float": re.compile(
        r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)"
    ),
}
_STANDARD = "tag:yaml.org,2002:"
_TAGS: dict[type[Event], str] = {
    ScalarEvent: f"{_STANDARD}str",
    SequenceStartEvent: f"{_STANDARD}seq",
    MappingStartEvent: f"{_STANDARD}map",
}


def too_many_nodes(lines: Lines, start: int, end: int) -> DiagnosticError:
    """The refusal of a document that has, or expands to, more than ``NODE_LIMIT`` nodes."""
    message = f"the document has more than {NODE_LIMIT} values, those that aliases stand for included"
    hint = "use fewer aliases (*name) to anchors that hold other aliases" if "&" in lines.text else None
    return DiagnosticError([Diagnostic("too-many-values", message, lines.span(start, end), hint)])


def too_deep(lines: Lines, start: int, end: int) -> DiagnosticError:
    """The refusal of a document nested more than ``DEPTH_LIMIT`` levels deep."""
    message = f"lists and mappings are nested more than {DEPTH_LIMIT} levels deep here"
    return DiagnosticError([Diagnostic("too-deep", message, lines.span(start, end), "a spec needs less than ten")])


def kind_of(text: str) -> str:
    """What a plain scalar is: ``null``, ``bool``, ``int``, ``float`` or ``str``."""
    return next((kind for kind, pattern in _KINDS.items() if pattern.fullmatch(text)), "str")


def compose(lines: Lines) -> tuple[Node | None, Lines, list[Diagnostic]]:
    """The root node of a YAML text (None when it is empty), the text as it was read, and complaints about it.

    The tag of every node is its kind: ``str``, ``int``, ``float``, ``bool``, ``null``, ``list`` or ``map``. The
    complaints are those that did not keep the text from being read: about its characters and its tags.
    Raises :class:`DiagnosticError` when the text is not one well-formed YAML document within the bounds.
    """
    refuse_forbidden(lines)
    # PyYAML's C parser has the same marks but other words for its complaints, and is not always there.
    composer = _BoundedComposer(lines)
    try:
        node = composer.get_single_node()
        return node, Lines(composer.as_read) if composer.faults else lines, composer.faults
    except MarkedYAMLError as error:
        raise DiagnosticError([*composer.faults, syntax_fault(error, Lines(composer.as_read))]) from None
    except (ValueError, OverflowError):
        # An escape beyond Unicode or a directive with a huge number.
        start = composer.get_mark().index
        message = "there is no character with this number, or the number is too long"
        raise DiagnosticError([Diagnostic("bad-escape", message, lines.span(start, start))]) from None


class _Mark(Protocol):
    index: int


def offset_of(mark: _Mark | None) -> int:
    """Where a mark is in the text."""
    return mark.index if mark else 0


class _BoundedComposer(LenientScanner, Parser, Composer, BaseResolver):
    """PyYAML's composer over an event stream that stops at the bounds."""

    def __init__(self, lines: Lines) -> None:
        LenientScanner.__init__(self, lines)
        Parser.__init__(self)
        Composer.__init__(self)
        BaseResolver.__init__(self)
        self._depth = 0
        self._nodes = 0

    def get_event(self) -> Event:
        event: Event = super().get_event()  # type: ignore[no-untyped-call]  # the stubs leave the parser untyped
        start, end = offset_of(event.start_mark), offset_of(event.end_mark)
        if isinstance(event, ScalarEvent | CollectionStartEvent | AliasEvent):
            self._nodes += 1
            if self._nodes > NODE_LIMIT:
                raise too_many_nodes(self._lines, start, end)
        if isinstance(event, ScalarEvent | CollectionStartEvent) and event.tag is not None:
            self._drop_tag(event)
        if isinstance(event, CollectionStartEvent):
            self._depth += 1
            if self._depth > DEPTH_LIMIT:
                raise too_deep(self._lines, start, end)
        elif isinstance(event, CollectionEndEvent):
            self._depth -= 1
        return event

    def _drop_tag(self, event: ScalarEvent | CollectionStartEvent) -> None:
        """Reads the event as if it had no tag; ``!``, ``!!str``, ``!!seq`` and ``!!map`` pass without a complaint."""
        tag = str(event.tag)
        event.tag = None
        if tag in ("!", _TAGS.get(type(event))):
            if isinstance(event, ScalarEvent):
                event.implicit = (False, True)
            return
        name = "!!" + tag.removeprefix(_STANDARD) if tag.startswith(_STANDARD) else tag
        message = f"the tag {shortened(name)} cannot stand here"
        hint = "remove it: a spec is plain text, numbers, lists and mappings; a text that begins with '!' needs quotes"
        start = offset_of(event.start_mark)
        span = self._lines.first_line(start, start + len(self._lines.rest_of_line(start).split(" ")[0]))
        self.faults.append(Diagnostic("unknown-tag", message, span, hint))

    def resolve(self, kind: type[Node], value: str, implicit: tuple[bool, bool]) -> str:
        if kind is ScalarNode:
            return kind_of(value) if implicit[0] else "str"
        return "list" if kind is SequenceNode else "map"
