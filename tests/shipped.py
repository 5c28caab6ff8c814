"""The specs that the project ships, but for those of published hands whose models are not here."""

from __future__ import annotations

import re
from pathlib import Path

import yaml

SPECS = Path(__file__).parent.parent / "specs"
SPEC = re.compile(r"^graspdsl:", re.MULTILINE)
HANDS = sorted((SPECS / "hands").glob("*_hand.yaml"))


def _model(hand: Path) -> Path:
    said = yaml.safe_load(hand.read_text("utf-8"))
    return hand.parent / (said.get("urdf") or said["mjcf"])


def _spec(hand: Path) -> Path:
    return hand.with_name(hand.name.replace("_hand", ""))


ABSENT = {_spec(hand) for hand in HANDS if not _model(hand).is_file()}
SHIPPED = sorted(
    path
    for path in SPECS.rglob("*.yaml")
    if "models" not in path.parts and path not in ABSENT and SPEC.search(path.read_text("utf-8"))
)
NAMES = [path.relative_to(SPECS).as_posix() for path in SHIPPED]
