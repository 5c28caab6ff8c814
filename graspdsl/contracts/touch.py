"""The contract of tactile sensors: what they feel of balls that are pressed by hand."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from graspdsl.arrays import Array
from graspdsl.contracts.keys import not_again, too_lenient, undescribed, unsaid
from graspdsl.contracts.numbers import shown
from graspdsl.contracts.pressed_balls import CLOCK, PressedBalls, run
from graspdsl.contracts.rule import Breach, contract
from graspdsl.declared import misdeclared
from graspdsl.spec.scene import GRAVITY
from graspdsl.spec.sensing import SampledSensor, TactileSensor
from graspdsl.worlds.touch.fingertip_sensor import FingertipSensor

PRESS = 0.8  # N
SEEDS = 4
POINT, FORCE, NORMAL = 5e-4, 0.06, 0.06  # m, N, 1: that a perfect reading may be off, as a grid of taxels is
SAME = 1e-9
OFFSET = 0.05  # in the units of a reading
FLAW = 0.01  # in the units of a flaw
TICKS, REST = 2000, 50  # of noise, and before it
RATIO = 1.5  # by which noise may differ from what is said of it


def declared(sensor: type[FingertipSensor]) -> Iterator[Breach]:
    """What a sensor says of itself is there, and of the right type, with the model of its settings."""
    yield from misdeclared(sensor, FingertipSensor)
    if not issubclass(sensor.model, TactileSensor):
        yield f"its model is {sensor.model.__name__}", "derive the model from TactileSensor or SampledSensor"


def told(sensor: type[FingertipSensor]) -> Iterator[Breach]:
    """Docstrings, and lines for lists, say what it is, what contacts are said to have, and what its settings are."""
    yield from unsaid(sensor, "name", "about", "called")
    yield from unsaid(sensor.model, "about")


def keys(sensor: type[FingertipSensor]) -> Iterator[Breach]:
    """Each key is described, with its unit, and has a default: a sensor that is only named is perfect."""
    yield from undescribed(sensor.model)
    for name, field in sensor.model.model_fields.items():
        if field.is_required():
            yield f"the key {name} has no default", "let a sensor without parameters be a perfect one"
    if not sensor.model().is_perfect or sensor.model().is_random:
        yield "without parameters it is not perfect", "let the defaults of its flaws be 0"


def round_trip(sensor: type[FingertipSensor]) -> Iterator[Breach]:
    """Settings that are written out are read as the same, and nonsense is refused."""
    yield from not_again(_flawed(sensor))
    yield from too_lenient(sensor.model())


def presses(sensor: type[FingertipSensor]) -> Iterator[Breach]:
    """A perfect sensor feels where a ball presses, along which normal, and how hard."""
    for seed in range(SEEDS):
        made, hand = _rested(sensor, sensor.model(), seed)
        hand.forces = [PRESS, 0.0]
        step = run(made, 10)
        strengths, found = made.strengths(step, hand.frames()), made.contact(0)
        point, normal, force = (part[0] for part in hand.contacts())
        if np.shape(strengths) != (2,) or abs(strengths[0] - PRESS) > FORCE:
            yield f"pressed with {PRESS} N it feels {shown(strengths)}", "give strengths (k,) in N"
        elif np.abs(found.point - point).max() > POINT:
            yield f"touched at {shown(point)} it feels {shown(found.point)}", "give the point in the world"
        elif np.abs(found.normal - normal).max() > NORMAL:
            yield (
                f"touched along {shown(normal)} it feels {shown(found.normal)}",
                "give the unit normal into the object",
            )
        elif np.abs(found.force - force).max() > FORCE:
            yield (
                f"it presses with {shown(force)} N and feels {shown(found.force)}",
                "give the force on the object, in the world",
            )
        else:
            continue
        return


def place(sensor: type[FingertipSensor]) -> Iterator[Breach]:
    """The place of a contact in the frame of its tip is its point in the world."""
    made, hand = _rested(sensor, sensor.model())
    hand.forces = [PRESS, PRESS]
    made.strengths(run(made, 10), hand.frames())
    for tip, (origin, rotation) in enumerate(hand.frames()):
        found = made.contact(tip)
        if np.abs(origin + rotation @ found.place - found.point).max() > SAME:
            yield (
                f"{shown(found.place)} in the frame of tip {tip} is not {shown(found.point)}",
                "point = origin + rotation @ place",
            )


def nothing(sensor: type[FingertipSensor]) -> Iterator[Breach]:
    """Where nothing presses it feels nothing, not even the weight of the tip; what it knows ahead is the normal."""
    made, hand = _rested(sensor, sensor.model())
    hand.places = [(origin, rotation.T) for origin, rotation in hand.places]  # the weight lies elsewhere now
    strengths = made.strengths(run(made, 10), hand.frames())
    if np.abs(strengths).max() > SAME:
        yield f"where nothing presses it feels {shown(strengths)} N", "take the weight of the tip off"
    for tip in range(len(hand.forces)):
        ahead = made.normal_ahead(tip)
        if ahead is not None and np.abs(ahead - hand.inward[tip]).max() > SAME:
            yield (
                f"before a surface along {shown(hand.inward[tip])} it knows {shown(ahead)}",
                "give the normal into the surface",
            )


def harder(sensor: type[FingertipSensor]) -> Iterator[Breach]:
    """What presses harder feels stronger, each tip by itself."""
    made, hand = _rested(sensor, sensor.model())
    felt, step = [], 10
    for force in (0.2, 0.4, 0.8, 1.6):
        hand.forces = [force, 0.0]
        step = run(made, step, 2)
        felt.append(made.strengths(step, hand.frames()))
    if not (np.diff(np.array(felt)[:, 0]) > 0.0).all():
        yield f"pressed harder and harder it feels {shown(np.array(felt)[:, 0])} N", "let it grow with the force"
    if np.abs(np.array(felt)[:, 1]).max() > SAME:
        yield "a tip feels what presses on another", "keep the rows of tips apart"


def tares(sensor: type[FingertipSensor]) -> Iterator[Breach]:
    """Taring takes a constant offset of what is measured off; what has no zero keeps it."""
    if _rested(sensor, sensor.model())[0].signal is None:
        return

    def measured(self: FingertipSensor) -> Array:
        return np.asarray(sensor.measured(self) + OFFSET)

    felt = []
    for kind in (sensor, type("Offset", (sensor,), {"measured": measured})):
        made, hand = _rested(kind, sensor.model())
        hand.forces = [PRESS, 0.5 * PRESS]
        felt.append(made.strengths(run(made, 10), hand.frames()))
    same = np.abs(felt[0] - felt[1]).max() < SAME
    if sensor.tares and not same:
        yield (
            f"tared at an offset it feels {shown(felt[1])} instead of {shown(felt[0])} N",
            "take self.zero off in strengths",
        )
    elif same and not sensor.tares:
        yield "an offset of its readings vanishes, though it says that it has no zero", "say tares = True"


def seeds(sensor: type[FingertipSensor]) -> Iterator[Breach]:
    """What is random comes from the seed alone."""
    if not _flawed(sensor).is_random:
        return
    one, again, other = (_noise(sensor, _flawed(sensor), 5, seed) for seed in (1, 1, 2))
    if not np.array_equal(one, again):
        yield "the same seed gives other readings", "draw from the seed that is given, and from nothing else"
    elif np.array_equal(one, other):
        yield "its flaws are the same for every seed", "give its flaws() their sizes"
    elif not np.isfinite(one).all():
        yield "with flaws its readings are not finite", "mind forces that are next to nothing"


def noise(sensor: type[FingertipSensor]) -> Iterator[Breach]:
    """The white noise of a tick's force is what the settings say of it."""
    if not issubclass(sensor.model, SampledSensor):
        return
    settings = _flawed(sensor, "noise").model_copy(update={"touch": sensor.model().touch})
    said = settings.force_noise_at(CLOCK.control)
    felt = _noise(sensor, settings, TICKS)[:, 0].std(axis=0).max()
    if not said / RATIO <= felt <= said * RATIO:
        yield f"the noise of its force is {felt:.3g} N, it says {said:.3g} N", "mend force_noise_at"


RULES = contract(
    declared, told, keys, round_trip, presses, place, nothing, harder, tares, seeds, noise, wording=(told,)
)


def _rested(
    sensor: type[FingertipSensor], settings: Any, seed: int = 0, noise_seed: int = 1
) -> tuple[FingertipSensor, PressedBalls]:
    """A sensor of two balls after a tick at rest, without a force, and tared."""
    hand = PressedBalls.drawn(0.0, 0.0, seed=seed)
    made = sensor(settings, hand, GRAVITY, CLOCK, np.random.SeedSequence(noise_seed))
    made.tare(run(made, 0))
    return made, hand


def _flawed(sensor: type[FingertipSensor], *kinds: str) -> TactileSensor:
    """Settings with flaws, or with those of some kinds alone; of a sensor that has none, the usual ones."""
    names = getattr(sensor.model, "flaws", ())
    chosen: dict[str, Any] = {name: FLAW / 10 for name in names if not kinds or name.endswith(kinds)}
    return sensor.model(**chosen)


def _noise(sensor: type[FingertipSensor], settings: TactileSensor, ticks: int, seed: int = 1) -> Array:
    """The forces (t, k, 3) [N] of balls that press evenly, once they are felt."""
    made, hand = _rested(sensor, settings, noise_seed=seed)
    hand.forces, felt = [PRESS, PRESS], []
    step = run(made, 10, REST)
    for _ in range(ticks):
        step = run(made, step)
        made.strengths(step, hand.frames())
        felt.append([made.contact(tip).force for tip in range(len(hand.forces))])
    return np.array(felt)
