"""Each monitor by itself, on what it sees of several trials: it speaks at its bound, of those that it is about."""

from __future__ import annotations

import dataclasses
import math
from collections import deque

import numpy as np
import pytest

from graspdsl.arrays import Array, Flags
from graspdsl.hands.descriptions import joint_limits, robot
from graspdsl.spec.monitors import MONITORS, MonitorBounds, Progress, ProgressMonitor
from graspdsl.spec.watching import OFF, Monitor, Setting, Sight, When
from graspdsl.worlds.floating import Floating

BARRETT = robot("barrett", "gantry")
JOINTS = tuple(BARRETT.joints)
LOWER, UPPER = (np.array(limits) for limits in joint_limits(BARRETT))
MIDDLE = (LOWER + UPPER) / 2


def setting(count: int = 2, began: Array = MIDDLE, rate: float = 50.0, *, probes: bool = False) -> Setting:
    """Trials of three fingers whose joints began at a position."""
    all_began = np.tile(began, (count, 1))
    return Setting(BARRETT.contacts, JOINTS, "palm", LOWER, UPPER, all_began, 0.05, probes, rate)


def sight(count: int = 2, time: float = 0.0, **changes: object) -> Sight:
    """Trials in which nothing is wrong; what is changed is so in the first of them alone."""
    nobody: list[tuple[str, ...]] = [()] * count
    plain = Sight(
        rows=np.arange(count),
        time=np.full(count, time),
        grasp=(2, 0, 1),
        touching=np.ones((count, 3), dtype=bool),
        touched=np.ones(count, dtype=bool),
        joints=np.tile(MIDDLE, (count, 1)),
        stopped=np.zeros((count, len(JOINTS)), dtype=bool),
        links=nobody,
        table_links=nobody,
        lean=np.zeros(count),
        shift=np.zeros(count),
        force_residual=np.ones(count),
        moment_residual=np.zeros(count),
        met=np.zeros(count, dtype=bool),
        awaits_residual=True,
        limit=30.0,
        waited_for=lambda place: f"trial {place} waits",
    )
    values = {name: getattr(plain, name) for name in changes}
    for name, value in changes.items():
        first = np.asarray(value)[None] if isinstance(values[name], np.ndarray) else [value]
        rest = values[name][1:]
        values[name] = np.concatenate([first, rest]) if isinstance(rest, np.ndarray) else [*first, *rest]
    return dataclasses.replace(plain, **values)


def watch(key: str, bound: object = "on", **given: object) -> Monitor:
    """A monitor with the bound that a spec gives it."""
    bounds = MonitorBounds.model_validate({key: bound})
    [found] = [monitor for monitor in bounds.watches(setting(**given)) if monitor.key == key]
    return found


def which(*names: str) -> Flags:
    """Flags of joints by name."""
    return np.array([joint in names for joint in JOINTS])


@pytest.mark.parametrize(
    ("key", "bound", "change", "said"),
    [
        ("palm", "on", {"links": ("distal-1",)}, None),
        ("palm", "on", {"links": ("distal-1", "palm")}, "the palm touched the object"),
        ("link", "stop", {"links": ("palm",)}, None),
        ("link", "stop", {"links": ("distal-1", "palm")}, "distal-1 touched the object"),
        ("table", "on", {"table_links": ("tip-1", "tip-2")}, "tip-1, tip-2 touched the table"),
        ("lean", "on", {"lean": 0.34}, None),
        ("lean", "on", {"lean": 0.36}, "the object leant 0.36 rad"),
        ("shift", "on", {"shift": 0.099}, None),
        ("shift", "on", {"shift": 0.101}, "the object was moved 101 mm"),
        ("dragged", "on", {"shift": 0.019}, None),
        ("dragged", "on", {"shift": 0.021}, "a low residual, but the object was dragged 21 mm"),
        ("lost", "stop", {"touching": np.array([False, True, False])}, f"{BARRETT.contacts[2]} lost the object"),
        ("lost", "stop", {"touching": np.array([False, True, True]), "touched": np.bool_(False)}, None),
        ("joint_limit", "on", {"stopped": which("base-1")}, None),
    ],
)
def test_each_monitor_speaks_at_its_bound(key: str, bound: str, change: dict[str, object], said: str | None) -> None:
    monitor, seen = watch(key, bound), sight(**change)
    assert monitor.speaks(seen).tolist() == [said is not None, False]
    assert said is None or monitor.detail(seen, 0) == said


LASTING: list[tuple[str, dict[str, object]]] = [
    ("palm", {"links": ("palm",)}),
    ("link", {"links": ("medial-1",)}),
    ("table", {"table_links": ("distal-2",)}),
    ("lost", {"touching": np.array([True, False, True])}),
    ("joint_limit", {"stopped": which("base-1"), "joints": MIDDLE + 0.1}),
]


@pytest.mark.parametrize(("key", "change"), LASTING, ids=[key for key, _ in LASTING])
def test_a_time_runs_anew_when_its_cause_has_gone_or_another_stage_begins(key: str, change: dict[str, object]) -> None:
    monitor = watch(key, 1.0)

    def at(time: float, there: bool) -> list[bool]:
        spoken: list[bool] = monitor.speaks(sight(time=time, **(change if there else {}))).tolist()
        return spoken

    assert [at(0.0, True), at(1.0, True), at(1.02, False)] == [[False, False]] * 3
    assert [at(1.04, True), at(2.04, True), at(2.06, True)] == [[False, False], [False, False], [True, False]]
    assert monitor.detail(sight(**change), 0).endswith(" for 1 s")
    monitor.begin_anew(np.array([0]))
    assert [at(2.1, True), at(3.1, True), at(3.12, True)] == [[False, False], [False, False], [True, False]]


def test_each_contact_has_its_own_time() -> None:
    monitor = watch("lost")
    first, second = np.array([False, True, True]), np.array([True, False, True])
    assert not monitor.speaks(sight(time=0.0, touching=first)).any()
    assert not monitor.speaks(sight(time=1.5, touching=second)).any()
    assert not monitor.speaks(sight(time=3.0, touching=second)).any()
    assert monitor.speaks(sight(time=3.6, touching=second)).tolist() == [True, False]


def test_a_joint_at_its_limit_is_no_hindrance_where_it_began_or_when_the_end_is_reached() -> None:
    pressing = {"stopped": which("base-1")}
    assert not watch("joint_limit", "stop").speaks(sight(**pressing)).any()
    moved = watch("joint_limit", "stop", began=MIDDLE - 0.5)
    assert not moved.speaks(sight(met=np.bool_(True), **pressing))[0]
    assert moved.speaks(sight(**pressing))[0]
    assert moved.detail(sight(**pressing), 0) == "base-1 at a limit"


def test_what_kept_a_trial_from_its_end_is_said_by_who_knows() -> None:
    away = sight(touching=np.array([False, True, False]))
    assert (
        watch("lost").out_of_time(away, 0)
        == f"{BARRETT.contacts[2]}, {BARRETT.contacts[0]} made no contact within 30 s"
    )
    assert watch("lost").out_of_time(away, 1) is None
    at_limit = sight(joints=np.where(which("base-1"), UPPER, MIDDLE))
    assert watch("joint_limit").out_of_time(at_limit, 0) == "base-1 at a limit"
    assert watch("joint_limit", began=UPPER).out_of_time(at_limit, 0) is None
    assert all(watch(key).out_of_time(away, 0) is None for key in MONITORS if key not in ("lost", "joint_limit"))


@pytest.mark.parametrize(("fall", "stalls"), [(0.90, False), (0.995, False), (1.0, True), (0.9999, True)])
def test_progress_is_a_fall_of_the_residual(fall: float, stalls: bool) -> None:
    monitor = watch("progress", {"window": 0.2})
    found = [bool(monitor.speaks(sight(force_residual=fall**tick))[0]) for tick in range(40)]
    assert any(found) is stalls
    assert not any(found[:19])  # two windows of ten are needed


def test_a_window_of_probes_is_counted_in_probes() -> None:
    monitor = watch("progress", {"probes": 3, "window": 6.0}, probes=True)
    assert [bool(monitor.speaks(sight())[0]) for _ in range(6)] == [False] * 5 + [True]


def test_a_residual_that_is_low_or_that_nobody_waits_for_need_not_fall() -> None:
    for change in ({"met": np.bool_(True)}, {"awaits_residual": False}):
        monitor = watch("progress", {"window": 0.1})
        seen = sight(**{name: value for name, value in change.items() if name == "met"})
        seen = dataclasses.replace(seen, awaits_residual=change.get("awaits_residual", True))
        assert not any(monitor.speaks(seen)[0] for _ in range(40))


def test_the_progress_of_many_is_watched_as_that_of_one() -> None:
    """Random residuals that fall for a while: the same tick of giving up, whenever a row's stage began."""
    random, window, steps, count = np.random.default_rng(3), 8, 60, 20
    falling = np.exp(-np.arange(steps)[:, None] * random.uniform(0.0, 0.02, count))
    force = falling * random.uniform(0.9, 1.0, (steps, count))
    moment = 0.05 * falling * random.uniform(0.9, 1.0, (steps, count))
    anew = random.integers(0, count, count)
    monitor = ProgressMonitor(Progress(window=window / 50), setting(count))
    given_up = np.full(count, -1)
    for step in range(steps):
        monitor.begin_anew(np.flatnonzero(anew == step))
        rows = np.flatnonzero(given_up < 0)
        plain = sight(len(rows))
        seen = dataclasses.replace(
            plain, rows=rows, force_residual=force[step, rows], moment_residual=moment[step, rows]
        )
        given_up[rows[monitor.speaks(seen)]] = step
    for row in range(count):
        history, alone = deque[float](maxlen=2 * window), -1
        for step in range(anew[row], steps):
            history.append(math.hypot(force[step, row], moment[step, row] / 0.05))
            values = list(history)
            if len(values) == 2 * window and min(values[window:]) > 0.98 * min(values[:window]):
                alone = step
                break
        assert given_up[row] == alone
    assert -1 in given_up
    assert len(set(given_up)) > 3


def test_what_is_off_does_not_watch() -> None:
    off = MonitorBounds.model_validate(dict.fromkeys(MONITORS, OFF))
    assert off.watches(setting()) == []
    held = MonitorBounds.model_validate({"palm": True}).in_effect(held=True)
    watching = {monitor.key for monitor in held.watches(setting())}
    assert watching == {"palm", "table", "lost", "joint_limit", "progress"}


def test_what_a_world_lacks_is_not_watched() -> None:
    watching = {monitor.key for monitor in MonitorBounds().watches(setting(), Floating.lacks)}
    assert watching == {"progress"}


def test_every_monitor_says_when_it_speaks() -> None:
    assert [key for key, monitor in MONITORS.items() if monitor.when is not When.TICK] == ["dragged", "progress"]
