"""Every world keeps each rule, and each rule is seen to be broken."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest
from graspdsl_stranger.world import Gliding, GlidingWorld

from graspdsl.contracts.rule import Rule
from graspdsl.contracts.worlds import RULES
from graspdsl.worlds.bullet.kind import Bullet
from graspdsl.worlds.floating import Floating, FloatingWorld
from graspdsl.worlds.kind import TrialStudio, View, WorldKind, WorldSettings
from graspdsl.worlds.kinds import WORLDS
from graspdsl.worlds.protocol import PARTIES, Command, Observation, Start, Truth, WitnessedWorld

from .breaking import broken
from .each import each_rule

KINDS = [
    *(pytest.param(kind, marks=pytest.mark.slow if kind.has("hand") else ()) for kind in WORLDS.values()),
    Gliding(),
]


@each_rule(RULES)
@pytest.mark.parametrize("kind", KINDS, ids=[*WORLDS, "gliding"])
def test_it_keeps_the_rule(kind: WorldKind, rule: Rule[WorldKind]) -> None:
    assert list(rule(kind)) == []


def test_worlds_are_in_the_table_by_their_names() -> None:
    assert [kind.name for kind in WORLDS.values()] == [*WORLDS]


def gliding(changed: type[GlidingWorld]) -> WorldKind:
    """The stranger's world, changed."""

    class Changed(Gliding):
        """Contacts that glide otherwise."""

        def make(self, settings: WorldSettings) -> GlidingWorld:
            return changed(settings)

    return Changed()


class Stopped(Gliding):
    """Contacts that glide."""

    lacks: ClassVar = {**Gliding.lacks, "forces": "Gliding contacts feel no forces."}


class Paced(Gliding):
    """Contacts that glide."""

    about = "contacts that glide."


class Sensitive(Gliding):
    """Contacts that glide."""

    senses = ("exact", "whiskers")


class Slow(GlidingWorld):
    def __init__(self, settings: WorldSettings) -> None:
        super().__init__(settings)
        self.info = replace(self.info, rate=25.0)


class Touching(GlidingWorld):
    def _observed(self) -> Observation:
        seen = super()._observed()
        return replace(seen, touching=seen.touching.astype(float))


class LongAxis(GlidingWorld):
    def truth(self) -> Truth:
        found = super().truth()
        return replace(found, object_axis=2.0 * found.object_axis)


class Hasty(GlidingWorld):
    def _observed(self) -> Observation:
        seen = super()._observed()
        return replace(seen, time=2.0 * seen.time)


class Fickle(GlidingWorld):
    def reset(self, start: Start, seed: int) -> Observation:
        del seed
        return super().reset(start, int(np.random.default_rng().integers(2**31)))


class Restless(GlidingWorld):
    def step(self, command: Command) -> Observation:
        return super().step(replace(command, displacement=command.displacement + 1e-4))


class Lame(GlidingWorld):
    def step(self, command: Command) -> Observation:
        return super().step(replace(command, displacement=0.5 * command.displacement))


class Obedient(GlidingWorld):
    def step(self, command: Command) -> Observation:
        return super().step(replace(command, space="x"))


class Mistaken(GlidingWorld):
    def truth(self) -> Truth:
        found = super().truth()
        return replace(found, points=found.points + 1e-3)


class HalfTold(GlidingWorld):
    def truth(self) -> Truth:
        found = super().truth()
        return replace(found, loads=np.where(np.arange(6) < 3, 0.0, found.loads))


class Choosy(GlidingWorld):
    def reset(self, start: Start, seed: int) -> Observation:
        if start.position[2] < 0.0:
            raise RuntimeError("beneath the table")
        return super().reset(start, seed)


class Spent(GlidingWorld):
    def close(self) -> None:
        del self._surface


class Neighbourly(FloatingWorld):
    def join(self, start: Start, seed: int) -> None:
        super().join(start, seed + len(self._joining))


class Beside(Floating):
    """Contacts that float."""

    def make(self, settings: WorldSettings) -> FloatingWorld:
        made = super().make(settings)
        return Neighbourly(made.info.contacts, made.surface, 1.0)


class OneClock(FloatingWorld):
    def observe(self) -> Observation:
        seen = super().observe()
        return replace(seen, time=np.full_like(seen.time, np.max(seen.time, initial=0.0)))


class LateComers(Floating):
    """Contacts that float."""

    def make(self, settings: WorldSettings) -> FloatingWorld:
        made = super().make(settings)
        return OneClock(made.info.contacts, made.surface, 1.0)


class Dark:
    """A studio in which nothing is seen."""

    is_open = False

    def __getattr__(self, name: str) -> Callable[..., Any]:
        return lambda *_: np.zeros((48, 64, 3))


class Unseen(Gliding):
    """Contacts that glide."""

    def studio(self, view: View) -> TrialStudio:
        del view
        return Dark()


class Unborne(Bullet):
    """Rigid bodies on a table that is said to bear nothing."""

    def make(self, settings: WorldSettings) -> WitnessedWorld:
        made = super().make(settings)
        told = made.truth

        def truth() -> Truth:
            found = told()
            return replace(found, loads=np.where(np.array(PARTIES)[:, None] == "table", 0.0, found.loads))

        made.truth = truth
        return made


class Long(Bullet):
    """Rigid bodies whose Jacobians are too long."""

    def make(self, settings: WorldSettings) -> WitnessedWorld:
        made = super().make(settings)

        observe = made.observe

        def observed() -> Observation:
            seen = observe()
            return replace(seen, jacobian=1.2 * seen.jacobian)

        made.observe = observed
        return made


MUTANTS = [
    ("declared", Stopped()),
    ("told", Paced()),
    ("senses", Sensitive()),
    ("info", gliding(Slow)),
    ("observation", gliding(Touching), "agrees"),
    ("truth", gliding(LongAxis)),
    ("time", gliding(Hasty)),
    ("repeats", gliding(Fickle), "closing"),
    ("still", gliding(Restless), "obeys"),
    ("obeys", gliding(Lame)),
    ("jacobian", Long()),
    ("refuses", gliding(Obedient)),
    ("agrees", gliding(Mistaken)),
    ("balance", gliding(HalfTold)),
    ("infeasible", gliding(Choosy)),
    ("closing", gliding(Spent)),
    ("side-by-side", Beside()),
    ("side-by-side", LateComers()),
    ("studio", Unseen()),
]


@pytest.mark.slow
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant[0])
def test_a_rule_is_seen_to_be_broken(mutant: tuple[str, WorldKind]) -> None:
    code, kind, *others = mutant
    assert broken(RULES, kind) == {f"contract-{name}" for name in (code, *others)}


@pytest.mark.slow
def test_a_table_that_is_left_out_is_missed() -> None:
    [breach] = RULES["contract-balance"](Unborne())
    assert breach.message == "Unborne: what acts on an object at rest does not cancel"


def test_every_rule_is() -> None:
    assert {f"contract-{mutant[0]}" for mutant in MUTANTS} == set(RULES)
