"""YAML text to YAML nodes, within bounds: depth and number of nodes are checked before any tree is built."""

from __future__ import annotations

import re
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
from yaml.resolver import BaseResolver

from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.spec.characters import LenientScanner, refuse_forbidden
from graspdsl.spec.positions import Lines
from graspdsl.spec.syntax_faults import syntax_fault
from graspdsl.spec.wording import shortened

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


def _offset(mark: _Mark | None) -> int:
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
        start, end = _offset(event.start_mark), _offset(event.end_mark)
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
        start = _offset(event.start_mark)
        span = self._lines.first_line(start, start + len(self._lines.rest_of_line(start).split(" ")[0]))
        self.faults.append(Diagnostic("unknown-tag", message, span, hint))

    def resolve(self, kind: type[Node], value: str, implicit: tuple[bool, bool]) -> str:
        if kind is ScalarNode:
            return kind_of(value) if implicit[0] else "str"
        return "list" if kind is SequenceNode else "map"
