"""Every tactile sensor keeps each rule, and each rule is seen to be broken."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import pytest
from graspdsl_stranger.touch import ForceCell, ForceCells
from pydantic import ConfigDict, Field

from graspdsl.arrays import Array
from graspdsl.contracts.rule import Rule
from graspdsl.contracts.touch import RULES
from graspdsl.spec.sensing import SENSORS, Newtons
from graspdsl.worlds.touch.fingertip_sensor import Clock, FingertipPhysics, FingertipSensor, Frames, TipContact
from graspdsl.worlds.touch.sensors import TACTILE_SENSORS

from .breaking import broken
from .each import each_rule


@each_rule(RULES, "noise", "seeds")
@pytest.mark.parametrize("sensor", [*TACTILE_SENSORS.values(), ForceCells], ids=lambda sensor: sensor.name)
def test_it_keeps_the_rule(sensor: type[FingertipSensor], rule: Rule[type[FingertipSensor]]) -> None:
    assert list(rule(sensor)) == []


def test_the_table_is_that_of_their_settings() -> None:
    assert {name: sensor.model for name, sensor in TACTILE_SENSORS.items()} == SENSORS
    assert [sensor.name for sensor in TACTILE_SENSORS.values()] == [*TACTILE_SENSORS]


class Unmodelled(ForceCells):
    """Force cells."""

    tares: ClassVar = "yes"


class Uncalled(ForceCells):
    """Force cells."""

    called = ""


class UnitlessCell(ForceCell):
    """Force cells."""

    bias: Newtons = Field(default=0.0, description="bias")


class Unitless(ForceCells):
    """Force cells."""

    model = UnitlessCell


class LenientCell(ForceCell):
    """Force cells."""

    model_config = ConfigDict(extra="ignore")


class Lenient(ForceCells):
    """Force cells."""

    model = LenientCell


class Outwards(ForceCells):
    """Force cells."""

    def contact(self, tip: int) -> TipContact:
        found = super().contact(tip)
        return found._replace(normal=-found.normal)


class Misplaced(ForceCells):
    """Force cells."""

    def contact(self, tip: int) -> TipContact:
        found = super().contact(tip)
        return found._replace(place=found.place + 1e-3)


class Weighing(ForceCells):
    """Force cells."""

    def read(self, step: int) -> Array:
        return -FingertipSensor.read(self, step)


class Saturated(ForceCells):
    """Force cells."""

    def strengths(self, step: int, frames: Frames) -> Array:
        return np.minimum(0.79, super().strengths(step, frames))


class Untared(ForceCells):
    """Force cells."""

    def strengths(self, step: int, frames: Frames) -> Array:
        self.forces, self.frames = self.read(step), frames
        return np.asarray(np.linalg.norm(self.forces, axis=1))


class Unseeded(ForceCells):
    """Force cells."""

    def __init__(self, spec: Any, hand: FingertipPhysics, gravity: float, clock: Clock, _: object) -> None:
        super().__init__(spec, hand, gravity, clock, np.random.SeedSequence())


class ModestCell(ForceCell):
    """Force cells."""

    about: ClassVar = "force cells"

    def force_noise_at(self, control_rate: float) -> float:
        return super().force_noise_at(control_rate) / 3.0


class Modest(ForceCells):
    """Force cells."""

    model = ModestCell


MUTANTS = [
    ("declared", Unmodelled),
    ("told", Uncalled),
    ("keys", Unitless),
    ("round-trip", Lenient),
    ("presses", Outwards),
    ("place", Misplaced),
    ("nothing", Weighing),
    ("harder", Saturated),
    ("tares", Untared),
    ("seeds", Unseeded),
    ("noise", Modest),
]


@pytest.mark.slow
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant[0])
def test_a_rule_is_seen_to_be_broken(mutant: tuple[str, type[FingertipSensor]]) -> None:
    code, sensor, *others = mutant
    assert broken(RULES, sensor) == {f"contract-{name}" for name in (code, *others)}


def test_every_rule_is() -> None:
    assert {f"contract-{mutant[0]}" for mutant in MUTANTS} == set(RULES)
