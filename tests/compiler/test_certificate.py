"""Three levels with a virtual contact: what null spaces keep in each space, and what nested projection leaks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.basis import operations
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.worlds.protocol import Observation

from .observations import compiled, observation
from .points import COUNT, of_points, over_points

SEEDS = range(10)


@dataclass(frozen=True)
class Chain:
    """Levels from the highest priority to the lowest, each with the rank of its task, in a space of ``size``."""

    levels: tuple[str, str, str]
    ranks: tuple[int, int, int]
    size: int
    points: bool = True

    def pipeline(self, nullspace: str, *levels: int) -> Pipeline:
        """Of the levels given, all by default."""
        formula = " ◁ ".join(self.levels[level] for level in reversed(levels or (0, 1, 2)))
        return over_points(formula, nullspace=nullspace) if self.points else compiled(formula, nullspace=nullspace)

    def observation(self, seed: int) -> Observation:
        """Random contacts of the hand."""
        return of_points(seed) if self.points else observation(seed)


def _residuals(ending: str, size: int) -> Chain:
    """The moment is left to three contacts of five, so that its gradient is not normal to the force's anyway."""
    return Chain(
        (
            f"φ_fr|τ_fr{ending}(Γ) σ_fr(Γ)",
            f"φ_mr|τ_mr{ending}({{γ1, γ2, γ5}}) σ_mr(Γ)",
            f"φ_fr|τ_fr{ending}({{γ1, γ4}}) σ_fr({{γ1, <γ2, γ4>}})",
        ),
        (3, 3, 3),
        size,
    )


CHAINS = {
    "ψ": _residuals("", 2 * COUNT),
    "x": _residuals("x", 3 * COUNT),
    "q": Chain(
        (
            "φ_f|τ_f(γ3) σ_f(γ3) (κ_f σ_n(γ3))",
            "φ_p|τ_p(<γ1, γ2>) σ_p(<γ1, γ2>) (0.1, 0.2, 0.3)",
            "φ_r|τ_r(γ1) σ_r(γ1) (0, 1, 2)",
        ),
        (1, 6, 3),
        10,
        points=False,
    ),
}
EACH_CHAIN = pytest.mark.parametrize("chain", CHAINS.values(), ids=CHAINS)
EACH_NULLSPACE = pytest.mark.parametrize("nullspace", ["task", "gradient"])


def projections(pipeline: Pipeline, seen: Observation) -> list[tuple[list[Array], Array, Array]]:
    """For the second level and the third: what the higher ones feel, the level before its projection, and after."""
    values = pipeline.values(seen)
    found = []
    for index, step in enumerate(pipeline.steps):
        if step.label.startswith("N Δ"):
            projector, level = step.inputs
            felt = [values[place] for place in pipeline.steps[projector].inputs]
            found.append((felt, values[level], values[index]))
    return found


def projector(felt: list[Array]) -> Array:
    """I − J⁺J of what is felt, tasks (d, D) or gradients (D,), all at once."""
    rows = np.vstack(felt)
    found: Array = np.eye(rows.shape[1]) - np.linalg.pinv(rows, rcond=1e-9) @ rows
    return found


def leak(felt: Array, level: Array, projected: Array) -> float:
    """‖J N δ‖ / (‖J‖ ‖δ‖)."""
    rows = np.atleast_2d(felt)
    return float(np.linalg.norm(rows @ projected) / np.linalg.norm(rows) / np.linalg.norm(level))


@EACH_NULLSPACE
@EACH_CHAIN
def test_three_levels_do_not_reach_what_they_are_projected_past(chain: Chain, nullspace: str) -> None:
    pipeline = chain.pipeline(nullspace)
    for seed in SEEDS:
        for felt, level, projected in projections(pipeline, chain.observation(seed)):
            assert np.linalg.norm(projected) > 1e-6 * np.linalg.norm(level)
            assert max(leak(one, level, projected) for one in felt) < 1e-9


@EACH_NULLSPACE
@EACH_CHAIN
def test_each_level_is_projected_on_the_null_space_of_all_above(chain: Chain, nullspace: str) -> None:
    pipeline = chain.pipeline(nullspace)
    for seed in SEEDS:
        for felt, level, projected in projections(pipeline, chain.observation(seed)):
            np.testing.assert_allclose(projected, projector(felt) @ level, atol=1e-9 * np.linalg.norm(level))


@EACH_NULLSPACE
@EACH_CHAIN
def test_nested_pairwise_projection_leaks_more(chain: Chain, nullspace: str) -> None:
    """N₁ (N₂ δ) is free of the first level, but no longer of the second."""
    pipeline = chain.pipeline(nullspace)
    for seed in SEEDS:
        seen = chain.observation(seed)
        _, ((first, second), level, projected) = projections(pipeline, seen)
        nested = projector([first]) @ projector([second]) @ level
        assert leak(first, level, nested) < 1e-9
        assert leak(second, level, nested) > 1e-4
        assert leak(second, level, nested) > 1e4 * leak(second, level, projected)


@EACH_CHAIN
def test_ranks_are_what_the_higher_levels_leave(chain: Chain) -> None:
    first, second, _ = chain.ranks
    for seed in SEEDS:
        seen = chain.observation(seed)
        assert chain.pipeline("gradient").evaluate(seen).ranks == (chain.size - 1, chain.size - 2)
        by_task = chain.pipeline("task")
        assert by_task.evaluate(seen).ranks == (chain.size - first, chain.size - first - second)
        felt = [np.vstack(above) for above, _, _ in projections(by_task, seen)]
        assert [chain.size - np.linalg.matrix_rank(rows, tol=1e-9) for rows in felt] == list(
            by_task.evaluate(seen).ranks
        )


@pytest.mark.parametrize(("nullspace", "ranks"), [("gradient", (2, 1)), ("task", (1, 0))])
def test_a_turn_of_a_held_object_has_room_for_two_levels(nullspace: str, ranks: tuple[int, int]) -> None:
    """No residual minds a turn about the vertical, so that two gradients in r leave none of a third; nor does the net
    force mind one about its own direction, which is all that its task leaves."""
    weighed = "{γ1, <γ2, γ3>, γ4, γ5, γ_g}"
    force, moment = f"φ_fr|τ_frr(Γ) σ_fr({weighed})", f"φ_mr|τ_mrr({{γ1, γ2, γ5}}) σ_mr({weighed})"
    pipeline = over_points(f"φ_fr|τ_frr({{γ1, γ4}}) σ_fr({{γ1, γ4, γ_g}}) ◁ {moment} ◁ {force}", nullspace=nullspace)
    for seed in SEEDS:
        seen = of_points(seed)
        assert pipeline.evaluate(seen).ranks == ranks
        ((felt,), second, projected), (_, third, nothing) = projections(pipeline, seen)
        assert leak(felt, second, projected) < 1e-9
        assert np.linalg.norm(projected) > 1e-6 * np.linalg.norm(second)
        assert np.linalg.norm(nothing) < 1e-9 * np.linalg.norm(third)
        assert abs(third[2]) < 1e-12


def test_a_level_at_its_goal_takes_no_rank() -> None:
    chain = CHAINS["q"]
    seen = chain.observation(0)
    seen.forces[:] = 0.5 * seen.normals
    assert chain.pipeline("gradient").evaluate(seen).ranks == (10, 9)
    assert chain.pipeline("task").evaluate(seen).ranks == (9, 3)


def test_one_level_has_no_certificate() -> None:
    tick = over_points("φ_fr|τ_fr(Γ) σ_fr(Γ)").evaluate(of_points(0))
    assert tick.ranks == tick.disturbances == ()


@EACH_NULLSPACE
@EACH_CHAIN
def test_certificate_of_a_batch_is_that_of_its_members(chain: Chain, nullspace: str) -> None:
    pipeline = chain.pipeline(nullspace)
    ones = [chain.observation(seed) for seed in range(4)]
    names = ("points", "normals", "forces", "touching", "joints", "jacobian", "angular_jacobian", "orientations")
    stacked = {name: np.stack([getattr(one, name) for one in ones]) for name in (*names, "centre_of_mass", "weight")}
    ticks = pipeline.ticks(Observation(time=0.0, **stacked))
    for index, one in enumerate(ones):
        tick = pipeline.evaluate(one)
        assert tuple(ticks.ranks[index]) == tick.ranks
        found = np.linalg.norm(ticks.parts[index].sum(axis=-2), axis=-1)
        np.testing.assert_array_equal(found, tick.disturbances)


def test_a_rank_is_a_whole_number() -> None:
    assert operations.rank(np.diag([1.0, 0.0, 1.0 - 1e-9])) == 2.0
