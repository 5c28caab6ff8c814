"""A spec on several engines, time steps and solver efforts: all runs, then whether they say the same."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import RenderableType
from rich.text import Text

from graspdsl.cli.inputs import sound
from graspdsl.cli.messages import result, result_json, say, writable
from graspdsl.cli.several import Asked, Part, folder_for, run_each
from graspdsl.cli.tables import laid_out, text_of
from graspdsl.compiler.program import Program, program_of
from graspdsl.diagnostics import Diagnostic, DiagnosticError, known_names_hint, listed, on_one_line, reading
from graspdsl.places.document import parse_document
from graspdsl.report.agreement import Known
from graspdsl.report.engines import (
    METHODS,
    Engines,
    agreement_tables,
    engines,
    outcomes_table,
    runs_table,
    said_of,
)
from graspdsl.report.engines_page import write_engines
from graspdsl.report.summary import plain
from graspdsl.trials.variants import Variant, variants, worlds_to_vary
from graspdsl.worlds.kinds import WORLDS, absence


def run_engines(asked: Asked, worlds: Sequence[str] | None, *, finer: bool) -> int:
    """Run a spec in all ways, each into a folder of its own, and say which agree. Returns the exit code.

    worlds: None for that of the spec and every other one that can. finer: at half and twice the time step and effort,
    too. Every way is checked before the first one runs.
    """
    spec = asked.specs[0]
    program = sound(spec, asked.overrides, allow_code=asked.allow_code)
    chosen = _chosen(program, spec, worlds)
    efforts = [(name, WORLDS[name].effort_in(program.spec.scene.physics)) for name in chosen]
    ways = variants([(name, effort) for name, effort in efforts if effort is not None], finer=finer)
    if len(ways) < 2:
        message = f"there is nothing to hold the {chosen[0]} world against"
        raise DiagnosticError([Diagnostic("one-engine", message, hint="name two with --worlds, or leave --plain out")])
    parts = [_part(way, spec, program) for way in ways]
    with folder_for(parts, asked) as whole:
        known: list[Known] = []
        if code := run_each(parts, whole, asked, lambda _, run: known.append((run.evidence, run.summary))):
            return code
        found = engines(ways, known, asked.settings)
        page = write_engines(whole, found)
    if asked.as_json:
        result_json({**plain(found), "folder": str(whole)})
    else:
        result(engines_text(found))
    say(f"report: {on_one_line(str(page))}")
    return 0


def _part(way: Variant, spec: Path, program: Program) -> Part:
    source = program.source
    with reading(str(spec), source.text):
        return Part(way.name, spec, program_of(*source._replace(overrides=(*source.overrides, *way.settings))))


def _chosen(program: Program, spec: Path, worlds: Sequence[str] | None) -> list[str]:
    """The worlds to run in, the measure first."""
    own = program.spec.scene.world
    for name in worlds or (own,):
        if (fault := _fault(name)) is not None:
            document = parse_document(program.source.text, spec.name)
            span = document.span(("scene", "world")) if worlds is None else None
            raise DiagnosticError([replace(fault, span=span)], str(spec), program.source.text)
    return list(dict.fromkeys(worlds or (own, *worlds_to_vary())))


def _fault(name: str) -> Diagnostic | None:
    """Why a world cannot be run in several ways, if it cannot."""
    kind = WORLDS.get(name)
    if kind is None:
        hint = known_names_hint(name, worlds_to_vary(), "engines")
        return Diagnostic("unknown-world", f"there is no engine {name!r}", hint=hint)
    if kind.effort is None:
        message = f"the {name} world has no physics to be worked out in other ways"
        return Diagnostic("no-engine", message, hint=f"use {listed(worlds_to_vary(), 'or')}")
    return absence(kind)


def engines_text(found: Engines) -> str:
    """All of it laid out for the terminal that stdout is."""
    head = ", ".join([f"{found.name}, seed {found.seed}", shlex.join(found.settings)]).rstrip(", ")
    parts: list[RenderableType] = [Text(writable(on_one_line(head)), style="bold")]
    for made in (runs_table(found), *agreement_tables(found), outcomes_table(found)):
        parts += ["", laid_out(made)]
    return text_of([*parts, "", Text(writable(said_of(found))), "", Text(writable(METHODS))])
