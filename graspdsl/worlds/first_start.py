"""Where trials may start: a way for a hand to come at an object, tried on an engine's geometry."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.fingertip_motion import FingertipMotion
from graspdsl.worlds.kind import Anchor, WorldSettings
from graspdsl.worlds.protocol import InfeasibleStartError, Start
from graspdsl.worlds.rigid.kind import RigidBodies
from graspdsl.worlds.start_pose import pose

ALIKE = 0.5  # cosine between the ways in which fingers close that do so side by side
HEIGHTS = (0.5, 0.4, 0.6, 0.7, 0.3, 0.8)  # of the object's, from the side
YAWS = [number * math.pi / 4.0 for number in range(8)]  # of an object that is not round
DEPTHS = (0.02, 0.03, 0.045)  # m of the tips below the object's top, from above
SHIFTS = (0.0, -0.01, 0.01, -0.02, 0.02, 0.03)  # m of a standoff from where fingertips meet behind the middle
LEAST_GAP, PLAY, ASIDE, TURN = 0.004, 0.004, 0.005, 0.1  # m, m, m, rad: of the standoff, the offset and the rest
ROUND = 0.01  # of its width, by which a round object's differs around
HEADINGS = 16
DRAWS, ENOUGH = 6, 4  # starts that are tried in a range, and how many of them must be possible


@dataclass(frozen=True, slots=True)
class FirstStart:
    """Ranges that trials start in: side or top; yaw [rad], None for any; height of the palm [m], from the side; the
    standoff [m] in the middle."""

    approach: str
    yaw: float | None
    height: float
    standoff: float

    def ranges(self) -> dict[str, tuple[float, float]]:
        """The least and the largest of each number of a start."""
        turn = (-TURN, TURN)
        near = max(self.standoff - PLAY, LEAST_GAP)
        return {
            "roll": turn if self.approach == "side" else (0.0, 0.0),
            "height": (self.height, self.height),
            "standoff": (near, near + 2.0 * PLAY),
            "yaw": (-3.14, 3.14) if self.yaw is None else (self.yaw - TURN, self.yaw + TURN),
            "offset": (-ASIDE, ASIDE),
            "tilt": (0.0, 0.0) if self.approach == "side" else turn,
        }

    def lines(self) -> list[str]:
        """The lines of a start in a spec."""
        ranges = {name: ends for name, ends in self.ranges().items() if ends != (0.0, 0.0)}
        if self.approach == "top":
            del ranges["height"]
        written = (
            f"{name}: {_number(low)}" if low == high else f"{name}: {{uniform: [{_number(low)}, {_number(high)}]}}"
            for name, (low, high) in ranges.items()
        )
        return [f"approach: {self.approach}", *written]


def opposing_first(motion: FingertipMotion, contacts: Sequence[str]) -> tuple[list[str], bool]:
    """The contacts of a hand, and whether all but one close side by side: that one, which opposes them, comes first."""
    path = motion.centres(motion.closing(2))
    opened, moved = path[0], path[1] - path[0]
    if len(contacts) < 3:
        return list(contacts), False
    others = [np.delete(opened, number, axis=0).mean(axis=0) for number in range(len(contacts))]
    first = int(np.argmax(np.linalg.norm(opened - np.array(others), axis=1)))
    order = [first, *(number for number in range(len(contacts)) if number != first)]
    level = moved[order[1:], :2]
    lengths = np.linalg.norm(level, axis=1, keepdims=True)
    toward = level / np.where(lengths > 0.0, lengths, 1.0)
    together = bool((toward @ toward.T).min() > ALIKE)
    return [contacts[number] for number in (order if together else sorted(order))], together


def first_start(kind: RigidBodies, settings: WorldSettings, *, side: bool) -> FirstStart:
    """A start that a hand can take up at an object, near where its fingertips meet around it; ``side``: rather from
    the side than from above. Raises InfeasibleStartError, with the last reason, where none was found."""
    from graspdsl.worlds.rigid.settling import resting_pose
    from graspdsl.worlds.rigid.start_postures import StartPostures

    engine = kind.engine(kind.effort.whole(kind.rate))
    free = settings.anchor is Anchor.NONE
    resting = resting_pose(engine, settings.body, settings.table_friction, settings.gravity) if free else None
    postures = StartPostures(engine, settings, resting)
    best: tuple[int, FirstStart | None] = 0, None
    reason = "the hand cannot be around the object"
    try:
        for candidate in _candidates(settings, side):
            possible, why = _tried(postures.find, settings, candidate)
            reason = why or reason
            if possible > best[0]:
                best = possible, candidate
            if possible == DRAWS:
                break
    finally:
        postures.close()
    if best[1] is None or best[0] < ENOUGH:
        raise InfeasibleStartError(reason)
    return best[1]


def _tried(find: Callable[[Start], Array], settings: WorldSettings, candidate: FirstStart) -> tuple[int, str]:
    """How many of some starts in the ranges of a candidate are possible, and why one is not."""
    random, possible, why = np.random.default_rng(0), 0, ""
    middle = {name: (low + high) / 2.0 for name, (low, high) in candidate.ranges().items()}
    for number in range(DRAWS):
        drawn = middle if number == 0 else {n: random.uniform(*ends) for n, ends in candidate.ranges().items()}
        try:
            find(pose(candidate.approach, drawn, settings.body, settings.robot.hand.palm_surface))
            possible += 1
        except InfeasibleStartError as error:
            why = str(error)
            if number == 0:
                break
    return possible, why


def _candidates(settings: WorldSettings, side: bool) -> Iterator[FirstStart]:
    """Starts to be tried, the most promising first."""
    shape, motion = settings.body.shape, FingertipMotion(settings.robot)
    height, reach = shape.extent[2], motion.reach()
    headings = np.arange(HEADINGS) * (2.0 * math.pi / HEADINGS)
    widths = [_width(shape.support, heading) for heading in headings]
    is_round = max(widths) - min(widths) < ROUND * max(widths)
    ways: list[tuple[str, float | None, float, float]] = []
    for approach in ("side", "top") if side else ("top", "side"):
        yaws = sorted(YAWS, key=lambda yaw: _width(shape.support, yaw + math.pi / 2.0))
        for yaw in (0.0,) if is_round else yaws:
            heading = np.array([math.cos(yaw), math.sin(yaw), 0.0])
            width = _width(shape.support, yaw + math.pi / 2.0)
            met = _met(motion, width) - settings.robot.hand.palm_surface
            said = None if is_round else yaw
            if approach == "side":
                middle = met - shape.support(-heading)
                ways += [(approach, said, share * height, middle) for share in HEIGHTS]
            else:
                ways += [(approach, said, height, met - min(deep, height / 2.0)) for deep in (height / 2.0, *DEPTHS)]
    for shift, (approach, said, above, standoff) in itertools.product(SHIFTS, ways):
        if LEAST_GAP <= standoff + shift <= reach:
            yield FirstStart(approach, said, above, standoff + shift)


def _met(motion: FingertipMotion, width: float) -> float:
    """How far ahead [m] of the hand's root the fingertips are when they close on a width [m]."""
    path = motion.centres(motion.closing(40))
    first, others = path[:, 0], path[:, 1:].mean(axis=1)
    gaps = np.linalg.norm((first - others)[:, :2], axis=1) - 2.0 * float(motion.radii.mean())
    return float(path[int(np.argmin(np.abs(gaps - width))), :, 2].mean())


def _width(support: Callable[[Array], float], heading: float) -> float:
    side = np.array([math.cos(heading), math.sin(heading), 0.0])
    return float(support(side) + support(-side))


def _number(value: float) -> str:
    return f"{round(value, 3) + 0.0:.3f}".rstrip("0").rstrip(".")
