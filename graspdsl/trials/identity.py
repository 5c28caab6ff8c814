"""What the numbers of a trial depend on, as a hash, and whether a run's trials came from what its folder holds."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple
from importlib import metadata
from typing import Any

from graspdsl.compiler.program import Program
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity, listed
from graspdsl.places.files import digest_of
from graspdsl.plugins.kinds import Plugin
from graspdsl.trials.store import MANIFEST, SPEC, RunFolder

LIBRARIES = ("graspdsl", "numpy", "scipy")
FILE_READERS = ("mujoco", "trimesh", "vhacdx")  # on which what is read from a file depends, too
UNTOLD: dict[str, Any] = {
    "trials": {"count", "seed", "keep", "wall_limit"},
    "name": True,
    "about": True,
    "code": True,
    "sweep": True,
}  # of a spec


def versions(program: Program) -> dict[str, str]:
    """The versions of what the numbers of a program's trials depend on: those libraries of its world and its backend
    among them that are installed, and the readers of hands, mounts and objects where some are from files."""
    world, backend = program.world, program.target.backend
    engines = {*world.libraries, *backend.libraries} - {*world.missing, *backend.missing}
    names = {*LIBRARIES, *engines, *(FILE_READERS if program.files else ())}
    return {name: metadata.version(name) for name in sorted(names)}


def identities(
    program: Program, seed: int, made_by: Mapping[str, str] | None = None, plugins: Sequence[Plugin] | None = None
) -> Callable[[int], str]:
    """The identities of a program's trials, by their numbers, as made by these versions and with these plug-ins, or by
    those that are here.

    Each is a hash of all that a trial's numbers depend on: the spec, the trial number, the seed, the versions and what
    other packages, or the spec's own code, have a part in it. A trial of a sweep has that of the same trial of the spec
    that its point is.
    """
    if program.points:
        return _identities_over(program, seed, made_by, plugins)
    spec = program.spec.model_dump(mode="json", exclude=UNTOLD, warnings=False)  # of keys that came since
    made_by = made_by or versions(program)
    before = [spec, program.monitors.model_dump(mode="json", warnings=False)]
    of_files_alone = set(FILE_READERS) - program.world.libraries.keys()
    after: list[object] = [seed, {name: by for name, by in made_by.items() if name not in of_files_alone}]
    if program.files:
        after += [digest_of(program.files), {name: made_by.get(name) for name in FILE_READERS}]
    if plugins := program.plugins if plugins is None else plugins:
        after += [list(map(astuple, plugins))]
    first, last = (json.dumps(parts, sort_keys=True) for parts in (before, after))

    def of(number: int) -> str:
        return hashlib.sha256(f"{first[:-1]}, {number}, {last[1:]}".encode()).hexdigest()[:16]

    return of


def _identities_over(
    program: Program, seed: int, made_by: Mapping[str, str] | None, plugins: Sequence[Plugin] | None
) -> Callable[[int], str]:
    known = dict[int, Callable[[int], str]]()

    def of(number: int) -> str:
        at, own = program.of_trial(number)
        point = (number - own) // program.spec.trials.count
        if point not in known:
            known[point] = identities(at, seed, made_by, plugins)
        return known[point](own)

    return of


def at_one_point(program: Program, known_by: Mapping[int, str]) -> Mapping[int, str]:
    """Of the trials of a program with their identities those that tell whether all came from it: of a sweep, whose
    points are all made from one spec, those at the point of the first."""
    if not program.points:
        return known_by
    point = min(known_by, default=0) // program.spec.trials.count
    return {number: one for number, one in known_by.items() if number // program.spec.trials.count == point}


def check_origin(folder: RunFolder, program: Program, known_by: Mapping[int, str] | None = None) -> list[Diagnostic]:
    """Whether the trials of a run were made from the spec, the files and the seed that its folder holds, by whatever
    versions of the libraries. Returns a warning where another graspdsl made them: its specs may mean other things.

    known_by: the identities of these trials, by default those of all that are in the table.

    Raises DiagnosticError when they were not.
    """
    manifest, trials = folder.manifest, program.spec.trials
    made_from = manifest.name, manifest.seed, manifest.asked, manifest.points
    if made_from != (program.spec.name, trials.seed, program.trials, program.points):
        raise DiagnosticError([other_origin()])
    here = versions(program)
    if manifest.versions.get("graspdsl") != here["graspdsl"] or not here.keys() <= manifest.versions.keys():
        by = f"graspdsl {manifest.versions.get('graspdsl', 'of no known version')}"
        message = f"this run was made by {by}; whether from the {SPEC} in it cannot be told by {here['graspdsl']}"
        return [Diagnostic("run-unchecked", message, severity=Severity.WARNING)]
    made = (manifest.versions, manifest.plugins), (here, program.plugins)
    known = [identities(program, manifest.seed, *by) for by in made]
    known_by = at_one_point(program, folder.identities() if known_by is None else known_by)
    if any(identity not in {of(number) for of in known} for number, identity in known_by.items()):
        raise DiagnosticError([other_origin()])
    before, now = other_plugins(manifest.plugins, program.plugins)
    if now:
        message = (
            f"this run was made with {listed(before)}; now there is {listed(now)}: what is worked out anew may differ"
        )
        return [Diagnostic("run-unchecked", message, severity=Severity.WARNING)]
    return []


def other_plugins(made_with: Sequence[Plugin], here: Sequence[Plugin]) -> tuple[list[str], list[str]]:
    """Of the plug-ins that a run was made with and those that are here, what is no longer the same, before and now."""
    known = {(plugin.kind, plugin.name): plugin for plugin in made_with}
    before, now = list[str](), list[str]()
    for plugin in here:
        other = known.get((plugin.kind, plugin.name), plugin)
        if other != plugin:
            before.append(other.by)
            now.append(plugin.by if other.by != plugin.by else f"{plugin.by} with another {plugin.name}")
    return list(dict.fromkeys(before)), list(dict.fromkeys(now))


def other_origin() -> Diagnostic:
    """The complaint about a folder whose trials came from something else."""
    message = "this run was made from another spec, other files or another seed than it holds now"
    hint = f"put its own {SPEC}, {MANIFEST} and files back, or begin a new run"
    return Diagnostic("run-differs", message, hint=hint)
