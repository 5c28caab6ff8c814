"""The contract of monitors."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import fields, replace
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from graspdsl.arrays import Flags, Rows
from graspdsl.contracts.rule import Breach, contract
from graspdsl.declared import misdeclared
from graspdsl.hands.descriptions import joint_limits, robot
from graspdsl.spec.monitors import MONITORS, OUTCOMES
from graspdsl.spec.outcomes import Outcome
from graspdsl.spec.watching import OFF, Monitor, SceneFacts, Setting, Sight

ROBOT = robot("barrett", "gantry")
LOWER, UPPER = (np.array(limits) for limits in joint_limits(ROBOT))
LINKS = ((), (ROBOT.hand.palm,), ("distal-1",), ("distal-1", ROBOT.hand.palm))
TRIALS, TICKS, TICK = 5, 60, 1.0  # s, or longer where a bound is: what may last for seconds lasts for few ticks
LASTING = 6  # ticks
SEEN = tuple(field.name for field in fields(Sight) if field.name != "waited_for")
LISTS, OF_ALL = ("links", "table_links"), ("grasp", "awaits_residual", "limit", "waited_for")
NO_WAIT_SLIDING, WAIT_PROBING = ((), TICK), ((30.0,), None)
WITHOUT_MONITOR = (Outcome.CONVERGED, Outcome.TIMEOUT, Outcome.UNDONE, Outcome.INFEASIBLE_START, Outcome.CRASHED)
UNIT = r"\((1|m|s|N|rad)\)"


def declared(monitor: type[Monitor]) -> Iterator[Breach]:
    """What a monitor says of itself is there, and of the right type."""
    yield from misdeclared(monitor, Monitor)


def key(monitor: type[Monitor]) -> Iterator[Breach]:
    """A key is a word, or some, joined by _, as the other keys of a spec are."""
    if not re.fullmatch(r"[a-z]+(_[a-z]+)*", monitor.key):
        yield f"its key is {monitor.key!r}", "use small letters, words joined by _"


def table(monitor: type[Monitor]) -> Iterator[Breach]:
    """A monitor is found by its own key."""
    if MONITORS.get(monitor.key) is not monitor:
        found = MONITORS[monitor.key].__name__ if monitor.key in MONITORS else "nothing"
        yield f"{monitor.key} names {found} in the table", f"enter it as {monitor.key}"


def description(monitor: type[Monitor]) -> Iterator[Breach]:
    """A description ends with the outcome, and has the unit of a bound that is a number."""
    text = monitor.description
    if f": {monitor.outcome.value}" not in text:
        yield "its description does not name its outcome", f"write ': {monitor.outcome.value}' after what it watches"
    if isinstance(monitor.default, int | float) and not re.search(UNIT, text):
        yield "its description has no unit for its bound", "write it in brackets, as (m)"


def bound(monitor: type[Monitor]) -> Iterator[Breach]:
    """Its default, its words and 'off' are values of its bound; 'on' is the default, and so not off."""
    if monitor.default == OFF:
        yield "its default is off, and 'on' stands for the default", "give the bound that 'on' means"
    values = {"the default": monitor.default, "off": OFF}
    values |= {f"the word {word!r}": value for word, value in monitor.words.items()}
    adapter: TypeAdapter[Any] = TypeAdapter(monitor.bound_type)
    for name, value in values.items():
        try:
            adapter.validate_python(value)
        except ValidationError as error:
            yield f"{name}, {value!r}, is no value of its bound: {error.errors()[0]['msg']}", "let bound_type have it"


def outcome(monitor: type[Monitor]) -> Iterator[Breach]:
    """Its outcome has a meaning, and a map tells it from all others by grey and hatching."""
    own = monitor.outcome
    if not own.means:
        yield f"what {own.value} means is not said", "give the outcome its meaning"
    if not re.fullmatch(r"[a-z]+(-[a-z]+)*", own.value):
        yield f"its outcome is called {own.value!r}", "use small letters, words joined by -"
    if own in WITHOUT_MONITOR:
        yield f"trials end as {own.value} without a monitor", "end trials with an outcome of its own"
    others = {known.value: known for known in (*OUTCOMES.values(), *(kind.outcome for kind in MONITORS.values()))}
    for other in others.values():
        if other.value != own.value and (other.grey, other.hatching) == (own.grey, own.hatching):
            yield f"a map shows {own.value} as it shows {other.value}", "choose another grey or hatching"
    for kind in MONITORS.values():
        if kind.key != monitor.key and kind.outcome == own:
            yield f"{own.value} is the outcome of {kind.key}", "end trials with an outcome of its own"


def answer(monitor: type[Monitor]) -> Iterator[Breach]:
    """It speaks of each trial that it sees, true or false, (M,)."""
    watch, seen = _made(monitor), _story(monitor)[0]
    for rows in (np.arange(TRIALS), np.array([3, 1])):
        found = watch.speaks(_of(seen, rows))
        if not (isinstance(found, np.ndarray) and found.shape == (len(rows),) and found.dtype == bool):
            yield f"speaks gives {found!r} for {len(rows)} trials", "give an array of truth values, one a trial"
            return


def first_tick(monitor: type[Monitor]) -> Iterator[Breach]:
    """At a first tick at which nothing is wrong it ends no trial."""
    if np.any(_made(monitor).speaks(_sound())):
        yield "it ends a trial at its first tick, though nothing is wrong", "see what its default allows"


def detail(monitor: type[Monitor]) -> Iterator[Breach]:
    """Of a trial that it ends it says why, in a line; of one whose time is up, a line or nothing."""
    watch, spoken = _made(monitor), False
    for seen in _story(monitor):
        for place in np.flatnonzero(watch.speaks(seen)).tolist():
            spoken = True
            said = watch.detail(seen, place)
            if not _is_line(said):
                yield f"of a trial that it ends it says {said!r}", "say what is wrong, in a line"
                return
        for place in range(TRIALS):
            late = watch.out_of_time(seen, place)
            if late is not None and not _is_line(late):
                yield f"of a trial whose time is up it says {late!r}", "say a line, or nothing: None"
                return
    if not spoken:
        yield f"it ends none of {TRIALS} trials in which everything goes wrong by turns", "see what it waits for"


def beside(monitor: type[Monitor]) -> Iterator[Breach]:
    """What it says of a trial is the same whoever is beside it, and whoever has left."""
    story, half, staying = _story(monitor), TICKS // 2, np.array([1, 3, 4])
    together = _spoken(_made(monitor), story)
    left = _made(monitor)
    _spoken(left, story[:half])
    same = np.array_equal(_spoken(left, [_of(seen, staying) for seen in story[half:]]), together[half:, staying])
    for row in range(TRIALS):
        alone = _spoken(_made(monitor), [_of(seen, np.array([row])) for seen in story])
        same = same and np.array_equal(alone[:, 0], together[:, row])
    if not same:
        yield "of a trial beside others it says something else than of it alone", "keep what it has seen by sight.rows"


def anew(monitor: type[Monitor]) -> Iterator[Breach]:
    """When trials begin another stage, what it saw of them is forgotten, and that of the others kept."""
    story, begun = _story(monitor), np.array([1, 3])
    before, after = story[: TICKS // 2], story[TICKS // 2 :]
    watch, kept = _made(monitor), _made(monitor)
    _spoken(watch, before)
    _spoken(kept, before)
    watch.begin_anew(begun)
    fresh, again, other = _spoken(_made(monitor), after), _spoken(watch, after), _spoken(kept, after)
    if not np.array_equal(again[:, begun], fresh[:, begun]):
        yield "it remembers of a stage what it saw in the one before", "forget in begin_anew"
    rest = np.setdiff1d(np.arange(TRIALS), begun)
    if not np.array_equal(again[:, rest], other[:, rest]):
        yield "when a trial begins another stage it forgets others", "forget in begin_anew those of its rows alone"


def pure(monitor: type[Monitor]) -> Iterator[Breach]:
    """It leaves what it sees as it is."""
    seen = _story(monitor)[3]
    before = {name: deepcopy(getattr(seen, name)) for name in SEEN}
    _made(monitor).speaks(seen)
    if any(np.any(getattr(seen, name) != before[name]) for name in SEEN):
        yield "it changes what it sees", "make new arrays: no out=, no +="


def reach(monitor: type[Monitor]) -> Iterator[Breach]:
    """Why no trial can reach its bound is said in a line, or nothing is: None."""
    bounds = {kind.key: kind.default for kind in (*MONITORS.values(), monitor)}
    for waiting, tick in NO_WAIT_SLIDING, WAIT_PROBING:
        said = monitor.out_of_reach(monitor.default, SceneFacts({}, 30.0, waiting, tick, bounds))
        if said is not None and not _is_line(said):
            yield f"out_of_reach says {said!r}", "say a line, or nothing: None"
            return


RULES = contract(
    declared,
    key,
    table,
    description,
    bound,
    outcome,
    answer,
    first_tick,
    detail,
    beside,
    anew,
    pure,
    reach,
    wording=(description,),
)


def _made(monitor: type[Monitor]) -> Monitor:
    began = np.tile((LOWER + UPPER) / 2, (TRIALS, 1))
    setting = Setting(
        ROBOT.contacts,
        tuple(ROBOT.joints),
        ROBOT.hand.palm,
        LOWER,
        UPPER,
        began,
        0.05,
        probes=False,
        rate=1.0 / _tick(monitor),
    )
    return monitor(monitor.default, setting)


def _tick(monitor: type[Monitor]) -> float:
    """So long [s] that what goes wrong lasts for twice as long as the bound allows, if that is of seconds."""
    bound = monitor.default
    return max(TICK, 2.0 * bound / LASTING) if isinstance(bound, int | float) else TICK


def _sound() -> Sight:
    """A first tick at which nothing is wrong, and the end not reached."""
    count, contacts, joints = TRIALS, len(ROBOT.contacts), len(ROBOT.joints)
    return Sight(
        rows=np.arange(count),
        time=np.zeros(count),
        grasp=tuple(range(contacts)),
        touching=np.ones((count, contacts), dtype=bool),
        touched=np.ones(count, dtype=bool),
        joints=np.tile((LOWER + UPPER) / 2, (count, 1)),
        stopped=np.zeros((count, joints), dtype=bool),
        links=[()] * count,
        table_links=[()] * count,
        lean=np.zeros(count),
        shift=np.zeros(count),
        force_residual=np.ones(count),
        moment_residual=np.zeros(count),
        met=np.zeros(count, dtype=bool),
        awaits_residual=True,
        limit=30.0,
        waited_for=lambda place: f"the end conditions of trial {place}",
    )


def _story(monitor: type[Monitor]) -> list[Sight]:
    """Trials in which everything goes wrong by turns, at random, for some ticks each; the same for each run. Residuals
    change from tick to tick, and every other time nothing does."""
    random, plain, story = np.random.default_rng(7), _sound(), []
    for tick in range(TICKS):
        if tick % LASTING == 0:
            wrong = replace(
                plain,
                touching=random.random(plain.touching.shape) < 0.5,
                joints=LOWER + random.random(plain.joints.shape) * (UPPER - LOWER),
                stopped=random.random(plain.stopped.shape) < 0.1,
                links=[LINKS[chosen] for chosen in random.integers(len(LINKS), size=TRIALS)],
                table_links=[LINKS[chosen] for chosen in random.integers(len(LINKS), size=TRIALS)],
                lean=random.uniform(0.0, 1.0, TRIALS),
                shift=random.uniform(0.0, 0.3, TRIALS),
            )
        if tick % LASTING == 0 or tick // LASTING % 2 == 0:
            wrong = replace(
                wrong,
                force_residual=random.uniform(0.5, 1.5, TRIALS),
                moment_residual=random.uniform(0.0, 0.1, TRIALS),
                met=random.random(TRIALS) < 0.1,
            )
        story.append(replace(wrong, time=np.full(TRIALS, tick * _tick(monitor))))
    return story


def _of(seen: Sight, rows: Rows) -> Sight:
    """What is seen of some of the trials."""
    values: Mapping[str, Any] = {
        name: [getattr(seen, name)[row] for row in rows] if name in LISTS else getattr(seen, name)[rows]
        for name in SEEN
        if name not in OF_ALL
    }
    return replace(seen, **values)


def _spoken(watch: Monitor, story: Sequence[Sight]) -> Flags:
    """At which ticks it speaks of which trials, (ticks, M)."""
    return np.array([watch.speaks(_of(seen, np.arange(len(seen.rows)))) for seen in story])


def _is_line(said: object) -> bool:
    return isinstance(said, str) and bool(said) and "\n" not in said
