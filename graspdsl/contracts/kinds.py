"""The contracts of all kinds: what is asked of each thing in a table, whoever wrote it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from graspdsl.contracts import (
    controllers,
    effectors,
    grades,
    hands,
    monitors,
    mounts,
    objects,
    potentials,
    sensors,
    shapes,
    touch,
    worlds,
)
from graspdsl.contracts.rule import Rule
from graspdsl.diagnostics import Diagnostic
from graspdsl.plugins.kinds import KINDS

CONTRACTS: Mapping[str, Mapping[str, Rule[Any]]] = {
    "potentials": potentials.RULES,
    "sensors": sensors.RULES,
    "effectors": effectors.RULES,
    "controllers": controllers.RULES,
    "worlds": worlds.RULES,
    "touch": touch.RULES,
    "shapes": shapes.RULES,
    "mounts": mounts.RULES,
    "monitors": monitors.RULES,
    "grades": grades.RULES,
    "hands": hands.RULES,
    "objects": objects.RULES,
}


def breaches(kind: str, name: str) -> Iterator[Diagnostic]:
    """What a thing in a table breaks of the contract of its kind."""
    table = KINDS[kind].table()
    thing = table[name]
    if kind == "controllers":  # whose formula may name the others
        thing = next(found for found in controllers.written(table) if found.name == name)
    for rule in CONTRACTS[kind].values():
        yield from rule(thing)
