"""The page on Python, and the README's block: what they claim is so."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

import graspdsl as g

from .pages import PAGES
from .test_readme import blocks

pytestmark = pytest.mark.slow

PAGE = PAGES["python.md"]


def test_the_page_has_every_name() -> None:
    table = PAGE.partition("## All names")[2]
    assert sorted(re.findall(r"`(\w+)`", table)) == sorted(g.__all__)


def test_the_page_has_the_fields_of_an_observation() -> None:
    """In their order, with their shapes and units: those that a controller tells, k and n in place of numbers."""
    controller = g.compile("π_close|Γ Γ", hand="barrett", mount="wam")  # of 3 contacts and 11 joints
    assert (len(controller.contacts), len(controller.joints)) == (3, 11)
    rows = re.findall(r"^\| `(\w+)` \| (\(.*?\)) \| (.*?) \|", PAGE, flags=re.M)
    assert [name for name, _, _ in rows] == [field.name for field in fields(g.Observation)]
    for name, shape, unit in rows:
        assert eval(shape, {"k": 3, "n": 11}) == controller.shapes[name]
        assert unit == controller.units[name]


def test_the_block_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    [(_, spec)] = blocks("spec")
    (tmp_path / "spec.yaml").write_text(spec, "utf-8")
    [(_, code)] = blocks("python")
    names: dict[str, Any] = {}
    exec(code, names)
    assert names["program"].spec.scene.friction == 0.6
    assert len(names["run"].trials) == 10
    assert names["tick"].command.displacement.shape == (10,)
