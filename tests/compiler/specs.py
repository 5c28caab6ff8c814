"""The spec that the tests start from, made of its parts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graspdsl.compiler.program import Program, program_of

FLOATING = "world: floating, hand: points"
POINTS = {"γ1": "point-1", "γ2": "point-2", "γ3": "point-3"}
RESOURCES = {"γ1": "finger-3", "γ2": "finger-1", "γ3": "finger-2", "Γ": '"{γ1, <γ2, γ3>}"'}


def spec(
    *formulas: str,
    scene: str = "world: bullet, hand: barrett, object: towel-roll",
    resources: Mapping[str, str] | None = None,
    parameters: str = "κ_f: 0.5",
    controllers: Mapping[str, str] | None = None,
    until: str = "contact: all",
    control: str = "",
    start: str = "",
    monitors: str = "",
    evaluate: str = "",
    grading: str = "",
) -> str:
    """The text of a spec without a fault, but for what is given."""
    lines = ["graspdsl: 1", "name: test", f"scene: {{{scene}}}", "resources:"]
    lines += [f"  {name}: {meaning}" for name, meaning in {**RESOURCES, **(resources or {})}.items()]
    lines += [f"parameters: {{{parameters}}}"]
    lines += ["controllers:"] if controllers else []
    lines += [f"  {head}: {body}" for head, body in (controllers or {}).items()]
    lines += [f"control: {{{control}}}", "program:"]
    for formula in formulas or ("π_s|Γ Γ (π_gx|Γ Γ)",):
        lines += [f"  - run: {formula}", f"    until: {{{until}}}"]
    lines += [f"trials: {{start: {{{start}}}}}"] if start else []
    lines += [f"monitors: {{{monitors}}}"] if monitors else []
    lines += [f"evaluate: [{evaluate}]"] if evaluate else []
    lines += [f"grading: {{{grading}}}"] if grading else []
    return "\n".join(lines) + "\n"


def floating(*formulas: str, scene: str = "object: ball", **parts: Any) -> str:
    """The text of a spec of floating contacts without a fault, but for what is given."""
    parts["resources"] = {**POINTS, **parts.get("resources", {})}
    return spec(*(formulas or ("π_gx|Γ Γ",)), scene=f"{FLOATING}, {scene}", **parts)


def program(formula: str, control: str = "", **parts: str) -> Program:
    """The program of one formula."""
    return program_of(spec(formula, control=control, **parts), "test.yaml")
