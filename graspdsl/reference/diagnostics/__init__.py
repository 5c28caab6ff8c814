"""Every complaint by its code: what it means, a wrong example that gets it and a right one that does not.

The examples are data in the files beside this one, a file a page's section. Whoever adds a code adds its example: the
tests look for the codes in the source.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from graspdsl.contracts.kinds import CONTRACTS
from graspdsl.diagnostics import Severity
from graspdsl.places.data_files import data_in

HERE = Path(__file__).parent
SECTIONS = ("formulas", "specs", "worlds", "models", "objects", "commands", "plugins")
FORMS = {
    "formula": "a formula",
    "spec": "a part of a spec",
    "spec file": "a spec",
    "setting": "a value for --set",
    "hand file": "in a hand file",
    "hand URDF": "in the URDF of a hand",
    "hand MJCF": "in the MJCF of a hand",
    "mount file": "in a mount file",
    "object URDF": "the URDF of an object",
    "object OBJ": "an OBJ file",
    "command": "a command",
    "Python": "Python",
    "words": "in words",
}


@dataclass(frozen=True, slots=True)
class Example:
    """A code, what it means, and texts that get it and that do not; ``form``: of what they are, one of ``FORMS``.

    Of a file of which a line is shown, the other lines are sound. ``section``: the title that it stands under.
    ``severity``: of the complaint about the wrong text; of a code that can be both, the one shown here.
    """

    code: str
    means: str
    form: str
    wrong: str
    right: str
    severity: Severity
    section: str


@cache
def examples() -> Mapping[str, Example]:
    """Every code's example, by the code, section by section."""
    found = {}
    for name in SECTIONS:
        read = data_in(HERE / f"{name}.yaml")
        for code, said in read["diagnostics"].items():
            found[code] = Example(
                code,
                said["means"],
                said.get("in") or read["in"],
                said["wrong"].rstrip("\n"),
                said["right"].rstrip("\n"),
                Severity(said.get("severity", "error")),
                read["title"],
            )
    return found


def rules() -> Mapping[str, str]:
    """The codes of contracts, which are the names of their rules: what each asks, and of what kinds of things."""
    asked: dict[str, str] = {}
    for kind, contract in CONTRACTS.items():
        for code, rule in contract.items():
            law = " ".join((rule.check.__doc__ or "").split())
            asked[code] = f"{asked[code]}, {kind}" if code in asked else f"{law} ({kind}"
    return {code: f"{said})" for code, said in asked.items()}
