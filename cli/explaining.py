"""Explanations for the command line, with complaints about what cannot be explained."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from graspdsl.cli.messages import complain

from graspdsl.diagnostics import DiagnosticError

if TYPE_CHECKING:
    from graspdsl.compiler.explain import Explanation


def explanations_of_expression(text: str) -> list[Explanation] | None:
    """The explanation of a formula in the default scene; None after complaints."""
    from graspdsl.compiler.explain import explained
    from graspdsl.compiler.program import default_target, examine_expression

    try:
        phase, _ = examine_expression(text)
    except DiagnosticError as error:
        complain("expression", text, error.diagnostics)
        return None
    return [explained(phase, default_target())]


def explanations_of_spec(path: Path) -> list[Explanation] | None:
    """The explanations of a spec's phases; None after complaints."""
    from graspdsl.compiler.explain import explained
    from graspdsl.compiler.program import examine
    from graspdsl.compiler.settings import Target
    from graspdsl.spec.files import read_text

    try:
        source = read_text(path)
    except DiagnosticError as error:
        complain(str(path), "", error.diagnostics)
        return None
    examination = examine(source, path.name)
    complain(str(path), source, examination.diagnostics)
    program = examination.program
    if program is None:
        return None
    target = Target(program.robot, program.world.rate, program.spec.control)
    return [explained(phase, target) for phase in program.phases]
