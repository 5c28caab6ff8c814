"""The page on published hands: every hand of the gallery is in its table, and every file that it names is there."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "hands.md").read_text("utf-8")
GALLERY = ROOT / "specs" / "hands"


def test_the_gallery_is_in_the_table() -> None:
    named = {ROOT / "docs" / link for link in re.findall(r"\]\((\.\./specs/[^)]+)\)", PAGE)}
    assert {path.resolve() for path in named} == {*GALLERY.glob("*.yaml")} - {GALLERY / "trio_towel_roll.yaml"}
    runs = re.findall(r"`graspdsl run (\S+)`", PAGE)
    assert {f"{name.removesuffix('.yaml')}_hand.yaml" for name in runs} == {
        path.name for path in GALLERY.glob("*_hand.yaml")
    }
