"""Explanations for the command line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from graspdsl.cli.inputs import reading, sound
from graspdsl.cli.messages import say

if TYPE_CHECKING:
    from graspdsl.compiler.explain import Explanation


def explanations(what: str) -> list[Explanation]:
    """The explanation of a formula in the default scene, or of every phase of a spec file. Raises InputError."""
    if what.endswith((".yaml", ".yml")) or _is_path(what):
        return _of_spec(Path(what))
    return _of_expression(what)


def _is_path(text: str) -> bool:
    try:
        return Path(text).exists()
    except (OSError, ValueError):  # too long for a path, or with a null character
        return False


def _of_expression(text: str) -> list[Explanation]:
    from graspdsl.compiler.declarations import default_scene
    from graspdsl.compiler.explain import explained
    from graspdsl.compiler.program import default_target, examine_expression

    with reading("expression", text):
        phase, _ = examine_expression(text)
    scene = default_scene()
    resources = ", ".join(f"{entry.key.text} = {entry.value.text}" for entry in scene.resources)
    say(f"outside a spec: the hand {scene.hand.text} on the mount {scene.mount.text}, {resources}")
    return [explained(phase, default_target())]


def _of_spec(path: Path) -> list[Explanation]:
    from graspdsl.compiler.explain import explained
    from graspdsl.compiler.settings import Target

    program, _ = sound(path)
    target = Target(program.robot, program.world.rate, program.spec.control)
    return [explained(phase, target) for phase in program.phases]
