"""Where the checker's complaints go: each is about one place of the document."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from graspdsl.diagnostics import Diagnostic, DiagnosticError, Fix, Severity, SourceText, Span, has_errors
from graspdsl.notation.names import canonical
from graspdsl.places.document import Document, Path


class Complaints:
    """Collects diagnostics; those about a value given on the command line say so instead of a place in the file.

    ``parameters``: the names of the spec's parameters, as they are written.
    """

    def __init__(self, document: Document | None = None, parameters: Iterable[str] = ()) -> None:
        self._document = document
        self._parameters = {canonical(name): name for name in parameters}
        self._path: Path = ()
        self.found: list[Diagnostic] = []
        self._of_definitions: set[tuple[str, str]] = set()

    def about(self, path: Path) -> Path:
        """From now on, complaints concern the value at this path; gives back the path before."""
        before, self._path = self._path, path
        return before

    def error(
        self, code: str, message: str, span: Span | None, hint: str | None = None, fixes: Iterable[Fix] = ()
    ) -> None:
        """Add an error."""
        self.add(Diagnostic(code, message, span, hint, fixes=tuple(fixes)))

    def warning(
        self, code: str, message: str, span: Span | None, hint: str | None = None, fixes: Iterable[Fix] = ()
    ) -> None:
        """Add a warning."""
        self.add(Diagnostic(code, message, span, hint, Severity.WARNING, tuple(fixes)))

    def add(self, *diagnostics: Diagnostic) -> None:
        """Add diagnostics about the present path."""
        for diagnostic in diagnostics:
            self.found.append(self._document.attributed(self._path, diagnostic) if self._document else diagnostic)

    def of_definition(self, since: int) -> bool:
        """Whether there are errors among the complaints from a number on, which are those about one definition.

        Its warnings are not given again where it is used, as :meth:`of_use` has it.
        """
        found = self.found[since:]
        self._of_definitions |= {(said.code, said.message) for said in found if said.severity is Severity.WARNING}
        return has_errors(found)

    def of_use(self, since: int) -> None:
        """From a number on, drop the warnings of a use that were given at a definition already."""
        told = self._of_definitions
        self.found[since:] = [said for said in self.found[since:] if (said.code, said.message) not in told]

    def of_parameter(self, name: str, complaint: Diagnostic) -> None:
        """Add a diagnostic about the value of a parameter, which all formulas that use it would repeat."""
        if self._document is None or name not in self._parameters:
            self.add(complaint)
            return
        path: Path = ("parameters", self._parameters[name])
        before = self.about(path)
        self.add(replace(complaint, span=self._document.span(path), fixes=()))
        self.about(before)

    def take(self, error: DiagnosticError) -> None:
        """Add what an error carries."""
        self.add(*error.diagnostics)


def span_of(source: SourceText) -> Span:
    """The span of a whole text."""
    return source.span(0, len(source.text))
