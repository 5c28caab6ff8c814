"""Monitors, shapes and tactile sensors of other packages: keys of a spec that come while the program runs."""

from __future__ import annotations

from pathlib import Path

import pytest
from compiler.specs import floating, spec

from graspdsl.compiler.program import examine, known_names, program_of
from graspdsl.plugins.adoption import adopted_all
from graspdsl.plugins.kinds import KINDS
from graspdsl.spec.loading import json_schema
from graspdsl.spec.models import Spec
from graspdsl.trials.identity import identities
from graspdsl.trials.outcomes import OUTCOMES
from graspdsl.trials.setup import settings_of

from .packages import installed

MONITOR = '''
from graspdsl.spec.outcomes import Outcome
from graspdsl.spec.watching import Beyond, Distance


class Twist(Beyond):
    """Contacts that twist the object."""

    key = "twist"
    description = "the moment residual is larger than this (m): twisted"
    bound_type, default = Distance, 0.05
    outcome = Outcome("twisted", "the contacts twisted the object")
    quantity, said, scale = "moment_residual", "a moment of {:.0f} mm", 1000.0
'''
SHAPE = '''
from typing import ClassVar

from graspdsl.objects.box import Box


class Brick(Box):
    """A box of another name."""

    name: ClassVar = "brick"
    about: ClassVar = "a brick"
'''
TOUCH = """
from typing import ClassVar

from graspdsl.spec.sensing import Exact
from graspdsl.worlds.touch.exact import ExactContacts


class Felt(Exact):
    about: ClassVar = "what is felt"


class Feeling(ExactContacts):
    name = "felt-tip"
    about = "what is felt"
    model = Felt
"""
OFFERS = {
    "monitors": {"twist": "kit:Twist"},
    "shapes": {"brick": "kit:Brick"},
    "touch": {"felt-tip": "kit:Feeling"},
}
ALL = MONITOR + SHAPE + TOUCH
BRICK = spec(scene="world: bullet, hand: barrett, sensing: felt-tip, object: {brick: {size: [0.09, 0.06, 0.18]}}")
TWIST = floating(monitors="twist: 0.02")


def complaints(text: str) -> list[tuple[str, str]]:
    """What is said of a spec, with the codes."""
    return [(found.code, found.message) for found in examine(text, "test.yaml").diagnostics]


def test_they_are_keys_as_any_other(site: Path) -> None:
    installed(site, ALL, OFFERS)
    assert complaints(BRICK) == complaints(TWIST) == []
    assert complaints(BRICK.replace("felt-tip", "{felt-tip: {touch: {begins: 0.1}}}")) == []
    assert complaints(BRICK.replace("0.09", "9.0")) == [("out-of-range", "expected a number of at most 2 (m), found 9")]
    assert complaints(TWIST.replace("0.02", "wide")) == [
        ("wrong-form", "expected a number, on (the default) or off, in m; found the text 'wide'")
    ]
    assert [code for code, _ in complaints(BRICK.replace("felt-tip", "{felt-tip: {toch: {}}}"))] == ["unknown-key"]
    hints = [found.hint for found in examine(TWIST.replace("twist", "twisted"), "test.yaml").diagnostics]
    assert hints == ["the monitor of twisted is twist"]


def test_the_schema_has_them(site: Path) -> None:
    installed(site, ALL, OFFERS)
    assert adopted_all(KINDS) == ()
    parts = json_schema(known_names())["$defs"]
    assert parts["MonitorBounds"]["properties"]["twist"]["default"] == "off"
    assert "brick" in parts["InlineObject"]["properties"]
    assert "felt-tip" in parts["Sensing"]["properties"]
    assert "felt-tip" in str(parts["Scene"]["properties"]["sensing"])


def test_what_was_read_before_goes_on(site: Path) -> None:
    """With the same identities, and watched by the same monitors: those of others are off where a spec is silent."""
    plain = [floating(scene="object: {sphere: {diameter: 0.1}}"), spec(scene=BRICKLESS)]
    before = [program_of(text, "test.yaml") for text in plain]
    known = [identities(program, 1)(0) for program in before]
    installed(site, ALL, OFFERS)
    assert adopted_all(KINDS) == ()
    after = [program_of(text, "test.yaml") for text in plain]
    assert [identities(program, 1)(0) for program in (*before, *after)] == [*known, *known]
    for program in (*before, *after):
        assert program.monitors.given("twist") == "off"
        assert settings_of(program).body.shape.name in ("sphere", "box")
    assert isinstance(after[0].spec, Spec)
    assert program_of(TWIST, "").monitors.given("twist") == 0.02
    assert program_of(TWIST.replace("0.02", "on"), "").monitors.given("twist") == 0.05
    assert OUTCOMES["twisted"].means == "the contacts twisted the object"


BRICKLESS = (
    "world: bullet, hand: barrett, sensing: {load-cell: {force_noise: 0.01}}, object: {box: {size: [0.09, 0.06, 0.18]}}"
)

UNFIT = {
    "a bound that is no type": (
        MONITOR.replace("Distance, 0.05", "object(), 0.05"),
        {"monitors": {"twist": "kit:Twist"}},
        "cannot be used: ",
    ),
    "a key of an object": (
        SHAPE.replace('"brick"', '"mass"'),
        {"shapes": {"mass": "kit:Brick"}},
        "mass is another key of an object",
    ),
}


@pytest.mark.parametrize(("module", "offers", "said"), UNFIT.values(), ids=UNFIT)
def test_what_is_no_key_changes_nothing(site: Path, module: str, offers: dict[str, dict[str, str]], said: str) -> None:
    schema = json_schema(known_names())
    installed(site, module, offers)
    [found] = adopted_all(KINDS)
    assert (found.code, said in found.message) == ("plugin-broken", True)
    assert json_schema(known_names()) == schema
    assert complaints(floating()) == []
