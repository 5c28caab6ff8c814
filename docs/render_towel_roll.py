"""Render the picture of the README: a start, and where the controller took that hand in each engine.

Run it with the developers' tools installed: python docs/render_towel_roll.py
"""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from PIL import Image

from graspdsl.compiler.program import program_of
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.replay import Replay
from graspdsl.trials.runner import execute, new_run
from graspdsl.trials.store import RunFolder
from graspdsl.worlds.annotations import annotated

ROOT = Path(__file__).resolve().parent.parent
SPEC = ROOT / "specs/towel_roll_two_contacts.yaml"
ENGINES = {"bullet": "PyBullet", "mujoco": "MuJoCo"}
TRIALS = 12
ASKEW = 1.0  # rad: a start is shown that is farther than that from an opposed grasp


def _run(world: str, folder: Path) -> RunFolder:
    overrides = (f"scene.world={world}", f"trials.count={TRIALS}")
    made = new_run(folder / world, program_of(SPEC.read_text("utf-8"), SPEC.name, overrides))
    execute(made, workers=2)
    return made


def _fit_to_be_shown(run: RunFolder) -> set[int]:
    """The trials that began far from the grasp and ended in it."""
    records = run.records()
    return {
        record.number for record in records if record.outcome is Outcome.CONVERGED and record.orientation_start < ASKEW
    }


def _panel(replay: Replay, tick: int, what: str) -> Image.Image:
    replay.show(tick)
    caption = f"{what}, t = {replay.rows['time'][tick]:.1f} s"
    return annotated(replay.studio.picture(replay.camera), replay.arrows(tick), [caption])


def main() -> None:
    """Run the trials in both engines, and put three pictures of one side by side, taken by one camera."""
    with ExitStack() as held:
        folder = Path(held.enter_context(tempfile.TemporaryDirectory()))
        runs = [_run(world, folder) for world in ENGINES]
        number = min(set.intersection(*map(_fit_to_be_shown, runs)))
        replays = [held.enter_context(Replay(run, number, width=440, height=400)) for run in runs]
        for replay in replays:
            replay.camera = replays[0].camera
        touching = replays[0].rows["touching"].all(axis=1)
        panels = [_panel(replays[0], int(np.argmax(touching)), "all fingers touch")]
        panels += [
            _panel(replay, replay.ticks - 1, f"converged, {engine}")
            for replay, engine in zip(replays, ENGINES.values(), strict=True)
        ]
        picture = np.hstack([np.asarray(panel) for panel in panels])
        Image.fromarray(picture).save(ROOT / "docs/images/towel_roll.png", optimize=True)


if __name__ == "__main__":
    main()
