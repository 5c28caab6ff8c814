"""The chapter's claims, each from trials made by hand: those that must agree, must differ, and tell nothing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats
from stored_runs import stored_run

from graspdsl.report.claims import Claim, claim, claims_of
from graspdsl.report.evidence import evidence_of
from graspdsl.report.experiment_runs import ExperimentRun
from graspdsl.report.judgements import Verdict
from graspdsl.report.points import EXPERIMENTS
from report.hand_made import HandMade, evidence

AGREES, DIFFERS, UNTOLD, NO_EVIDENCE = Verdict
UPRIGHT = math.pi / 2

LARGEST = (1, "The largest peak")
FUNNEL = (1, "funnels a range")
FEW = (1, "Few trials")
PLACE = (1, "second peak near 0.45")
TOP = (1, "on the top")
FORCE_OUTSIDE = (1, "never significantly decreases")
MOMENT_OUTSIDE = (1, "the moment residual increases")
LOW = (1, "From a variety of starts")
FORCE_NEAR = (1, "Grasps in the peak at π/2")
PERPENDICULAR = (1, "Good grasps are perpendicular")
FIRST = (1, "falls first")
MONOTONE = (1, "monotonically")
ITERATIONS = (1, "1000 iterations")
START = (2, "at the start")
NEAR_0 = (2, "at the end have a peak near 0")
FUNNEL_0 = (2, "funnels grasps from")
GOOD = (2, "Grasps that end near 0")
STUCK = (2, "a significant number")
FORCE = (2, "near 1.55")
MOMENT = (2, "similarly low")

Named = tuple[int, str]  # a point of the chapter: an experiment and words of what it says of it
Trials = list[HandMade]


def held(point: Named, trials: Sequence[HandMade], *overrides: str) -> Claim:
    """What trials say of a point."""
    number, words = point
    experiment = f"experiment-{number}"
    [asked] = [each for each in EXPERIMENTS[experiment] if words in each.says]
    return claim(experiment, asked, ExperimentRun(evidence(number, trials, *overrides)))


def alike(count: int, **values: Any) -> Trials:
    """So many trials that are the same."""
    return [HandMade(**values)] * count


def scattered(count: int) -> Trials:
    """So many trials that end more or less upright."""
    return [HandMade(end=UPRIGHT - stats.halfnorm.ppf((place + 0.5) / count, scale=0.02)) for place in range(count)]


def aside(count: int, end: float = 0.45, of: int = 58, **values: Any) -> Trials:
    """Trials of which so many end elsewhere than upright, out of contact, a monitor stopping them."""
    return alike(of - count) + alike(count, **{"end": end, "touching": False, "stopped": True, **values})


def caught(count: int, of: int = 61, force: float = 1.55, end: float = 1.3, **values: Any) -> Trials:
    """Trials of which so many are caught, and the others grasp from above."""
    return alike(of - count, end=0.01) + alike(count, end=end, force=force, **values)


def falling(force: int, moment: int, count: int = 40) -> Trials:
    """Trials whose residuals fall at these ticks, of uneven lengths."""
    whole = max(force, moment) + 2
    forces, moments = (tuple(float(tick < fall) for tick in range(whole)) for fall in (force, moment))
    return alike(count - 1, forces=forces, moments=moments) + alike(1, forces=(*forces, 0.0), moments=(*moments, 0.0))


def rising(to: float, count: int = 40) -> Trials:
    """Trials whose force residual falls by half and then rises, before it falls."""
    return alike(count, forces=(1.0, 0.5, to, 0.0), moments=(1.0, 1.0, 1.0, 0.0))


def outside(*forces: float, count: int = 8, **values: Any) -> Trials:
    """Trials of which so many end outside of the peak, with this course of the force."""
    return aside(count, forces=forces, **values)


# Of each point: trials that must agree, that must differ, and that tell nothing.
CASES: dict[Named, tuple[list[Trials], list[Trials], list[Trials]]] = {
    LARGEST: (
        [alike(40, end=UPRIGHT - 0.095), aside(8)],
        [alike(40, end=UPRIGHT - 0.105), aside(30, of=40)],
        [alike(5), aside(20, of=40)],
    ),
    FUNNEL: (
        [alike(40), aside(10)],
        [alike(40, end=1.0), alike(40, touching=False), aside(50)],
        [alike(40, start=1.5), aside(29)],
    ),
    FEW: ([aside(8)], [aside(0, of=200), aside(50)], [aside(0), aside(1), aside(29)]),
    PLACE: (
        [aside(8, 0.405), aside(8, 0.495)],
        [aside(8, 0.395), aside(8, 0.505), aside(8, 0.83)],
        [aside(5), aside(1, 0.83), alike(40), alike(50) + alike(4, end=0.38, stopped=True) + alike(4, end=0.52)],
    ),
    TOP: ([aside(8, on_top=True)], [aside(8)], [alike(40), aside(4) + alike(4, end=0.5, on_top=True)]),
    FORCE_OUTSIDE: (
        [outside(1.0, 1.0), outside(1.0, 0.901), outside(1.0, 1.4)],
        [outside(1.0, 0.899), outside(1.0, 0.0)],
        [outside(1.0, 0.5, count=5), outside(1.0, 1.3, count=4) + alike(4, end=0.5, forces=(1.0, 0.5))],
    ),
    MOMENT_OUTSIDE: (
        [aside(8, moments=(0.02, 0.03))],
        [aside(8, moments=(0.03, 0.02)), aside(8, moments=(0.02, 0.02))],
        [aside(4, moments=(0.02, 0.03)) + alike(4, end=0.5, moments=(0.03, 0.02))],
    ),
    LOW: (
        [alike(40, force=0.299), alike(40, moment=0.0099), aside(10)],
        [alike(40, force=0.301), alike(40, moment=0.0101), alike(40, stopped=True), aside(50)],
        [aside(29), alike(5)],
    ),
    FORCE_NEAR: (
        [alike(8, force=0.299), aside(50), alike(6, force=0.001) + alike(1, force=0.05)],
        [alike(8, force=0.301), alike(50, force=0.5) + aside(8, of=8)],
        [alike(5), alike(4, force=0.2) + alike(4, force=0.5), alike(40, stopped=True)],
    ),
    FIRST: (
        [falling(20, 22), falling(450, 452)],
        [falling(20, 20), falling(451, 450), alike(40, moments=(0.5, 0.6)), alike(40, forces=(0.5, 0.6))],
        [falling(20, 40, count=5), falling(20, 40, 10) + falling(40, 20, 10)],
    ),
    MONOTONE: (
        [rising(0.5), rising(0.549)],
        [rising(0.551)],
        [rising(0.5, count=5), rising(0.5, 10) + rising(0.61, 10)],
    ),
    ITERATIONS: (
        [alike(40, ticks=751), alike(40, ticks=1249)],
        [alike(40, ticks=749), alike(40, ticks=1251), alike(40, ticks=200), alike(40, ticks=None)],
        [alike(5, ticks=1000), alike(20, ticks=1000) + alike(20, ticks=None)],
    ),
    NEAR_0: ([alike(61, end=0.095), caught(20)], [alike(61, end=0.105), alike(61, end=1.0)], [alike(5, end=0.0)]),
    FUNNEL_0: (
        [caught(20), caught(50)],
        [alike(61, start=0.0), alike(120, end=1.0)],
        [alike(61, end=1.0), alike(30, end=0.0) + alike(31, start=0.0)],
    ),
    GOOD: (
        [alike(8, end=0.0, force=0.299)],
        [alike(8, end=0.0, force=0.301)],
        [caught(56), alike(8, end=0.0, stopped=True)],
    ),
    STUCK: (
        [caught(20, end=0.801), caught(20, end=UPRIGHT)],
        [caught(20, of=160, end=0.799), caught(100, of=160, stopped=True), caught(100, of=160, touching=False)],
        [caught(1), caught(0)],
    ),
    FORCE: (
        [caught(20, force=1.505), caught(20, force=1.595)],
        [caught(20, force=force) for force in (1.0, 1.495, 1.605)],
        [caught(5), caught(10, force=1.4) + caught(10, force=1.7), caught(20, stopped=True)],
    ),
    MOMENT: (
        [caught(20, moment=0.0074)],
        [caught(20, moment=0.0076), alike(20, end=0.0, moment=0.0076) + alike(20, end=1.3)],
        [caught(5), alike(20, end=0.0), caught(10, moment=0.004) + caught(10, moment=0.011)],
    ),
}
for number, (chapter, width) in {3: (28, 0.065), 4: (31, 0.080)}.items():
    most = width * math.tan(0.1)
    CASES |= {
        (number, "one mode"): (
            [alike(chapter), scattered(3 * chapter - 2) + alike(1, end=0.45) + alike(1, end=0.9)],
            [aside(8), alike(10) + alike(10, end=0.45), alike(20) + alike(30, end=math.nan)],
            [alike(chapter - 1), alike(1)],
        ),
        (number, "The largest peak"): (
            [alike(31, end=UPRIGHT - 0.095)],
            [alike(31, end=UPRIGHT - 0.105), alike(31, end=0.5)],
            [alike(5), aside(16, of=32)],
        ),
        (number, "funnels a range"): (
            [alike(chapter)],
            [aside(16, of=chapter), alike(chapter, end=1.0)],
            [alike(chapter - 1), aside(1, of=chapter), alike(chapter, start=1.5)],
        ),
        (number, "never gets caught"): (
            [alike(chapter, force=0.299), alike(chapter, moment=0.99 * most)],
            [alike(chapter, force=0.301), alike(chapter, moment=1.01 * most), alike(chapter, stopped=True)],
            [alike(chapter - 1), aside(1, of=chapter)],
        ),
        (number, "Averaged over all trials"): (
            [alike(8, force=0.299), alike(8, moment=0.99 * most)],
            [alike(8, force=0.301), alike(8, moment=1.01 * most), aside(30, of=58, force=1.5)],
            [alike(5), aside(11, of=58, force=1.5)],
        ),
    }  # fmt: skip
NOT_JUDGED = [PERPENDICULAR, START]
VERDICTS = [
    pytest.param(point, trials, verdict, id=f"{point[0]}-{point[1]}-{verdict}-{place}")
    for point, cases in CASES.items()
    for verdict, kinds in zip((AGREES, DIFFERS, UNTOLD), cases, strict=True)
    for place, trials in enumerate(kinds)
]


@pytest.mark.slow
@pytest.mark.parametrize(("point", "trials", "verdict"), VERDICTS)
def test_a_claim_can_agree_differ_and_be_untold(point: Named, trials: Trials, verdict: Verdict) -> None:
    found = held(point, trials)
    assert found.verdict is verdict, found
    assert found.could_fail
    assert found.derived
    assert bool(found.why) is (verdict is not AGREES)
    if verdict is not UNTOLD:
        assert found.needed is None


def test_every_claim_has_its_cases() -> None:
    """Or cannot fail, and says so."""
    known = [*CASES, *NOT_JUDGED]
    for experiment, points in EXPERIMENTS.items():
        for point in points:
            named = [name for name in known if f"experiment-{name[0]}" == experiment and name[1] in point.says]
            assert len(named) == 1, point.says
            assert bool(point.could_fail) is (named[0] not in NOT_JUDGED)
    assert sum(map(len, EXPERIMENTS.values())) == len(known)


@pytest.mark.parametrize("point", NOT_JUDGED)
@pytest.mark.parametrize("trials", [alike(40), alike(40, end=0.3, start=0.2, force=2.0, moment=0.1), []])
def test_what_no_run_could_fail_is_no_evidence(point: Named, trials: Trials) -> None:
    found = held(point, trials)
    assert (found.verdict, found.could_fail, found.needed) == (NO_EVIDENCE, "", None)
    assert found.why


@pytest.mark.parametrize("override", ["program.1.full_time=false", "program.1.limit=15.0"])
def test_residuals_of_trials_that_end_as_soon_as_they_are_low_are_no_evidence(override: str) -> None:
    """Whether they are within the bounds or not; to the other claims it makes no difference."""
    for number in (1, 2, 3, 4):
        fixed = [point.says for point in EXPERIMENTS[f"experiment-{number}"] if point.fixed]
        assert fixed
        for says in fixed:
            for trials in (alike(40), aside(30, force=1.5)):
                found = held((number, says), trials, override)
                assert (found.verdict, found.could_fail) == (NO_EVIDENCE, "")
                assert found.measured == held((number, says), trials).measured
                assert "full_time" in found.why
    assert held(FEW, aside(8), override) == held(FEW, aside(8))


def test_residuals_are_those_after_a_fixed_time() -> None:
    """After 1000 ticks at 50 Hz, whatever they were before or are later."""
    low, high = (0.02,) * 1001, (0.5,) * 1000
    assert held(LOW, alike(40, forces=(*low, 0.5))).verdict is AGREES
    assert held(LOW, alike(40, forces=(*high, 0.5, 0.02))).verdict is DIFFERS
    assert held(FORCE_NEAR, alike(40, forces=(*high, 0.02, 0.5))).verdict is AGREES
    assert held(FORCE_OUTSIDE, aside(8, forces=(*(1.0,) * 1001, 0.0))).verdict is AGREES


def test_trials_that_never_began_do_not_count() -> None:
    """Those that began do, however they ended."""
    run = evidence(1, alike(40) + aside(10, of=10))
    assert "of 50" in held(FEW, alike(40) + aside(10, of=10)).measured
    assert len(ExperimentRun(run).begun) == 50


@pytest.mark.parametrize("count", [20, 58])
def test_shares_are_judged_by_exact_intervals(count: int) -> None:
    """Of Clopper and Pearson, by another program, over a bound and across it."""

    def expected(part: int, low: float, high: float = 1.0) -> Verdict:
        least, most = stats.binomtest(part, count).proportion_ci(0.95, method="exact")
        return DIFFERS if most < low or least > high else AGREES if low <= least and most <= high else UNTOLD

    for part in range(0, count + 1, 3):
        assert held(FEW, aside(part, of=count)).verdict is expected(part, 2 / 58, 0.5)
        assert held(LOW, aside(part, of=count)).verdict is expected(count - part, 0.5)
        assert held((3, "never gets"), aside(part, of=count)).verdict is expected(count - part, 0.025 ** (1 / 28))


def test_a_mean_is_of_trials_that_keep_their_last_value() -> None:
    """A trial that ends early, and low, lowers the mean at every later tick: force by hand."""
    forces = [tuple(1.0 - tick / 1000.0 for tick in range(1001)), (1.0, 0.0)]
    moments = [tuple(1.0 - tick / 2000.0 for tick in range(1001)), (1.0, 1.0)]
    trials = [HandMade(forces=f, moments=m) for f, m in zip(forces, moments, strict=True)]
    # Mean force: 1, then (1 − t/1000)/2: 1 + Σ = 250.75 in all, of a fall by 1. Mean moment: 1 − t/4000, by 1/4: 500.5.
    said = "the mean force falls after 251 ticks, the mean moment falls after 500 ticks, 250 later"
    assert said in held(FIRST, trials).measured


def test_an_interval_over_a_bound_says_how_many_trials_would_tell() -> None:
    """As many more trials, alike in their share, do tell; in a run larger by as much."""
    found = held(FEW, aside(3))
    assert found.verdict is UNTOLD
    assert found.needed is not None
    times = math.ceil(found.needed / 58)
    assert held(FEW, aside(3 * times, of=58 * times)).verdict is AGREES
    assert held(PLACE, aside(2)).why == "2 such trials cannot tell: at least 6 can, in a run of 174"


def test_no_trials_tell_nothing() -> None:
    for number in range(1, 5):
        for found in claims_of(evidence(number, [])):
            if found.verdict is not NO_EVIDENCE:
                assert found.verdict is UNTOLD
                assert found.why.startswith("there is no such trial")


@pytest.mark.slow
def test_a_run_of_something_else_has_no_claims(tmp_path: Path) -> None:
    spec = Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml"
    assert claims_of(evidence_of(stored_run(tmp_path / "other", spec, begun=False))) == []


def test_bounds_of_geometry() -> None:
    """What the bounds say of moments, against the moments of contacts set up by hand."""
    tilt, radius = math.tan(0.1), 0.05
    angles = np.array([0.0, 2.0, 4.0]) * np.pi / 3.0
    normals = -np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=-1)
    points = -radius * normals + radius * tilt * np.outer(np.cos(angles), [0.0, 0.0, 1.0])
    level = np.linalg.norm(np.cross(points, normals).sum(axis=0))
    assert f"≤ {1e3 * level:.1f} mm" in held(MOMENT, []).bound
    pair = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    places = -radius * pair + np.outer([-1.0, 1.0], [0.0, 0.0, radius * tilt])
    assert f"≤ {1e3 * np.linalg.norm(np.cross(places, pair).sum(axis=0)):.1f} mm" in held(LOW, []).bound
