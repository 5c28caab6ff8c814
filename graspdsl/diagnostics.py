"""Complaints as data: where (Span), what (message), and what would be right (hint).

Every part of graspdsl that reads what a user wrote reports through :class:`Diagnostic`; only the command
line turns one into text. Lines and columns count characters from 1; an end column is exclusive.
"""

from __future__ import annotations

import difflib
import enum
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

MOST_NAMED = 40  # names in a hint
# What is not shown but acted upon, or stands for a byte that is no text: control and format characters, line ends.
_UNSEEN = {"Cc", "Cf", "Cs", "Zl", "Zp"}


@dataclass(frozen=True, slots=True, order=True)
class Span:
    """A stretch of a source text: from (line, column) up to, not including, (end_line, end_column)."""

    line: int
    column: int
    end_line: int
    end_column: int

    def to(self, other: Span) -> Span:
        """The stretch from the start of this span to the end of ``other``."""
        return Span(self.line, self.column, other.end_line, other.end_column)


@dataclass(frozen=True, slots=True)
class SourceText:
    """A piece of text that knows where each of its characters stands in the file it came from.

    ``places[i]`` is the (line, column) of ``text[i]``; there is one more place than characters, the end.
    A formula inside a quoted or folded YAML scalar is such a piece.
    """

    text: str
    places: tuple[tuple[int, int], ...]

    @classmethod
    def of(cls, text: str, line: int = 1, column: int = 1) -> SourceText:
        """Plain text that starts at (line, column)."""
        places = []
        for character in text:
            places.append((line, column))
            line, column = (line + 1, 1) if character == "\n" else (line, column + 1)
        places.append((line, column))
        return cls(text, tuple(places))

    def span(self, start: int, end: int) -> Span:
        """The span of ``text[start:end]``; an empty stretch covers one character."""
        last = len(self.text)
        start = min(max(start, 0), last)
        end = min(max(end, start), last)
        line, column = self.places[start]
        if end == start:
            return Span(line, column, line, column + 1)
        end_line, end_column = self.places[end - 1]
        return Span(line, column, end_line, end_column + 1)


class Severity(enum.StrEnum):
    """An error stops a run; a warning does not."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, slots=True)
class Fix:
    """An edit that mends a fault: ``text`` in place of what stands in ``span``, which is empty where text is added."""

    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One complaint about what a user wrote.

    ``code`` is a short stable word in kebab case (``unknown-potential``), ``span`` the place in the file,
    or None when the file as a whole is meant. ``fixes``: where the hint says what to write, the edits that do so, any
    of which is enough.
    """

    code: str
    message: str
    span: Span | None = None
    hint: str | None = None
    severity: Severity = Severity.ERROR
    fixes: tuple[Fix, ...] = field(default=(), compare=False, repr=False)

    def as_dict(self) -> dict[str, str | int | None]:
        """The fields of ``validate --json``; a complaint about a whole file points at its first character."""
        span = self.span or Span(1, 1, 1, 1)
        return {
            "code": self.code,
            "severity": self.severity.value,
            "line": span.line,
            "column": span.column,
            "end_line": span.end_line,
            "end_column": span.end_column,
            "message": self.message,
            "hint": self.hint,
        }


class DiagnosticError(Exception):
    """Carries the complaints about one input from where they were found to whoever shows them.

    ``name``: what messages call the input, empty as long as nobody has said; ``source``: its text as far as there is
    one. As text it is what the command line prints: each complaint with its place, its line and carets, its hint.
    """

    def __init__(self, diagnostics: Sequence[Diagnostic], name: str = "", source: str = "") -> None:
        self.diagnostics, self.name, self.source = tuple(diagnostics), name, source
        super().__init__(self.diagnostics, name, source)

    def __str__(self) -> str:
        if not self.name:
            return "; ".join(diagnostic.message for diagnostic in self.diagnostics)
        return "\n".join(as_text(diagnostic, self.name, self.source) for diagnostic in self.diagnostics)


@contextmanager
def reading(name: str, source: str = "") -> Iterator[None]:
    """Complaints of what is done within, that are not about another input, are about the one of this name."""
    try:
        yield
    except DiagnosticError as error:
        if error.name:
            raise
        raise DiagnosticError(error.diagnostics, name, source) from None


def has_errors(diagnostics: Iterable[Diagnostic]) -> bool:
    """Whether any of the complaints is an error."""
    return any(diagnostic.severity is Severity.ERROR for diagnostic in diagnostics)


def in_reading_order(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """The complaints sorted by place, each once."""
    start_of_file = Span(0, 0, 0, 0)
    return tuple(sorted(dict.fromkeys(diagnostics), key=lambda d: (d.span or start_of_file, d.code, d.message)))


def nearest(name: str, known: Iterable[str], count: int = 3, likeness: float = 0.6) -> list[str]:
    """The known names that look most like ``name``, best first; empty when none comes close."""
    return difflib.get_close_matches(name, list(known), n=count, cutoff=likeness)


def listed(names: Iterable[str], joint: str = "and") -> str:
    """``a, b and c``: names for a sentence, in their order."""
    items = list(names)
    if len(items) < 2:
        return "".join(items)
    return f"{', '.join(items[:-1])} {joint} {items[-1]}"


def known_names_hint(name: str, known: Iterable[str], what: str) -> str:
    """The hint of an unknown name: the nearest known ones, or all of them when none is near."""
    known = sorted(known)
    close = nearest(name, known)
    if close:
        return f"did you mean {listed(close, 'or')}?"
    if not known:
        return f"there are no known {what} here"
    more = f" and {len(known) - MOST_NAMED} more" if len(known) > MOST_NAMED else ""
    return f"known {what}: {', '.join(known[:MOST_NAMED])}{more}"


def likely(name: str, known: Iterable[str], span: Span | None) -> tuple[Fix, ...]:
    """The fixes of an unknown name in a span: the nearest known ones, as :func:`known_names_hint` has them."""
    return () if span is None else tuple(Fix(span, meant) for meant in nearest(name, sorted(known)))


def steers(character: str) -> bool:
    """Whether a terminal would act upon a character, or break its line there, rather than show it."""
    return unicodedata.category(character) in _UNSEEN


def on_one_line(text: str) -> str:
    """The text with what steers a terminal replaced, line breaks too, so that a name can forge no line."""
    return text if text.isprintable() else "".join("\ufffd" if steers(c) else c for c in text)


def _cells(text: str) -> int:
    """How many terminal cells the text takes (wide characters take two, combining marks none)."""
    return sum(
        0 if unicodedata.combining(character) else 2 if unicodedata.east_asian_width(character) in "WF" else 1
        for character in text
    )


def excerpt(span: Span, source: str, width: int = 120) -> tuple[str, str, str] | None:
    """The line of the source that a span starts on, and a caret line beneath it.

    Returns (line number, source line, carets), or None when the span lies outside the source. Long lines are
    cut around the span; control characters are shown as a replacement character so that a file cannot
    steer the terminal.
    """
    lines = source.split("\n")
    if not 1 <= span.line <= len(lines):
        return None
    line = lines[span.line - 1].rstrip("\r")
    line = on_one_line(line.replace("\t", " "))
    start = min(span.column - 1, len(line))
    end = span.end_column - 1 if span.end_line == span.line else len(line)
    end = max(end, start + 1)
    cut = 0
    if len(line) > width:
        cut = max(0, start - width // 3)
        line = line[cut : cut + width]
    start, end = start - cut, min(end - cut, len(line) + 1)
    carets = " " * _cells(line[:start]) + "^" * max(1, _cells(line[start:end]))
    return str(span.line), line, carets


def as_text(diagnostic: Diagnostic, file: str, source: str = "") -> str:
    """A complaint in plain text: ``file:line:column: error[code]: message``, the line, carets, the hint."""
    span = diagnostic.span
    place = f"{file}:{span.line}:{span.column}" if span else file
    rows = [on_one_line(f"{place}: {diagnostic.severity.value}[{diagnostic.code}]: {diagnostic.message}")]
    shown = excerpt(span, source) if span else None
    if shown:
        number, line, carets = shown
        margin = " " * len(number)
        rows += [f"  {number} | {line}", f"  {margin} | {carets}"]
    if diagnostic.hint:
        rows.append(on_one_line(f"  hint: {diagnostic.hint}"))
    return "\n".join(rows)
