"""Explanations for the command line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from graspdsl.cli.inputs import sound
from graspdsl.cli.messages import say
from graspdsl.diagnostics import reading

if TYPE_CHECKING:
    from graspdsl.compiler.explain import Explanation


def explanations(what: str, *, allow_code: bool = False) -> list[Explanation]:
    """The explanation of a formula in the default scene, or of every phase of a spec file. Raises DiagnosticError."""
    if what.endswith((".yaml", ".yml")) or _is_path(what):
        return _of_spec(Path(what), allow_code=allow_code)
    return _of_expression(what)


def _is_path(text: str) -> bool:
    try:
        return Path(text).exists()
    except (OSError, ValueError):  # too long for a path, or with a null character
        return False


def _of_expression(text: str) -> list[Explanation]:
    from graspdsl.compiler.explain import explained
    from graspdsl.compiler.program import program_of_expression

    with reading("expression", text):
        program = program_of_expression(text)
    scene = program.spec.scene
    resources = ", ".join(f"{name} = {meaning}" for name, meaning in program.spec.resources.items())
    ways = ["the object held"] if scene.held else []
    ways += ["displaced by probing"] if program.probes else []
    say(f"outside a spec: {', '.join([f'the hand {scene.hand} on the mount {scene.mount}', resources, *ways])}")
    return list(explained(program))


def _of_spec(path: Path, *, allow_code: bool) -> list[Explanation]:
    from graspdsl.compiler.explain import explained

    return list(explained(sound(path, allow_code=allow_code)))
