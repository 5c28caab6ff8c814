"""What a program makes of the worlds of the table, and of one of a stranger beside them."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from compiler.specs import floating
from typer.testing import CliRunner

from graspdsl.cli.app import app
from graspdsl.compiler.explain import explained
from graspdsl.compiler.program import examine, missing_engine, program_of
from graspdsl.diagnostics import DiagnosticError, Severity
from graspdsl.reference.kinds import KINDS
from graspdsl.trials.identity import versions
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.runner import new_run
from graspdsl.trials.setup import settings_of, trial_loop, world_of
from graspdsl.worlds.floating import Floating, FloatingWorld
from graspdsl.worlds.kind import View, WorldKind, WorldSettings
from graspdsl.worlds.kinds import WORLDS
from graspdsl.worlds.protocol import Command, Observation, Start

MAIN = Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml"
FLOATING = floating("π_gx|{γ1, γ2, γ3} {γ1, γ2, γ3}", until="force_residual: 0.1, moment_residual: 0.005, hold: 0.4")
NOWHERE = Start(np.zeros(3), np.eye(3), {})
EACH_KIND = pytest.mark.parametrize("kind", WORLDS.values(), ids=WORLDS)


@EACH_KIND
def test_a_program_says_which_world_it_runs_in(kind: WorldKind) -> None:
    text = MAIN.read_text("utf-8") if kind.has("hand") else FLOATING
    program = program_of(text, "test.yaml", (f"scene.world={kind.name}",))
    world = world_of(program)
    assert program.world is kind
    assert program.target.rate == world.info.rate == kind.rate
    world.close()


def test_a_world_that_there_is_not_is_named_with_those_that_there_are() -> None:
    found = examine(MAIN.read_text("utf-8").replace("world: bullet", "world: bulet"), "test.yaml").diagnostics
    [complaint] = [diagnostic for diagnostic in found if diagnostic.severity is Severity.ERROR]
    assert (complaint.code, complaint.hint) == ("unknown-value", "did you mean bullet?")
    assert complaint.message == "expected bullet, mujoco or floating, found the text 'bulet'"


# A world of a stranger: one class, one line of the table.


class StickyWorld(FloatingWorld):
    """Contacts that get half as far as they are told."""

    def step(self, command: Command) -> Observation:
        """Half of it."""
        return super().step(dataclasses.replace(command, displacement=0.5 * command.displacement))


class Sticky(Floating):
    """Floating contacts on a sticky surface."""

    name = "sticky"
    about = "floating contacts that get half as far as they are told"
    contacts = "sticky contacts"
    lacks: ClassVar = {**Floating.lacks, "forces": "sticky contacts feel no forces"}

    def make(self, settings: WorldSettings) -> StickyWorld:
        """On the surface of the object."""
        made = super().make(settings)
        return StickyWorld(made.info.contacts, made.surface, 1.0)


@pytest.fixture
def sticky(monkeypatch: pytest.MonkeyPatch) -> str:
    """The text of a spec of a world that is in the table by one line."""
    monkeypatch.setitem(WORLDS, Sticky.name, Sticky())
    return FLOATING.replace("world: floating", "world: sticky")


def test_a_strangers_world_is_checked_explained_run_and_listed(sticky: str) -> None:
    """It goes half as far a tick, and ends in a grasp all the same."""
    examination = examine(sticky, "test.yaml")
    assert examination.diagnostics == ()
    program = examination.program
    assert program is not None
    assert "50 times a second, contacts float" in explained(program)[0].text()
    slow, fast = (trial_loop(made).run(0, 3) for made in (program, program_of(FLOATING, "test.yaml")))
    assert slow.record.outcome is fast.record.outcome is Outcome.CONVERGED
    first, second = (trial.trajectory["points"][:2].astype(float) for trial in (slow, fast))
    np.testing.assert_array_equal(first[0], second[0])
    assert 0.3 < np.linalg.norm(first[1] - first[0]) / np.linalg.norm(second[1] - second[0]) < 0.7
    assert ("sticky", Sticky.about) in [(row["name"], row["about"]) for row in KINDS["worlds"].rows()]


def test_messages_name_a_strangers_world(sticky: str) -> None:
    """Where it comes short, and among those that a spec may name."""
    found = examine(sticky.replace("π_gx|", "π_close|"), "test.yaml").diagnostics
    said = [diagnostic.message for diagnostic in found if diagnostic.code == "not-sensed"]
    assert said == ["sticky contacts feel no forces: σ_f cannot be sensed in the sticky world"]
    [unknown] = examine(sticky.replace("world: sticky", "world: stiky"), "test.yaml").diagnostics
    assert (unknown.message, unknown.hint) == (
        "expected bullet, mujoco, floating or sticky, found the text 'stiky'",
        "did you mean sticky?",
    )
    [sensing] = examine(sticky.replace("world: sticky", "world: sticky, sensing: skin"), "test.yaml").diagnostics
    assert sensing.message == "sticky contacts have no skin"


def test_what_a_world_needs_is_told_with_how_to_install_it(
    sticky: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Sticky, "libraries", {"no_such_engine": "pip install no_such_engine"})
    program = program_of(sticky, "test.yaml")  # which can be explained, and its runs reported, all the same
    missing = missing_engine(program)
    assert missing is not None
    assert missing.code == "engine-missing"
    assert missing.message == "the sticky world needs no_such_engine, which this Python has not"
    assert missing.hint == "pip install no_such_engine; or use world: floating"
    assert missing.span is not None
    assert missing_engine(program_of(FLOATING, "test.yaml")) is None
    with pytest.raises(DiagnosticError, match="which this Python has not"):
        new_run(tmp_path / "run", program)
    assert not (tmp_path / "run").exists()
    (tmp_path / "sticky.yaml").write_text(sticky, "utf-8")
    for command in ("validate", "run"):
        answer = CliRunner().invoke(app, [command, str(tmp_path / "sticky.yaml")])
        assert (answer.exit_code, (answer.stdout + answer.stderr).count("error[engine-missing]")) == (1, 1)


def test_how_finely_physics_is_worked_out() -> None:
    """As the spec says; what it does not say is as is usual in the world."""
    text = MAIN.read_text("utf-8")
    for kind in WORLDS.values():
        if kind.effort is None:
            continue
        usual = program_of(text, "test.yaml", (f"scene.world={kind.name}",))
        finer = program_of(text, "test.yaml", (f"scene.world={kind.name}", "scene.physics.time_step=0.001"))
        assert settings_of(usual).effort == kind.effort
        assert settings_of(finer).effort == dataclasses.replace(kind.effort, time_step=0.001)


def test_versions_are_those_of_the_world() -> None:
    """A run does not depend on engines that it does not use, nor on keys that its spec does not name."""
    floating_run = program_of(FLOATING, "test.yaml")
    assert set(versions(floating_run)) == {"graspdsl", "numpy", "scipy"}
    rolls = program_of(MAIN.read_text("utf-8"), "test.yaml", ("scene.world=mujoco",))
    assert set(versions(rolls)) == {"graspdsl", "mujoco", "numpy", "scipy"}
    assert "physics" not in rolls.spec.model_dump(mode="json")["scene"]


def test_a_strangers_world_is_seen_again(sticky: str) -> None:
    program = program_of(sticky, "test.yaml")
    row = {"points": world_of(program).reset(NOWHERE, 1).points}
    studio = program.world.studio(View(settings_of(program), None, [0, 1], [0, 1]))
    studio.show(row)
    assert studio.picture(studio.camera(64, 48)).shape == (48, 64, 3)
    studio.close()
    assert not studio.is_open
