"""From syntax tree to text, with no bracket more than needed; what is printed reads back as the same tree."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from graspdsl.notation.names import ascii_name
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


@dataclass(frozen=True, slots=True)
class LinePrinter:
    """Prints trees in one line of plain text; ``name`` spells a canonical name."""

    name: Callable[[str], str]
    subject_to: str

    def text(self, tree: Printable) -> str:
        """The text of a tree, without brackets around it."""
        match tree:
            case Name():
                return self.name(tree.text)
            case Vector():
                return ", ".join(map(_number, tree.values))
            case Virtual():
                return f"<{self._list(tree.members)}>"
            case ResourceSet():
                return f"{{{self._list(tree.members)}}}"
            case Transform():
                return f"{self.text(tree.name)}({self.text(tree.resources)})"
            case ScaledSensor():
                return self._scaled(tree)
            case Controller():
                transforms = f"{self.text(tree.effector)} {self.text(tree.sensor)}"
                return f"{self.text(tree.potential)}|{transforms}{self._reference(tree.reference)}"
            case Abbreviation() | Head():
                return (
                    f"{self.text(tree.name)}{self._sides(tree.effector, tree.sensor)}{self._reference(tree.reference)}"
                )
            case SubjectTo():
                terms = (self._bracketed(term, isinstance(term, SubjectTo | Then)) for term in tree.terms)
                return f" {self.subject_to} ".join(terms)
            case Then():
                return " then ".join(self._bracketed(step, isinstance(step, Then)) for step in tree.steps)

    def _list(self, trees: Iterable[Printable]) -> str:
        return ", ".join(map(self.text, trees))

    def _bracketed(self, tree: Printable, brackets: bool) -> str:
        return f"({self.text(tree)})" if brackets else self.text(tree)

    def _sides(self, effector: Sequence[Printable], sensor: Sequence[Printable]) -> str:
        return f"|{self._arguments(effector)} {self._arguments(sensor)}" if effector or sensor else ""

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
                return f"{_number(factor)} {self.text(tree.sensor)}"


def _number(value: float) -> str:
    # The shortest decimal that reads back as the same float; a whole number needs no point.
    return repr(float(value)).removesuffix(".0")


_UNICODE = LinePrinter(str, "◁")
_ASCII = LinePrinter(ascii_name, "<|")
