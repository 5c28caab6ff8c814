"""Packages and files of others on the command line, held against the contracts of what they bring."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout, suppress
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from graspdsl.cli.messages import WRONG_INPUT, complain, result, result_json
from graspdsl.contracts.kinds import CONTRACTS, breaches
from graspdsl.diagnostics import (
    Diagnostic,
    DiagnosticError,
    Severity,
    has_errors,
    known_names_hint,
    on_one_line,
    reading,
)
from graspdsl.places.folders import SUFFIXES
from graspdsl.plugins.adoption import tried, tried_file
from graspdsl.plugins.kinds import KINDS, Key, Offer, offered
from graspdsl.report.wording import counted


@dataclass(frozen=True, slots=True)
class Checked:
    """A thing that was checked, where it is, and what is wrong with it."""

    key: Key
    place: str
    faults: tuple[Diagnostic, ...]

    @property
    def verdict(self) -> str:
        """In words: of how many rules it breaks none, or how much is wrong."""
        wrong = [fault for fault in self.faults if fault.severity is Severity.ERROR]
        warned = len(self.faults) - len(wrong)
        said = counted(len(wrong), "fault", "faults") if wrong else f"ok, {len(CONTRACTS[self.key[0]])} rules"
        return f"{said}, {counted(warned, 'warning', 'warnings')}" if warned else said

    def as_dict(self) -> dict[str, object]:
        """Its entry in the JSON document."""
        kind, name = self.key
        diagnostics = [fault.as_dict() for fault in self.faults]
        ok = not has_errors(self.faults)
        return {"kind": kind, "name": name, "place": self.place, "ok": ok, "diagnostics": diagnostics}


def check_plugin(what: str, as_json: bool) -> int:
    """Check what a distribution or a file brings, and show it. Returns the exit code."""
    with reading(what):
        is_file = Path(what).suffix in (".py", *SUFFIXES)
        found = _in_file(Path(what)) if is_file else [_checked(offer) for offer in _offers(what)]
    sound = not any(has_errors(each.faults) for each in found)
    if as_json:
        result_json({"plugin": what, "ok": sound, "entries": [each.as_dict() for each in found]})
    else:
        for each in found:
            kind, name = each.key
            result(on_one_line(f"{KINDS[kind].what} {name} ({each.place}): {each.verdict}"))
            complain(what, "", each.faults, sys.stdout)
    return 0 if sound else WRONG_INPUT


def _checked(offer: Offer) -> Checked:
    faults = tried(offer)
    if not has_errors(faults):
        faults += _breaches((offer.kind, offer.name))
    return Checked((offer.kind, offer.name), offer.value, faults)


def _in_file(path: Path) -> list[Checked]:
    found = tried_file(path)
    return [
        Checked(key, path.name, faults if has_errors(faults) else (*faults, *_breaches(key)))
        for key, faults in found.items()
    ]


def _breaches(key: Key) -> tuple[Diagnostic, ...]:
    with redirect_stdout(sys.stderr):  # whatever the things print
        return tuple(breaches(*key))


def _offers(distribution: str) -> Sequence[Offer]:
    """What a distribution offers. Raises DiagnosticError where there is none of that name, or it offers nothing."""
    found = [offer for offer in offered() if _alike(offer.distribution, distribution)]
    if found:
        return found
    installed = list[str]()
    for each in metadata.distributions():
        with suppress(Exception):  # one whose metadata cannot be read
            installed.append(str(each.metadata["Name"]))
    if not any(_alike(name, distribution) for name in installed):
        hint = known_names_hint(distribution, installed, "packages")
        raise DiagnosticError([Diagnostic("unknown-plugin", f"no package {distribution!r} is installed", hint=hint)])
    groups = ", ".join(f"graspdsl.{kind}" for kind in KINDS)
    message = f"{distribution} offers nothing to graspdsl: it has no entry point in any of its groups"
    raise DiagnosticError([Diagnostic("nothing-offered", message, hint=f"the groups are {groups}")])


def _alike(name: str, other: str) -> bool:
    """Whether two names are of one distribution."""
    first, second = (re.sub(r"[-_.]+", "-", each).lower() for each in (name, other))
    return first == second
