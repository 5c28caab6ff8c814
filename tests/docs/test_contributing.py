"""CONTRIBUTING.md names what there is: commands, packages in the order of imports, tables, classes and tests."""

from __future__ import annotations

import importlib
import inspect
import re
from pathlib import Path

import pytest
from structure.test_imports import ROW

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
RECIPES = re.findall(r"^\| (\w+) \| `(\w+)` \| `(\w+)` in `(\S+)` \| `(\S+)` \|$", TEXT, flags=re.M)


def test_there_are_the_commands() -> None:
    makefile = (ROOT / "Makefile").read_text("utf-8")
    commands = re.findall(r"^make (\w+)", TEXT, flags=re.M)
    assert commands == ["check", "test", "demo"]
    assert all(re.search(rf"^{command}:", makefile, flags=re.M) for command in commands)


def test_packages_stand_in_the_order_of_imports() -> None:
    packages = re.findall(r"^\| `(\w+)/` \|", TEXT, flags=re.M)
    assert {*packages} == {package for package in ROW if (ROOT / "graspdsl" / package).is_dir() or package == "cli"}
    assert packages == sorted(packages, key=lambda package: ROW[package])


def test_there_is_a_recipe_for_each_kind() -> None:
    assert [kind for kind, *_ in RECIPES] == re.findall(r"^### An? (\w+)$", TEXT, flags=re.M)
    assert len(RECIPES) >= 5


@pytest.mark.parametrize(("kind", "base", "table", "file", "test"), RECIPES, ids=[recipe[0] for recipe in RECIPES])
def test_a_recipe_is_carried_out(kind: str, base: str, table: str, file: str, test: str) -> None:
    """By a test with a class of that kind; each entry of the table is one, too."""
    module = importlib.import_module(file.removesuffix(".py").replace("/", "."))
    entries = [entry if inspect.isclass(entry) else type(entry) for entry in getattr(module, table).values()]
    assert all(base in [parent.__name__ for parent in entry.__mro__] for entry in entries), kind
    carried_out = (ROOT / test).read_text("utf-8")
    added = re.search(r"^class \w+\((\w+)\):", carried_out, flags=re.M)
    assert added is not None
    assert table in carried_out or Path(file).name in carried_out


@pytest.mark.parametrize(
    "path", sorted(set(re.findall(r"`((?:places|spec|compiler|trials|basis|report)/\w+\.py)`", TEXT)))
)
def test_there_are_the_rooms_on_the_way_of_a_value(path: str) -> None:
    """And what is named beside a room is in it."""
    named = re.search(rf"`{path}`, `(\w+)`", TEXT)
    text = (ROOT / "graspdsl" / path).read_text("utf-8")
    assert named is None or re.search(rf"^(class|def) {named.group(1)}\b", text, flags=re.M)
