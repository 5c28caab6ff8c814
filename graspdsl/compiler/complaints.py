"""Where the checker's complaints go: each is about one place of the document."""

from __future__ import annotations

from dataclasses import replace

from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity, SourceText, Span
from graspdsl.notation.names import canonical
from graspdsl.spec.constructing import Path
from graspdsl.spec.document import Document


class Complaints:
    """Collects diagnostics; those about a value given on the command line say so instead of a place in the file."""

    def __init__(self, document: Document | None = None) -> None:
        self._document = document
        self._path: Path = ()
        self.found: list[Diagnostic] = []

    def about(self, path: Path) -> Path:
        """From now on, complaints concern the value at this path; gives back the path before."""
        before, self._path = self._path, path
        return before

    def error(self, code: str, message: str, span: Span | None, hint: str | None = None) -> None:
        """Add an error."""
        self.add(Diagnostic(code, message, span, hint))

    def warning(self, code: str, message: str, span: Span | None, hint: str | None = None) -> None:
        """Add a warning."""
        self.add(Diagnostic(code, message, span, hint, Severity.WARNING))

    def add(self, *diagnostics: Diagnostic) -> None:
        """Add diagnostics about the present path."""
        for diagnostic in diagnostics:
            self.found.append(self._document.attributed(self._path, diagnostic) if self._document else diagnostic)

    def of_parameter(self, name: str, complaint: Diagnostic) -> None:
        """Add a diagnostic about the value of a parameter, which all formulas that use it would repeat."""
        document = self._document
        keys = document.data.get("parameters") if document else None
        given = {canonical(key): key for key in keys} if isinstance(keys, dict) else {}
        if document is None or name not in given:
            self.add(complaint)
            return
        before = self.about(("parameters", given[name]))
        self.add(replace(complaint, span=document.span(("parameters", given[name]))))
        self.about(before)

    def take(self, error: DiagnosticError) -> None:
        """Add what an error carries."""
        self.add(*error.diagnostics)


def whole(source: SourceText) -> Span:
    """The span of a whole text."""
    return source.span(0, len(source.text))
