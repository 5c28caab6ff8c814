"""Render the picture of the README: a start, where the controller took it, and a trial that the palm ended.

Run it with the developers' tools installed: python docs/render_towel_roll.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from graspdsl.compiler.program import program_of
from graspdsl.trials.loop import TrialLoop
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.setup import world_of
from graspdsl.worlds.bullet.world import BulletWorld
from graspdsl.worlds.camera import Picture
from graspdsl.worlds.protocol import Command, Observation, Start

ROOT = Path(__file__).resolve().parent.parent


class PicturedWorld(BulletWorld):
    """The bullet world, keeping a picture of the first tick at which all contacts touch and of the last one."""

    first: Picture | None = None
    last: Picture | None = None

    def reset(self, start: Start, seed: int) -> Observation:
        """As the bullet world's; forgets the pictures."""
        self.first = None
        return super().reset(start, seed)

    def step(self, command: Command) -> Observation:
        """As the bullet world's."""
        observation = super().step(command)
        if self.first is None and observation.touching.all():
            self.first = self.image(440, 400)
        return observation

    def close(self) -> None:
        """As the bullet world's; takes the last picture before."""
        if self.is_open:
            self.last = self.image(440, 400)
        super().close()


def main() -> None:
    """Find a converged trial that began far from the grasp and one that the palm ended; put them side by side."""
    program = program_of((ROOT / "specs/towel_roll_two_contacts.yaml").read_text("utf-8"), "spec")
    world = world_of(program)
    assert isinstance(world, BulletWorld)
    world = PicturedWorld(world.settings)
    loop = TrialLoop(program, world)
    found: dict[Outcome, tuple[Picture, Picture]] = {}
    for number in range(program.spec.trials.count):
        record = loop.run(number, program.spec.trials.seed).record
        if record.outcome in found or world.first is None or world.last is None or record.orientation_start > 1.0:
            continue
        found[record.outcome] = (world.first, world.last)
        if {Outcome.CONVERGED, Outcome.PALM_COLLISION} <= found.keys():
            break
    good, bad = found[Outcome.CONVERGED], found[Outcome.PALM_COLLISION]
    picture = np.hstack([good[0], good[1], bad[1]])
    Image.fromarray(picture).save(ROOT / "docs/images/towel_roll.png", optimize=True)


if __name__ == "__main__":
    main()
