"""Where trials begin: poses of the hand drawn from a spec's distributions."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace

import numpy as np

from graspdsl.objects.shapes import Body
from graspdsl.spec.distributions import Choice, Normal, Uniform
from graspdsl.spec.trials import StartSettings
from graspdsl.worlds.protocol import Start
from graspdsl.worlds.start_pose import pose

ORIENTATION = ("roll", "yaw", "tilt")
PLACEMENT = ("height", "standoff", "offset")
PLACEMENTS_EACH = 100


def generator(seed: int, trial: int) -> np.random.Generator:
    """The random numbers of one trial: the same for a seed and a trial number, whatever else is run."""
    return np.random.default_rng(np.random.SeedSequence([seed, trial]))


def draws(
    start: StartSettings, body: Body, palm_surface: float, random: np.random.Generator, *, floats: bool = False
) -> Generator[Start, bool, None]:
    """Start poses of the hand's mounting face before a standing object at the origin, one after the other.

    A world takes the first that it can take up. Since experiments ask how orientations fare, the next draw keeps the
    orientation and posture of the hand and draws its placement anew; after PLACEMENTS_EACH of them, or when it is sent
    True, all are drawn anew. Floating contacts have no hand: the world draws them itself. palm_surface [m] is the
    palm's distance ahead of the mounting face.
    """
    if floats:
        while True:
            yield Start(np.zeros(3), np.eye(3), {})
    while True:
        oriented = {name: _value(getattr(start, name), random) for name in ORIENTATION}
        posture = {name: _value(place, random) for name, place in start.posture.items()}
        for _ in range(PLACEMENTS_EACH):
            placed = {name: _value(getattr(start, name), random) for name in PLACEMENT}
            drawn = pose(start.approach or "side", {**oriented, **placed, **posture}, body, palm_surface)
            if (yield replace(drawn, posture=posture)):
                break


def _value(distribution: float | Uniform | Normal | Choice, random: np.random.Generator) -> float:
    match distribution:
        case Uniform(uniform=(low, high)):
            return float(random.uniform(low, high))
        case Normal(normal=(mean, deviation)):
            return float(random.normal(mean, deviation))
        case Choice(choice=values):
            return float(values[random.integers(len(values))])
    return float(distribution)
