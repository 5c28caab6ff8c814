"""What the numbers of a trial depend on, as a hash, and whether a run's trials came from what its folder holds."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from importlib import metadata

from graspdsl.compiler.program import Program
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity
from graspdsl.places.files import digest_of
from graspdsl.trials.store import MANIFEST, SPEC, RunFolder

LIBRARIES = ("graspdsl", "numpy", "pybullet", "scipy")
FILE_READERS = ("trimesh", "vhacdx")  # on which an object from a file depends, too


def versions(*, readers: bool) -> dict[str, str]:
    """The versions of what a trial's numbers depend on, with those of the readers of files where it needs them."""
    return {name: metadata.version(name) for name in (*LIBRARIES, *(FILE_READERS if readers else ()))}


def identities(program: Program, seed: int, made_by: Mapping[str, str] | None = None) -> Callable[[int], str]:
    """The identities of a program's trials, by their numbers, as made by these versions, or by those that are here.

    Each is a hash of all that a trial's numbers depend on: the spec, the trial number, the seed and the versions.
    """
    spec = program.spec.model_dump(mode="json", exclude={"trials": {"count", "seed"}, "name": True, "about": True})
    made_by = made_by or versions(readers=bool(program.files))
    before = [spec, program.monitors.model_dump(mode="json")]
    after: list[object] = [seed, {name: made_by.get(name) for name in LIBRARIES}]
    if program.files:
        after += [digest_of(program.files), {name: made_by.get(name) for name in FILE_READERS}]
    first, last = (json.dumps(parts, sort_keys=True) for parts in (before, after))

    def of(number: int) -> str:
        return hashlib.sha256(f"{first[:-1]}, {number}, {last[1:]}".encode()).hexdigest()[:16]

    return of


def check_origin(folder: RunFolder, program: Program) -> list[Diagnostic]:
    """Whether the trials of a run were made from the spec, the files and the seed that its folder holds, by whatever
    versions of the libraries. Returns a warning where another graspdsl made them: its specs may mean other things.

    Raises DiagnosticError when they were not.
    """
    manifest, trials = folder.manifest, program.spec.trials
    if (manifest.name, manifest.seed, manifest.asked) != (program.spec.name, trials.seed, trials.count):
        raise DiagnosticError([other_origin()])
    here = versions(readers=bool(program.files))
    if manifest.versions.get("graspdsl") != here["graspdsl"] or not here.keys() <= manifest.versions.keys():
        by = f"graspdsl {manifest.versions.get('graspdsl', 'of no known version')}"
        message = f"this run was made by {by}; whether from the {SPEC} in it cannot be told by {here['graspdsl']}"
        return [Diagnostic("run-unchecked", message, severity=Severity.WARNING)]
    known = [identities(program, manifest.seed, made_by) for made_by in (manifest.versions, here)]
    if any(record.identity not in {of(record.number) for of in known} for record in folder.records()):
        raise DiagnosticError([other_origin()])
    return []


def other_origin() -> Diagnostic:
    """The complaint about a folder whose trials came from something else."""
    message = "this run was made from another spec, other files or another seed than it holds now"
    hint = f"put its own {SPEC}, {MANIFEST} and files back, or begin a new run"
    return Diagnostic("run-differs", message, hint=hint)
