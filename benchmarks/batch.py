"""Floating contacts, three a trial, side by side: trial-steps a second of whole runs against a numpy batch written by
hand, against one trial after the other, and on JAX.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from hand_written import FloatingGrasp, FloatingGraspByCoordinate
from measuring import Row, in_turn, ratio_of

from graspdsl.arrays import Array
from graspdsl.compiler.program import Program, program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.trials.loop import TrialLoop
from graspdsl.trials.record import Trial
from graspdsl.trials.setup import trial_loop
from graspdsl.worlds.floating import sensed, slid

SPEC = Path(__file__).resolve().parents[1] / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
TRIALS, SINGLES, ROUNDS, SEED = 1024, 8, 7, 0
JAX = "control.backend=jax"


def rows() -> Iterator[Row]:
    """The batch against each of them, by the time of a trial-step."""
    program = program_of(SPEC.read_text("utf-8"), SPEC.name)
    trials = sorted(run(program, TRIALS, TRIALS), key=lambda trial: trial.record.number)
    counts = np.array([trial.record.samples for trial in trials])
    starts = starts_of(program, trials)
    by_hand = FloatingGrasp(program), FloatingGraspByCoordinate(program)
    for batch in by_hand:
        assert_same(program, batch, starts, trials)
    most = round(program.spec.program[0].limit * program.world.rate)
    actions: dict[str, Callable[[], object]] = {
        "as it runs": lambda: run(program, TRIALS),
        "all at once": lambda: run(program, TRIALS, TRIALS),
        "one by one": lambda: run(program, SINGLES, 1),
        "by hand": lambda: by_hand[0].run(starts, most),
        "by hand, long axis last": lambda: by_hand[1].run(starts, most),
    }
    lean = "trajectories" in inspect.signature(TrialLoop.run_all).parameters
    if lean:
        actions["without trajectories"] = lambda: run(program, TRIALS, TRIALS, trajectories=False)
    (pipeline,) = program.pipelines()[0]
    seen = sensed(program.body.shape.surface(), everywhere(program, starts), 0.0, 1.0)
    actions["ticks"] = lambda: pipeline.ticks(seen, certified=False)
    reason = ""
    try:
        on_jax = program_of(SPEC.read_text("utf-8"), SPEC.name, (JAX,))
        (compiled,) = on_jax.pipelines()[0]
        actions["jax"] = lambda: run(on_jax, TRIALS, TRIALS)
        actions["ticks on jax"] = lambda: compiled.ticks(seen, certified=False)
        actions["ticks on jax"]()
    except (DiagnosticError, ImportError) as error:
        reason = f"no JAX here: {str(error).splitlines()[0]}"
        actions = {name: action for name, action in actions.items() if "jax" not in name}
    times = in_turn(actions, ROUNDS)
    steps = dict.fromkeys(times, int(counts.sum()))
    steps |= {"one by one": int(counts[:SINGLES].sum()), "ticks": TRIALS, "ticks on jax": TRIALS}
    each = {name: taken / steps[name] for name, taken in times.items()}
    said = ", ".join(f"{name} {1.0 / np.median(taken):.3g}" for name, taken in each.items()) + " trial-steps/s"
    hand, last = each["by hand"], each["by hand, long axis last"]
    what = f"floating, k = 3, {TRIALS} trials"
    yield ratio_of(f"{what}, as they run / plain numpy batch by hand", each["as it runs"], hand, "≤ 1.2", said)
    yield ratio_of(f"{what} at once / plain numpy batch by hand", each["all at once"], hand, "≤ 1.2")
    if lean:
        yield ratio_of(f"{what} at once, no trajectories / the same", each["without trajectories"], hand, "≤ 1.2")
    else:
        yield Row(f"{what} at once, no trajectories / the same", note="there is no option for it")
    yield ratio_of(f"{what} at once / numpy batch with the long axis last", each["all at once"], last, "")
    yield ratio_of("floating, k = 3, one by one / as they run", each["one by one"], each["as it runs"], "≥ 100")
    if "jax" in each:
        yield ratio_of(f"{what} at once: numpy / JAX, all cores", each["all at once"], each["jax"], "≥ 3")
        yield ratio_of(
            f"a tick of {TRIALS} trials alone: numpy / JAX, all cores", each["ticks"], each["ticks on jax"], ""
        )
    else:
        yield Row(f"{what} at once: numpy / JAX, all cores", bound="≥ 3", note=reason)


def run(program: Program, trials: int, together: int | None = None, **options: Any) -> list[Trial]:
    """A run of so many trials, so many side by side."""
    loop = trial_loop(program)
    if together is not None:
        loop.together = together
    return list(loop.run_all(range(trials), SEED, **options))


def starts_of(program: Program, trials: list[Trial]) -> Array:
    """Where the contacts of the grasp began, (N, k, 3), of numbers as they are before they are stored."""
    contacts, count = list(program.phases[0].grasp.contacts), len(program.robot.contacts)
    surface = program.body.shape.surface()
    noted = np.array([trial.trajectory["points"][0] for trial in trials], dtype=float)
    drawn = surface.nearest(noted.reshape(len(trials), count, 3))
    return np.asarray(drawn[:, contacts])


def everywhere(program: Program, starts: Array) -> Array:
    """All contacts of the hand, (N, c, 3), those of the grasp at their starts and the others at the top."""
    points = np.zeros((len(starts), len(program.robot.contacts), 3))
    points[..., 2] = program.body.shape.surface().extent[2] / 2
    points[:, list(program.phases[0].grasp.contacts)] = starts
    return points


def assert_same(program: Program, by_hand: FloatingGrasp, starts: Array, trials: list[Trial]) -> None:
    """One step is the compiled one to 1e-12; whole trials take as many steps, and end where theirs do, as far as
    trajectories are stored."""
    (pipeline,), surface = program.pipelines()[0], program.body.shape.surface()
    contacts = list(program.phases[0].grasp.contacts)
    placed = everywhere(program, starts)
    moved = pipeline.ticks(sensed(surface, placed, 0.0, 1.0), certified=False).displacement
    mine, _ = by_hand.tick(by_hand.laid(starts))
    after = by_hand.back(by_hand.slid(by_hand.laid(starts), mine))
    np.testing.assert_allclose(after, slid(surface, placed, moved)[:, contacts], rtol=0.0, atol=1e-12)
    ended, counts = by_hand.run(starts, round(program.spec.program[0].limit * program.world.rate))
    assert counts.tolist() == [trial.record.samples for trial in trials]
    stored = np.array([trial.trajectory["points"][-1][contacts] for trial in trials])
    np.testing.assert_allclose(ended, stored, rtol=0.0, atol=1e-6)
