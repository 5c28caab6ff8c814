"""Maps over where a floating contact starts, against trials run one by one."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from graspdsl_stranger.world import Gliding

from graspdsl.arrays import Array
from graspdsl.compiler.program import Program, program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.objects.ellipsoid import SmoothEllipsoid
from graspdsl.spec.scene import GRAVITY
from graspdsl.trials.loop import TrialLoop
from graspdsl.trials.maps import Cells, WantedAxis, floating_cells, starts, towards
from graspdsl.trials.setup import world_of
from graspdsl.worlds.floating import RATE, FloatingWorld

pytestmark = pytest.mark.slow

SPECS = Path(__file__).resolve().parents[2] / "specs"
SEED = 7


def program(name: str, *overrides: str) -> Program:
    """One of the example specs."""
    return program_of((SPECS / name).read_text("utf-8"), name, overrides)


def axes(columns: int, rows: int) -> list[WantedAxis]:
    """Axes over the whole object."""
    return [WantedAxis("azimuth", None, columns), WantedAxis("polar", None, rows)]


@dataclass(frozen=True)
class Placed(SmoothEllipsoid):
    """An ellipsoid on which contacts are not drawn but placed."""

    points: Array | None = None

    def sample(self, count: int, random: np.random.Generator) -> Array:
        """The points, whatever is asked for."""
        del random
        assert self.points is not None
        assert len(self.points) == count
        return self.points


def by_trials(made: Program, found: Cells, chosen: range) -> None:
    """Check cells against the loop over single trials from the same points: outcome, ticks, orientation."""
    body = made.body
    names, surface = made.robot.contacts, body.shape.surface()
    assert isinstance(surface, SmoothEllipsoid)
    points = starts(surface, found.x, found.y, names.index(found.fixed["contact"]), len(names), SEED)
    for cell in chosen:
        world = FloatingWorld(names, Placed(surface.semi_axes, points[cell]), GRAVITY * body.mass)
        record = TrialLoop(made, world).run(0, SEED).record
        assert record.outcome.value == found.outcomes[cell]
        assert record.orientation_end == found.orientation[cell]
        if record.ticks_to_converge is None:
            assert math.isnan(found.ticks[cell])
        else:
            assert record.ticks_to_converge == found.ticks[cell]


@pytest.mark.parametrize(
    ("name", "outcome"),
    [
        ("compare/moment_subject_to_force.yaml", "converged"),
        ("compare/cstar.yaml", "undone"),
        ("chapter/cstar.yaml", "converged"),
        ("compare/cstar.yaml program.0.hysteresis=1.5", "converged"),
    ],
)
def test_each_cell_ends_as_its_trial_does(name: str, outcome: str) -> None:
    made = program(*name.split())
    found = floating_cells(made, axes(4, 3), None, SEED)
    assert outcome in found.outcomes
    by_trials(made, found, range(0, 12, 3))


FORCE = "{run: φ_fr|τ_frx(Γ) σ_fr(Γ), until: {force_residual: 0.3, hold: 0.1}}"
MOMENT = "{run: φ_mr|τ_mrx(Γ) σ_mr(Γ), until: {moment_residual: 0.02, hold: 0.2}}"
BOTH = "{run: π_gx|Γ Γ, until: {force_residual: 0.1, moment_residual: 0.005, hold: 0.4}, limit: 20.0}"
AT_ONCE = "{run: φ_fr|τ_frx(Γ) σ_fr(Γ), until: {force_residual: 0.8, hold: 0.0}}"


def test_gravity_among_the_resources_is_mapped_as_a_trial_measures_it() -> None:
    made = program("compare/moment_subject_to_force.yaml", "resources.Γ='{γ1, γ2, γ_g}'", "resources.Γ_τ='{γ1, γ2}'")
    found = floating_cells(made, axes(4, 3), None, SEED)
    by_trials(made, found, range(0, 12, 3))


@pytest.mark.parametrize("phases", [[FORCE, BOTH], [AT_ONCE, BOTH], [FORCE, MOMENT, BOTH]])
def test_cells_of_several_phases_end_as_their_trials_do(phases: list[str]) -> None:
    """Ticks too: they count from where the second phase begins."""
    made = program("compare/moment_subject_to_force.yaml", f"program=[{', '.join(phases)}]")
    found = floating_cells(made, axes(4, 3), None, SEED)
    assert "converged" in found.outcomes
    by_trials(made, found, range(12))


def test_those_for_whom_time_is_too_short_are_known_beforehand() -> None:
    """With time for half of the cells, just those with the fewest ticks converge, and the trials agree."""
    name, hold = "compare/moment_subject_to_force.yaml", 20
    ticks = floating_cells(program(name), axes(4, 3), None, SEED).ticks
    steps = int(np.median(ticks)) + hold
    made = program(name, f"program.0.limit={steps / RATE!r}")
    found = floating_cells(made, axes(4, 3), None, SEED)
    assert found.outcomes == tuple("converged" if enough else "timeout" for enough in ticks + hold <= steps)
    assert len(set(found.outcomes)) == 2
    by_trials(made, found, range(1, 12, 3))


def test_all_but_one_contact_start_where_trial_0_places_them() -> None:
    made = program("compare/cstar.yaml")
    body = made.body
    found = floating_cells(made, axes(2, 2), "point-2", SEED)
    names = made.robot.contacts
    points = starts(body.shape.surface(), found.x, found.y, names.index("point-2"), len(names), SEED)
    begun = TrialLoop(made, world_of(made)).run(0, SEED).trajectory["points"][0]
    others = [index for index, name in enumerate(names) if name != "point-2"]
    np.testing.assert_allclose(points[:, others], np.broadcast_to(begun[others], (4, len(others), 3)), atol=1e-7)
    assert set(found.marks) == {"point-1", "point-3"}
    x, y = found.marks["point-1"]
    direction = np.array([np.sin(y) * np.cos(x), np.sin(y) * np.sin(x), np.cos(y)])
    np.testing.assert_allclose(direction, begun[0] / np.linalg.norm(begun[0]), atol=1e-6)


@pytest.mark.parametrize("shape", ["sphere", "ellipsoid", "cylinder", "superquadric", "bottle"])
def test_a_contact_starts_on_the_surface_in_its_direction(shape: str) -> None:
    fields = {
        "sphere": "diameter: 0.1",
        "ellipsoid": "size: [0.1, 0.15, 0.22]",
        "cylinder": "diameter: 0.1, height: 0.2",
        "superquadric": "size: [0.1, 0.15, 0.22], exponent: 6.0",
        "bottle": "diameter: 0.08, height: 0.22, neck_diameter: 0.03, body_height: 0.13, neck_height: 0.04, "
        "shoulder: 0.015, edge: 0.008",
    }[shape]
    made = program("compare/cstar.yaml", f"scene.object={{{shape}: {{{fields}}}}}")
    surface = made.body.shape.surface()
    random = np.random.default_rng(1).normal(size=(200, 3))
    directions = np.vstack([random / np.linalg.norm(random, axis=1)[:, None], np.eye(3), -np.eye(3)])
    points = towards(surface, directions)
    np.testing.assert_allclose(points / np.linalg.norm(points, axis=1)[:, None], directions, atol=1e-9)
    assert np.abs(surface.level(points)).max() < 1e-12
    along = np.linspace(0.01, 0.999, 50)[:, None, None]
    assert np.all(surface.level(along * points) < 0.0)


def test_a_grid_in_parts_is_the_grid_as_a_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """How many cells are run at once makes no difference; what is done is told."""
    made, told = program("compare/moment_subject_to_force.yaml"), list[int]()
    whole = floating_cells(made, axes(5, 3), None, SEED)
    monkeypatch.setattr("graspdsl.trials.maps.TOGETHER", 4)
    parts = floating_cells(made, axes(5, 3), None, SEED, told.append)
    assert told == [4, 8, 12, 15]
    assert parts.outcomes == whole.outcomes
    np.testing.assert_array_equal(parts.ticks, whole.ticks)
    np.testing.assert_array_equal(parts.orientation, whole.orientation)


@pytest.mark.parametrize(
    ("wanted", "contact", "settings", "code"),
    [
        ([WantedAxis("roll", None, 2), WantedAxis("polar", None, 2)], None, (), "unknown-start-parameter"),
        ([WantedAxis("azimuth", None, 2), WantedAxis("polar", (0.0, 4.0), 2)], None, (), "out-of-range"),
        (axes(2, 2), "point-9", (), "unknown-contact"),
        (axes(2, 2), "point-5", (), "unknown-contact"),
    ],
)
def test_what_cannot_be_mapped_is_refused(
    wanted: list[WantedAxis], contact: str | None, settings: tuple[str, ...], code: str
) -> None:
    with pytest.raises(DiagnosticError) as caught:
        floating_cells(program("compare/cstar.yaml", *settings), wanted, contact, SEED)
    [diagnostic] = caught.value.diagnostics
    assert diagnostic.code == code
    assert diagnostic.hint


def test_contacts_of_another_world_are_not_taken_for_floating_ones() -> None:
    made = replace(program("compare/cstar.yaml"), world=Gliding())
    with pytest.raises(DiagnosticError, match="starts of gliding contacts cannot be mapped"):
        floating_cells(made, axes(2, 2), None, SEED)
