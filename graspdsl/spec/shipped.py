"""The specs that ship with the package: by their names, by equations of the chapter, or by its experiments."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

from graspdsl.diagnostics import known_names_hint
from graspdsl.places.files import refusal

PLACE = "graspdsl.specs"
CHAPTER = "chapter"  # the folder of specs that show an equation each
_SAID = re.compile(r'^(name|about): *"?(.*?)"?$', re.MULTILINE)
_SCHEMA = re.compile(r"\A# yaml-language-server:.*\n")  # which is beside the specs, not beside a copy
_EQUATIONS = re.compile(r"Eq\. (4\.\d+)(?: and (4\.\d+))?")
_ABOUT = re.compile(r"Experiment \d|Sec\. [\d.]+\d")


@dataclass(frozen=True, slots=True)
class ShippedSpec:
    """A spec by its name, with the equations or the experiment of the chapter that it is about, one line, its text but
    for the schema that it names, and its file; ``shows``: the equations that it is there to show."""

    name: str
    equation: str
    about: str
    text: str
    place: Path
    shows: tuple[str, ...] = ()


@cache
def shipped_specs() -> dict[str, ShippedSpec]:
    """The specs that ship, by name, but for those of hands whose models do not."""
    found = {}
    entries = sorted(_files(files(PLACE), ""), key=lambda entry: (entry[0] != CHAPTER, entry[0], entry[1].name))
    for folder, file in entries:
        place = Path(str(file))
        text = _SCHEMA.sub("", file.read_text(encoding="utf-8"))
        said = dict(_SAID.findall(text.partition("\nscene:")[0]))
        if "name" not in said or re.search(r"^  hand: .*\.yaml", text, re.MULTILINE):
            continue
        equations = tuple(number for pair in _EQUATIONS.findall(said["about"]) for number in pair if number)
        about = ", ".join(equations) or next(iter(_ABOUT.findall(said["about"])), "")
        shows = equations if folder == CHAPTER else ()
        found[said["name"]] = ShippedSpec(said["name"], about, said["about"], text, place, shows)
    return found


def shipped(wanted: str) -> ShippedSpec:
    """The spec of a name, of an equation (4.26) or of an experiment (experiment 2). Raises DiagnosticError for none."""
    known = shipped_specs()
    name = re.sub(r"[ _]+", "-", wanted.strip())
    number = wanted.strip().lower().removeprefix("eq").strip(" .()")
    found = known.get(name) or known.get(name.lower())
    found = found or next((spec for spec in known.values() if number in spec.shows), None)
    if found is None:
        equations = sorted({number for spec in known.values() for number in spec.shows})
        is_number = re.fullmatch(r"[\d.]+", number)
        hint = f"there are specs of {', '.join(equations)}" if is_number else known_names_hint(name, known, "specs")
        raise refusal("unknown-spec", f"no spec that ships is called {wanted!r}", f"{hint}; see: graspdsl list specs")
    return found


def _files(place: Traversable, folder: str) -> Iterator[tuple[str, Traversable]]:
    for entry in place.iterdir():
        if entry.is_dir():
            yield from _files(entry, entry.name)
        elif entry.name.endswith(".yaml"):
            yield folder, entry
