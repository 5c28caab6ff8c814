"""Formulas in Python: read, composed and written."""

from __future__ import annotations

from dataclasses import dataclass

from graspdsl.diagnostics import reading
from graspdsl.notation.parser import parse_definition
from graspdsl.notation.printer import to_ascii, to_latex, to_unicode
from graspdsl.notation.tree import Expression, SubjectTo, Then


def parse(text: str) -> Formula:
    """The formula of a text such as ``π_s|Γ Γ (π_gx|Γ Γ)``, in Unicode, in ASCII or in LaTeX.

    Of a definition, ``π_g|Γ Γ ≡ …``, it is what stands on the right. Only its grammar is looked at: what its names
    stand for, a spec or :func:`graspdsl.compile` says. Raises DiagnosticError with the place of every mistake.
    """
    with reading("formula", text):
        return Formula(parse_definition(text)[1])


@dataclass(frozen=True, slots=True, repr=False)
class Formula:
    """A controller as a formula, made by :func:`parse`; ``str()`` is its Unicode spelling.

    Formulas are equal where they say the same, however they were spelt, and ``parse(str(formula)) == formula``.
    """

    tree: Expression

    def subject_to(self, other: Formula | str, *others: Formula | str) -> Formula:
        """``self ◁ other ◁ …``: this formula in the null space of the others, the last of which comes first of all.

        A chain that stands on the left keeps its brackets, ``(a ◁ b) ◁ c``: there ``a`` is projected on the null space
        of ``b``, and the sum of both on that of ``c``. One on the right needs none: ``a ◁ (b ◁ c)`` is ``a ◁ b ◁ c``.
        """
        *between, last = map(_tree, (other, *others))
        highest = last.terms if isinstance(last, SubjectTo) else (last,)
        return Formula(SubjectTo((self.tree, *between, *highest)))

    def then(self, other: Formula | str, *others: Formula | str) -> Formula:
        """``self then other then …``: each runs to convergence, then the next."""
        trees = map(_tree, (self, other, *others))
        return Formula(Then(tuple(step for tree in trees for step in _steps(tree))))

    @property
    def ascii(self) -> str:
        """The formula in ASCII, ``pi_s|G G (pi_gx|G G)``."""
        return to_ascii(self.tree)

    @property
    def latex(self) -> str:
        """The formula in LaTeX's mathematics, ``\\pi_{s}|_{\\Gamma}^{\\Gamma} (\\pi_{gx}|_{\\Gamma}^{\\Gamma})``."""
        return to_latex(self.tree)

    def __str__(self) -> str:
        return to_unicode(self.tree)

    def __repr__(self) -> str:
        return f"parse({str(self)!r})"


def _tree(formula: Formula | str) -> Expression:
    return formula.tree if isinstance(formula, Formula) else parse(formula).tree


def _steps(tree: Expression) -> tuple[Expression, ...]:
    return tree.steps if isinstance(tree, Then) else (tree,)
