"""Explanations for the command line."""

from __future__ import annotations

import re
from dataclasses import asdict
from pathlib import Path
from textwrap import indent
from typing import TYPE_CHECKING

from graspdsl.cli.inputs import place_of_shipped, sound
from graspdsl.cli.messages import printable, result, result_json, say
from graspdsl.diagnostics import reading

if TYPE_CHECKING:
    from graspdsl.compiler.explain import Explanation


CODE = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")


def explanations(what: str, *, allow_code: bool = False) -> list[Explanation]:
    """The explanation of a formula in the default scene, or of every phase of a spec file. Raises DiagnosticError."""
    if what.endswith((".yaml", ".yml")) or _is_path(what) or place_of_shipped(what):
        return _of_spec(Path(what), allow_code=allow_code)
    return _of_expression(what)


def show_complaint(code: str, as_json: bool) -> bool:
    """Print what the code of a complaint means, with its examples; False, and nothing, for what is no code."""
    if not CODE.fullmatch(code) or _is_path(code):
        return False
    from graspdsl.reference.diagnostics import FORMS, examples, rules

    example, law = examples().get(code), rules().get(code)
    if example is None and law is None:
        return False
    if as_json:
        shown = asdict(example) if example else {"code": code, "means": law}
        result_json({"diagnostic": shown})
    elif example is None:
        result(f"{code}: {law}")
    else:
        texts = (
            f"{name}:\n{indent(text, '    ')}" for name, text in (("wrong", example.wrong), ("right", example.right))
        )
        head = f"{example.severity.value}[{code}]: {example.means} ({FORMS[example.form]})"
        result(printable("\n\n".join([head, *texts])))
    return True


def _is_path(text: str) -> bool:
    try:
        return Path(text).exists()
    except (OSError, ValueError):  # too long for a path, or with a null character
        return False


def _of_expression(text: str) -> list[Explanation]:
    from graspdsl.compiler.assumed import assumed_around
    from graspdsl.compiler.explain import explained
    from graspdsl.compiler.program import program_of_expression
    from graspdsl.compiler.surroundings import USUAL
    from graspdsl.notation.parser import parse_definition
    from graspdsl.notation.printer import to_unicode

    with reading("expression", text):
        head, tree = parse_definition(text)
        program = program_of_expression(text, assumed_around(tree, USUAL))
    scene = program.spec.scene
    if head is not None:
        say(f"a definition of {to_unicode(head)}, and what it stands for:")
    resources = ", ".join(f"{name} = {meaning}" for name, meaning in program.spec.resources.items())
    ways = [f"{name} = 0" for name, value in program.spec.parameters.items() if isinstance(value, tuple)]
    ways += ["the object held"] if scene.held else []
    ways += ["displaced by probing"] if program.probes else []
    say(f"outside a spec: {', '.join([f'the hand {scene.hand} on the mount {scene.mount}', resources, *ways])}")
    return list(explained(program))


def _of_spec(path: Path, *, allow_code: bool) -> list[Explanation]:
    from graspdsl.compiler.explain import explained

    return list(explained(sound(path, allow_code=allow_code)))
