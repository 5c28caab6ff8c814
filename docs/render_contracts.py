"""Fill in the pages of docs/contracts what files of the project have: examples, entry points and rules.

A comment in a page says what stands below it: ``<!-- file: sensor.py -->`` a file of the stranger's package,
``<!-- project: pyproject.toml -->`` one beside it, ``<!-- offers: sensors -->`` what that offers of a kind,
``<!-- rules: sensors -->`` the rules of a kind, ``<!-- table: laws -->`` what there is to choose from.
Run it with the package installed: python docs/render_contracts.py
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable
from pathlib import Path

from graspdsl.basis import laws, spaces
from graspdsl.contracts.kinds import CONTRACTS
from graspdsl.diagnostics import Severity

PAGES = Path(__file__).resolve().parent / "contracts"
STRANGER = PAGES.parents[1] / "tests" / "plugin"
# What is marked: a block of code, a table, or nothing yet.
MARKED = re.compile(
    r"<!-- (file|project|offers|rules|table): (\S+) -->\n(?:(```+)\w*\n.*?^\3\n|\n(?:\|[^\n]*\n)+|)", flags=re.S | re.M
)
LANGUAGES = {".py": "python", ".yaml": "yaml", ".urdf": "xml", ".xml": "xml", ".toml": "toml", ".obj": "text"}


def rendered(page: str) -> str:
    """The text of a page with all that is marked filled in."""
    made = {"file": _example, "project": _project, "offers": _offers, "rules": _rules, "table": _choice}

    def fill(found: re.Match[str]) -> str:
        return f"<!-- {found[1]}: {found[2]} -->\n{made[found[1]](found[2])}"

    return MARKED.sub(fill, page)


def _example(name: str) -> str:
    path = STRANGER / "src" / "graspdsl_stranger" / name
    return _code(LANGUAGES[path.suffix], path.read_text("utf-8"))


def _project(name: str) -> str:
    return _code(LANGUAGES[Path(name).suffix], (STRANGER / name).read_text("utf-8"))


def _offers(kind: str) -> str:
    tables = (STRANGER / "pyproject.toml").read_text("utf-8").split("\n\n")
    [table] = [table for table in tables if table.startswith(f'[project.entry-points."graspdsl.{kind}"]')]
    return _code("toml", table.rstrip("\n") + "\n")


def _code(language: str, text: str) -> str:
    return f"```{language}\n{text}```\n"


def _rules(kind: str) -> str:
    rules = CONTRACTS[kind].items()
    warns = {Severity.WARNING: " (a warning)", Severity.ERROR: ""}
    return _table("rule", "what it asks", ((code, _first(rule.check) + warns[rule.severity]) for code, rule in rules))


def _choice(of: str) -> str:
    if of == "spaces":
        found = {name: each for name, each in vars(spaces).items() if isinstance(each, spaces.TaskSpace)}
        return _table("space", "its errors (unit)", ((name, space.about) for name, space in found.items()))
    known = {name: law for name, law in vars(laws).items() if inspect.isclass(law) and law.__base__ is laws.Law}
    return _table("law", "what it commands", ((name, _first(law)) for name, law in known.items()))


def _first(thing: object) -> str:
    return " ".join((thing.__doc__ or "").partition("\n\n")[0].replace("``", "`").split())


def _table(name: str, what: str, rows: Iterable[tuple[str, str]]) -> str:
    lines = [f"| {name} | {what} |", "|---|---|", *(f"| `{first}` | {second} |" for first, second in rows)]
    return "\n" + "\n".join(lines) + "\n"


def main() -> None:
    """Write the pages."""
    for path in PAGES.glob("*.md"):
        path.write_text(rendered(path.read_text("utf-8")), "utf-8")


if __name__ == "__main__":
    main()
