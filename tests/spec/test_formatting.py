"""Specs formatted: the same meaning and comments in one style, whatever they looked like before."""

from __future__ import annotations

import random
import re
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from shipped import NAMES, SPECS

from graspdsl.diagnostics import DiagnosticError
from graspdsl.notation.names import ascii_name
from graspdsl.notation.parser import parse_expression
from graspdsl.notation.printer import to_ascii
from graspdsl.spec.formatting import formatted, meaning

ALL = sorted(path for path in SPECS.rglob("*.yaml") if path.read_text("utf-8").startswith(("graspdsl:", "# yaml")))
FREE = {"resources", "parameters", "controllers"}  # whose keys keep their order

UNTIDY = """\
# yaml-language-server: $schema=graspdsl.json

# what it is
graspdsl: 1   # the version
trials:
      count: 5
      start:
          # where from
          approach: side # s
"name": "x"


scene: {object: {mass: 0.5, # kg
   cylinder: {diameter: 0.10, height: 0.2}}, world: bullet}
resources:
  g1:    finger-3   # thumb
  G: '{g1,<γ2,   γ3>}'
  γ2: finger-1
  γ3: finger-2
parameters: {kappa_f: 0.5}
program:
- until: {contact: all}
  run: pi_close|G G
  # of the first phase
# before the second
- run: >-
    phi_mr|tau_frx(G) sigma_mr(G)
      <| phi_fr|tau_frx(G) sigma_fr(G)
  until: {contact: all}
"""
TIDY = """\
# yaml-language-server: $schema=graspdsl.json

# what it is
graspdsl: 1 # the version
name: "x"

scene: {
  world: bullet,
  object: {
    cylinder: {diameter: 0.10, height: 0.2},
    mass: 0.5 # kg
  }
}
resources:
  γ1: finger-3 # thumb
  Γ: "{γ1, <γ2, γ3>}"
  γ2: finger-1
  γ3: finger-2
parameters: {κ_f: 0.5}
program:
  - run: π_close|Γ Γ
    until: {contact: all}
    # of the first phase
  # before the second
  - run: >-
      φ_mr|τ_frx(Γ) σ_mr(Γ) ◁ φ_fr|τ_frx(Γ) σ_fr(Γ)
    until: {contact: all}
trials:
  count: 5
  start:
    # where from
    approach: side # s
"""
HEAD = "graspdsl: 1\nname: x\nscene: {world: bullet, object: ball}\nresources: {γ1: finger-1}\n"
TAIL = "program: [{run: π_close|γ1 γ1, until: {contact: all}}]\n"


def test_one_style() -> None:
    assert formatted(UNTIDY) == TIDY
    assert formatted(formatted(UNTIDY, in_ascii=True)) == TIDY
    assert '  G: "{g1, <g2, g3>}"\n' in formatted(UNTIDY, in_ascii=True)


@pytest.mark.parametrize("path", ALL, ids=lambda path: path.stem)
def test_shipped_specs_are_formatted(path: Any) -> None:
    text = path.read_text("utf-8")
    assert formatted(text) == text


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ("about: |+\n   kept\n    as\n\n     it is\n\n", "about: |+\n   kept\n    as\n\n     it is\n\n"),
        ("about: 'two\n\n\n    lines'\n", "about: 'two\n\n\n    lines'\n"),
        ("about: &a !!str x # c\n", "about: &a !!str x # c\n"),
        ("about:   # c\n   # d\n  x\n", "# c\n# d\nabout: x\n"),
        ('about: "a # b: {c}"#d\n', 'about: "a # b: {c}" #d\n'),
        ("about: a#b # c#d\n", "about: a#b # c#d\n"),
        ("? about\n: x\n", "about: x\n"),
        ("parameters: {long: [%s]}\n", "parameters: {\n  long: [\n    %s,\n    %s\n  ]\n}\n"),
        ("evaluate: [ # a\n  force-closure, # b\n  lift # c\n  # d\n  ] # e\n", None),
        ("code: []\n", "code: []\n"),
    ],
)
def test_what_yaml_allows(more: str, expected: str | None) -> None:
    numbers = [f"{number}.25" for number in range(100, 132)]
    if "%s" in more:
        assert expected is not None
        more, expected = more % ", ".join(numbers), expected % (", ".join(numbers[:14]), ", ".join(numbers[14:28]))
        expected = expected.replace("\n  ]", f",\n    {', '.join(numbers[28:])}\n  ]")
    if expected is None:
        expected = "evaluate: [\n  # a\n  force-closure, # b\n  lift # c\n  # d\n] # e\n"
    written = formatted(HEAD + TAIL + more)
    assert expected in written
    assert formatted(written) == written


def test_aliases_keep_behind_their_anchors() -> None:
    text = f"trials:\n  seed: &n 3\n  count: *n\n{HEAD}{TAIL}"
    assert formatted(text).startswith("trials:\n  seed: &n 3\n  count: *n\ngraspdsl: 1\n")


def test_long_formulas_are_broken_at_blanks() -> None:
    run = " ◁ ".join(["φ_mr|τ_mrx(γ1) σ_mr(γ1)"] * 9)
    text = f"{HEAD}program:\n  - run: {run}\n    until: {{contact: all}}\n"
    written = formatted(text)
    assert max(map(len, written.splitlines())) <= 120 < len(run)
    assert meaning(written) == meaning(text)
    assert formatted(written) == written


@pytest.mark.parametrize("text", ["", "a: 1\n", f"{HEAD}{HEAD}", f"{HEAD}{TAIL}\tx: 1\n", f"{HEAD}{TAIL}other: 1\n"])
def test_no_spec_is_refused(text: str) -> None:
    with pytest.raises(DiagnosticError):
        formatted(text)


def test_meaning_tells_other_specs_apart() -> None:
    text = (SPECS / NAMES[0]).read_text("utf-8")
    assert meaning(text) == meaning(text.replace("γ1:", "g1:"))
    assert meaning(text) != meaning(text.replace("point-1", "point-2"))
    assert meaning(text) != meaning(text.replace("π_fr|Γ Γ", "π_fr|γ1 Γ"))


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32))
def test_specs_in_any_style(seed: int) -> None:
    """Written by hand and machine, with comments wherever YAML takes them: nothing is lost and one pass is enough."""
    text, comments = untidy(random.Random(seed))
    written = formatted(text)
    assert meaning(written) == meaning(text)
    assert sorted(re.findall(r"#c\d+-", written)) == sorted(comments)
    assert formatted(written) == written


def untidy(draw: random.Random) -> tuple[str, list[str]]:
    """A shipped spec in another style, and the comments in it."""
    said = yaml.safe_load(draw.choice(ALL).read_text("utf-8"))
    root = yaml.compose(yaml.safe_dump(_shuffled(said, draw), allow_unicode=True, sort_keys=False))
    _restyle(root, draw)
    lines = yaml.serialize(
        root, allow_unicode=draw.random() < 0.9, indent=draw.choice([2, 3, 4, 7]), width=draw.choice([20, 60, 1000])
    ).split("\n")
    before, comments = _read(lines), list[str]()
    for _ in range(draw.randrange(12)):
        place, comment = draw.randrange(len(lines)), f"#c{len(comments)}-"
        ways = [
            [lines[place], " " * draw.randrange(9) + comment],
            [f"{lines[place]}  {comment} more"],
            [lines[place], ""],
            _broken(lines[place], comment, draw),
        ]
        tried = [*lines[:place], *draw.choice(ways), *lines[place + 1 :]]
        try:
            if _read(tried) == before:  # it fell on no text
                lines, comments = tried, comments + [comment] * (len("\n".join(tried).split(comment)) - 1)
        except yaml.YAMLError:
            continue
    return "\n".join(lines), comments


def _read(lines: list[str]) -> Any:
    return yaml.load("\n".join(lines), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))


def _broken(line: str, comment: str, draw: random.Random) -> list[str]:
    """A line broken by a comment at a comma or a bracket."""
    places = [found.end() for found in re.finditer(r"[,\[{]", line)]
    if not places:
        return [line]
    place = draw.choice(places)
    return [f"{line[:place]} {comment}", " " * draw.randrange(4, 9) + line[place:]]


def _shuffled(value: Any, draw: random.Random, inside: str = "") -> Any:
    if isinstance(value, list):
        return [_shuffled(item, draw) for item in value]
    if not isinstance(value, dict):
        return to_ascii(parse_expression(value)) if inside == "run" and draw.random() < 0.5 else value
    items = list(value.items())
    if inside not in FREE:
        draw.shuffle(items)
    elif inside == "parameters" and draw.random() < 0.5:
        items = [(ascii_name(name), item) for name, item in items]
    return {name: _shuffled(item, draw, name) for name, item in items}


def _restyle(node: yaml.Node, draw: random.Random) -> None:
    if isinstance(node, yaml.CollectionNode):
        node.flow_style = draw.random() < 0.4
        for item in node.value:
            for part in item if isinstance(item, tuple) else [item]:
                _restyle(part, draw)
    elif isinstance(node, yaml.ScalarNode) and node.tag.endswith("str") and draw.random() < 0.5:
        node.style = draw.choice(["'", '"', ">", "|"])
