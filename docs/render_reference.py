"""Write docs/reference: what there is to write with, from the tables, models, docstrings and the grammar themselves.

Run it with the package and its developers' tools installed: python docs/render_reference.py
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import railroad

from graspdsl.notation.parser import parse_expression
from graspdsl.notation.printer import to_ascii
from graspdsl.reference import grammar
from graspdsl.reference.diagnostics import FORMS, Example, examples, rules
from graspdsl.reference.keys import BELOW, NEEDED, Key, Part, parts
from graspdsl.reference.kinds import KINDS

if TYPE_CHECKING:
    from lark import Token, Tree

PLACE = Path(__file__).resolve().parent / "reference"
MADE = "Made by `docs/render_reference.py`."
# A page of tables: its title, what it begins with, and the kinds that it shows under their headings.
PAGES: Mapping[str, tuple[str, str, Mapping[str, str]]] = {
    "names": (
        "Names",
        "What a spec may name. `graspdsl list KIND` shows the same in a terminal, with what packages bring.\n\n"
        "Resources name contacts of the hand; effectors and sensors of joints name a joint set of the hand or of its "
        "mount, a single joint of either, or `all` of them.",
        {
            "hands": "Hands",
            "mounts": "Mounts",
            "objects": "Objects",
            "shapes": "Shapes",
            "worlds": "Worlds",
            "sensing": "Touch sensors",
            "approaches": "Approaches",
            "starts": "Numbers of a start",
            "conditions": "End conditions",
            "monitors": "Monitors",
            "outcomes": "Outcomes",
            "grades": "Grades",
            "specs": "Specs that ship",
        },
    ),
    "controllers": (
        "Controllers and what they are made of",
        "Numbers of equations are those of the chapter. `graspdsl explain` shows what a formula means.",
        {
            "controllers": "Controllers of the prelude",
            "potentials": "Potentials",
            "sensors": "Sensor transforms",
            "effectors": "Effector transforms",
            "spaces": "Gradient spaces",
        },
    ),
}
CODE_COLUMNS = {"name", "key", "controller", "stands for", "in ASCII", "default", "sensors", "effectors", "references"}
LANGUAGES = {"Python": "python", "command": "sh", "words": "text", "formula": "text", "setting": "text"}
STYLE = """\
svg.railroad-diagram path { stroke-width: 2; stroke: #5a636d; fill: none; }
svg.railroad-diagram text { font: 14px monospace; text-anchor: middle; fill: #23292f; }
svg.railroad-diagram rect { stroke-width: 2; stroke: #5a636d; fill: #eef1f4; }
svg.railroad-diagram g.terminal rect { fill: #d9e8f6; }
"""


def pages() -> dict[str, str]:
    """The text of every file of the folder by its path there: pages, and diagrams."""
    made = {"spec.md": _spec(), "grammar.md": _grammar(), "diagnostics.md": _diagnostics()}
    for name, (title, about, kinds) in PAGES.items():
        made[f"{name}.md"] = "\n".join([f"# {title}", "", f"{about} {MADE}", "", *_kinds(kinds)])
    shown = {f"grammar/{rule.name}.svg": _diagram(rule) for rule in grammar.rules() if not rule.is_word}
    return {"index.md": _index(), **made, **shown}


def _index() -> str:
    links = {
        "[spec](spec.md)": "every key of a spec, with its type, unit, default and values",
        "[names](names.md)": "hands with their contacts and joint sets, mounts, objects, worlds, touch, outcomes",
        "[controllers](controllers.md)": "the prelude's controllers, potentials, sensors, effectors and spaces",
        "[grammar](grammar.md)": "how formulas are written, as EBNF and as diagrams, with examples",
        "[diagnostics](diagnostics.md)": "every complaint by its code, with a wrong and a right example",
    }
    kinds = ({"in the terminal": f"`graspdsl list {kind}`", "what it shows": of.about} for kind, of in KINDS.items())
    return "\n".join(
        [
            "# Reference",
            "",
            f"All of it is made from the program itself, so that it says what the program does. {MADE}",
            "",
            *_table({"page": page, "what is there": about} for page, about in links.items()),
            *_table(kinds),
        ]
    )


def _kinds(kinds: Mapping[str, str]) -> Iterator[str]:
    for kind, title in kinds.items():
        of = KINDS[kind]
        yield from (f"## {title}", "", f"{of.about[:1].upper()}{of.about[1:]}.", "")
        # Where a package brought it is what a page cannot know.
        rows = [{name: text for name, text in row.items() if name != "from"} for row in of.rows()]
        yield from _table({name: _quoted(name, text) for name, text in row.items()} for row in rows)


def _quoted(column: str, text: str) -> str:
    if not text or column not in CODE_COLUMNS:
        return text
    pieces = [text] if column in ("controller", "stands for", "in ASCII", "default") else text.split(", ")
    return ", ".join(f"`{piece}`" for piece in pieces)


def _table(rows: Iterable[Mapping[str, str]]) -> Iterator[str]:
    """A table of rows, without the columns that are empty in all."""
    rows = list(rows)
    columns = [name for name in rows[0] if any(row[name] for row in rows)]
    yield f"| {' | '.join(columns)} |"
    yield "|" + "---|" * len(columns)
    for row in rows:
        yield f"| {' | '.join(row[name].replace('|', chr(92) + '|') for name in columns)} |"
    yield ""


def _spec() -> str:
    about = "Each table is of one part of a spec, under its place in the file."
    schema = "`graspdsl schema` prints the same as a JSON Schema, for editors."
    sections = ["# The keys of a spec", "", f"{about} {schema} {MADE}", ""]
    for part in parts():
        sections += _part(part)
    return "\n".join(sections)


def _part(part: Part) -> Iterator[str]:
    yield from (f"## `{part.place}`" if part.place else "## The whole", "", part.about, "")
    if part.keys:
        yield from _table(_key(key) for key in part.keys)


def _key(key: Key) -> dict[str, str]:
    values = "".join(f"<br>`{name}`: {line}" for name, line in key.values.items())
    default = key.default if key.default in ("", NEEDED, BELOW) else f"`{key.default}`"
    return {
        "key": f"`{key.name}`",
        "type": key.type,
        "unit": key.unit,
        "default": default,
        "what it is": f"{key.about}{values}",
    }


def _grammar() -> str:
    shown = (
        {"formula": f"`{formula}`", "in ASCII": f"`{to_ascii(parse_expression(formula))}`", "what it shows": line}
        for formula, line in grammar.EXAMPLES.items()
    )
    lines = [
        "# The grammar of formulas",
        "",
        f"Blanks and line breaks mean nothing between words. {MADE}",
        "",
        "## Examples",
        "",
        *_table(shown),
        "## One after the other",
        "",
        "`then` runs a controller until its end conditions hold, and then the next; a phase whose `until` names the",
        "conditions of both goes on to the second when the conditions that the first works towards have held.",
        "`hysteresis` lets it go back.",
        "",
        "```yaml",
        THEN.rstrip("\n"),
        "```",
        "",
        "## Rules",
        "",
        "In EBNF: `|` between alternatives, `?` for none or one, `*` for any number, `+` for one or more.",
        "",
    ]
    for rule in grammar.rules():
        if not rule.is_word:
            lines += [f"### `{rule.name}`", "", *([rule.about, ""] if rule.about else ())]
            lines += [f"![The rule {rule.name}](grammar/{rule.name}.svg)", ""]
            lines += ["```text", f"{rule.name} ::= {rule.ebnf}", "```", ""]
    lines += ["## Words", "", "What stands between slashes is a regular expression.", "", "```text"]
    lines += [f"{rule.name} ::= {rule.ebnf}" for rule in grammar.rules() if rule.is_word]
    lines += ["```", ""]
    lines += [f"{rule.name}: {rule.about}\n" for rule in grammar.rules() if rule.is_word and rule.about]
    return "\n".join(lines)


THEN = """\
graspdsl: 1
name: force-then-moment
about: C* on a ball, the force residual to convergence and then the moment residual.
scene: {world: floating, hand: points, object: ball}
resources: {γ1: point-1, γ2: point-2, γ3: point-3, Γ: "{γ1, γ2, γ3}"}
program:
  - run: φ_fr|τ_frx(Γ) σ_fr(Γ) then φ_mr|τ_mrx(Γ) σ_mr(Γ)
    until: {force_residual: 0.1, moment_residual: 0.005, hold: 0.4}
    hysteresis: 2
    limit: 20.0
trials: {count: 10}
"""


def _diagram(rule: grammar.Rule) -> str:
    written = io.StringIO()
    railroad.Diagram(_track(rule.body), type="complex").writeStandalone(written.write, STYLE)
    return written.getvalue().rstrip("\n") + "\n"


def _track(part: Tree[Token] | Token) -> railroad.DiagramItem:
    """The track of a part of a rule."""
    if isinstance(part, str):
        return railroad.NonTerminal(grammar.shown(part))
    match part.data:
        case "expansions":
            return railroad.Choice(0, *map(_track, part.children))
        case "expansion":
            return railroad.Sequence(*map(_track, part.children))
        case "maybe":
            return railroad.Optional(_track(part.children[0]))
        case "expr":
            inner = _track(part.children[0])
            made = {"?": railroad.Optional, "*": railroad.ZeroOrMore, "+": railroad.OneOrMore}
            return made[str(part.children[1])](inner)
        case "literal":
            return railroad.Terminal(str(part.children[0])[1:-1])
        case _:
            return _track(part.children[0])


def _diagnostics() -> str:
    lines = [
        "# Diagnostics",
        "",
        "Every complaint of graspdsl by its code, which stands in brackets in what is said: what it means, a text that",
        "gets it and one that does not. `graspdsl explain CODE` shows the same in a terminal. Where an example is a",
        f"line or a part of a file, the rest of the file is sound. {MADE}",
        "",
    ]
    section = ""
    for example in examples().values():
        if example.section != section:
            section = example.section
            lines += [f"## {section}", ""]
        lines += _complaint(example)
    lines += [
        "## Contracts",
        "",
        "What `graspdsl check-plugin` says of things of others, by the rule that they break.",
        "",
    ]
    lines += _table({"code": f"`{code}`", "what the rule asks": law} for code, law in rules().items())
    return "\n".join(lines)


def _complaint(example: Example) -> Iterator[str]:
    language = LANGUAGES.get(example.form, "xml" if example.form.endswith(("URDF", "MJCF")) else "yaml")
    yield from (f"### `{example.code}`", "")
    about = f"{example.means[:1].upper()}{example.means[1:]}"
    yield from (f"{about} ({example.severity.value}; {FORMS[example.form]}).", "")
    for name, text in (("Wrong", example.wrong), ("Right", example.right)):
        yield from (f"{name}:", "", f"```{language}", text, "```", "")


if __name__ == "__main__":
    (PLACE / "grammar").mkdir(parents=True, exist_ok=True)
    for path, text in pages().items():
        (PLACE / path).write_text(text, "utf-8")
