"""From syntax tree to text, with no bracket more than needed; what is printed reads back as the same tree."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from graspdsl.notation.names import ascii_name, latex_name
from graspdsl.notation.tree import (
    Abbreviation,
    Controller,
    Expression,
    Head,
    Name,
    Reference,
    Resources,
    ResourceSet,
    ScaledSensor,
    SubjectTo,
    Then,
    Transform,
    Vector,
    Virtual,
)

Printable = Expression | Reference | Head | Resources | Transform


def to_unicode(tree: Printable) -> str:
    """The canonical text of a tree: ``φ_mr|τ_mrx(Γ) σ_mr(Γ) ◁ φ_fr|τ_frx(Γ) σ_fr(Γ)``."""
    return _UNICODE.text(tree)


def to_ascii(tree: Printable) -> str:
    """The text of a tree in ASCII: ``phi_mr|tau_mrx(G) sigma_mr(G) <| phi_fr|tau_frx(G) sigma_fr(G)``."""
    return _ASCII.text(tree)


def to_latex(tree: Printable) -> str:
    """The text of a tree in LaTeX's mathematics: ``\\pi_{gx}|_{\\Gamma}^{\\Gamma}``, to stand between dollar signs."""
    return _LATEX.text(tree)


@dataclass(frozen=True, slots=True)
class LinePrinter:
    """Prints trees in one line of plain text; ``name`` spells a canonical name."""

    name: Callable[[str], str]
    subject_to: str
    then: str = "then"

    def text(self, tree: Printable) -> str:
        """The text of a tree, without brackets around it."""
        match tree:
            case Name():
                return self.name(tree.text)
            case Vector():
                return ", ".join(map(self._number, tree.values))
            case Virtual():
                return self._virtual(self._list(tree.members))
            case ResourceSet():
                return self._set(self._list(tree.members))
            case Transform():
                return f"{self.text(tree.name)}({self.text(tree.resources)})"
            case ScaledSensor():
                return self._scaled(tree)
            case Controller():
                sides = self._bar(self.text(tree.effector), self.text(tree.sensor))
                return f"{self.text(tree.potential)}{sides}{self._reference(tree.reference)}"
            case Abbreviation() | Head():
                given = tree.effector or tree.sensor
                sides = self._bar(self._arguments(tree.effector), self._arguments(tree.sensor)) if given else ""
                return f"{self.text(tree.name)}{sides}{self._reference(tree.reference)}"
            case SubjectTo():
                terms = (self._bracketed(term, isinstance(term, SubjectTo | Then)) for term in tree.terms)
                return f" {self.subject_to} ".join(terms)
            case Then():
                return f" {self.then} ".join(self._bracketed(step, isinstance(step, Then)) for step in tree.steps)

    def _list(self, trees: Iterable[Printable]) -> str:
        return ", ".join(map(self.text, trees))

    def _bracketed(self, tree: Printable, brackets: bool) -> str:
        return f"({self.text(tree)})" if brackets else self.text(tree)

    def _virtual(self, members: str) -> str:
        return f"<{members}>"

    def _set(self, members: str) -> str:
        return f"{{{members}}}"

    def _bar(self, effector: str, sensor: str) -> str:
        return f"|{effector} {sensor}"

    def _arguments(self, arguments: Sequence[Printable]) -> str:
        return f"({self._list(arguments)})" if len(arguments) != 1 else self.text(arguments[0])

    def _reference(self, reference: Reference | None) -> str:
        return "" if reference is None else f" ({self.text(reference)})"

    def _scaled(self, tree: ScaledSensor) -> str:
        match tree.factor:
            case None:
                return self.text(tree.sensor)
            case Name():
                return f"{self.text(tree.factor)} {self.text(tree.sensor)}"
            case factor:
                return f"{self._number(factor)} {self.text(tree.sensor)}"

    def _number(self, value: float) -> str:
        # The shortest decimal that reads back as the same float; a whole number needs no point.
        return repr(float(value)).removesuffix(".0")


class LatexPrinter(LinePrinter):
    """Prints trees as the chapter has them in print: effector side below the bar, sensor side above."""

    def _virtual(self, members: str) -> str:
        return rf"\langle {members} \rangle"

    def _set(self, members: str) -> str:
        return rf"\{{{members}\}}"

    def _bar(self, effector: str, sensor: str) -> str:
        return f"|_{{{effector}}}^{{{sensor}}}"

    def _arguments(self, arguments: Sequence[Printable]) -> str:
        return self._list(arguments)  # a tuple without brackets, as in Eq. 4.26

    def _number(self, value: float) -> str:
        mantissa, _, exponent = LinePrinter._number(self, value).partition("e")
        return rf"{mantissa} \times 10^{{{int(exponent)}}}" if exponent else mantissa


_UNICODE = LinePrinter(str, "◁")
_ASCII = LinePrinter(ascii_name, "<|")
_LATEX = LatexPrinter(latex_name, r"\triangleleft", r"\;\text{then}\;")
