"""The chapter's claims, each from trials made by hand: just inside its bound, just outside, and from too few."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from statistics import NormalDist

import pytest
from scipy import stats
from stored_runs import stored_run

from graspdsl.report.claims import Claim, claims_of
from graspdsl.report.evidence import Evidence, evidence_of
from graspdsl.report.judgements import Verdict
from graspdsl.report.summary import summarised
from report.hand_made import HandMade, evidence

pytestmark = pytest.mark.slow

AGREES, DIFFERS, UNTOLD = Verdict
UPRIGHT = math.pi / 2

LARGEST = (1, "The largest peak")
SECOND = (1, "much smaller second peak")
PLACE = (1, "second peak lies near 0.45")
LOW = (1, "low force and moment residuals")
FIRST = (1, "falls first")
MONOTONE = (1, "monotonically")
ITERATIONS = (1, "1000 iterations")
START = (2, "at the start")
NEAR_0 = (2, "peak near 0")
GOOD = (2, "Grasps near 0")
STUCK = (2, "A significant number")
FORCE = (2, "near 1.55")
MOMENT = (2, "similarly low")
BOTTLES = [(n, words) for n in (3, 4) for words in ("one mode", "perpendicular", "low force and moment residuals")]
ALL = [LARGEST, SECOND, PLACE, LOW, FIRST, MONOTONE, ITERATIONS, START, NEAR_0, GOOD, STUCK, FORCE, MOMENT, *BOTTLES]

Point = tuple[int, str]  # of the chapter: an experiment and words of what it says of it
Trials = list[HandMade]


def claims_of_run(run: Evidence) -> list[Claim]:
    """The claims of a run."""
    return claims_of(run, summarised(run))


def claim(point: Point, trials: Sequence[HandMade]) -> Claim:
    """What trials say of a point."""
    experiment, words = point
    [found] = [found for found in claims_of_run(evidence(experiment, trials)) if words in found.says]
    return found


def exact(successes: int, count: int) -> tuple[float, float]:
    """The interval of Clopper and Pearson by another program."""
    found = stats.binomtest(successes, count).proportion_ci(0.95, method="exact")
    return float(found.low), float(found.high)


def alike(count: int, **values: object) -> Trials:
    """So many trials that are the same."""
    return [HandMade(**values)] * count


def aside(count: int, end: float, of: int = 58) -> Trials:
    """Trials of which so many end elsewhere than upright."""
    return alike(of - count) + alike(count, end=end)


def stuck(count: int, force: float = 1.55, moment: float = 0.002, end: float = 1.3) -> Trials:
    """61 trials of which so many are caught, and the others grasp from above."""
    return alike(61 - count, end=0.0) + alike(count, end=end, force=force, moment=moment)


def falling(force: int, moment: int, count: int = 40) -> Trials:
    """Trials whose residuals fall at these ticks, of uneven lengths."""
    whole = max(force, moment) + 2
    forces, moments = (tuple(float(tick < fall) for tick in range(whole)) for fall in (force, moment))
    return alike(count - 1, forces=forces, moments=moments) + alike(1, forces=(*forces, 0.0), moments=(*moments, 0.0))


def rising(to: float, count: int = 40) -> Trials:
    """Trials whose force residual falls by half and then rises, before it falls."""
    return alike(count, forces=(1.0, 0.5, to, 0.0), moments=(1.0, 1.0, 1.0, 0.0))


def told(point: Point, inside: Sequence[Trials], outside: Sequence[Trials]) -> list[tuple[Point, Trials, Verdict]]:
    """Cases of trials that agree and of trials that differ."""
    return [*((point, trials, AGREES) for trials in inside), *((point, trials, DIFFERS) for trials in outside)]


def low(point: Point) -> list[tuple[Point, Trials, Verdict]]:
    """Cases at the bounds of a good grasp's residuals."""
    inside = [alike(31, force=0.099), alike(31, moment=0.0049)]
    return told(point, inside, [alike(31, force=0.101), alike(31, moment=0.0051)])


CASES = [
    *told(LARGEST, [alike(40, end=UPRIGHT - 0.095)], [alike(40, end=UPRIGHT - 0.105)]),
    *told(PLACE, [aside(6, 0.405), aside(6, 0.495)], [aside(6, 0.395), aside(6, 0.505), aside(6, 0.83)]),
    *low(LOW),
    *told(FIRST, [falling(20, 21), falling(450, 451)], [falling(20, 20), falling(451, 450)]),
    *told(FIRST, [], [alike(40, moments=(0.5, 0.6)), alike(40, forces=(0.5, 0.6))]),
    *told(MONOTONE, [rising(0.5), rising(0.549)], [rising(0.551)]),
    *told(ITERATIONS, [alike(40, ticks=751), alike(40, ticks=1249)], [alike(40, ticks=n) for n in (200, 749, 1251)]),
    *told(START, [alike(61, start=0.905), alike(61, start=1.095)], [alike(61, start=0.895), alike(61, start=1.105)]),
    *told(NEAR_0, [alike(61, end=0.095)], [alike(61, end=0.105)]),
    *told(GOOD, [alike(61, end=0.0, force=0.299)], [alike(61, end=0.0, force=0.301)]),
    *told(STUCK, [stuck(20, end=0.801), stuck(20, end=UPRIGHT)], [stuck(20, end=0.799)]),
    *told(FORCE, [stuck(20, 1.505), stuck(20, 1.595)], [stuck(20, force) for force in (1.0, 1.495, 1.605)]),
    *told(MOMENT, [stuck(20, moment=0.0049)], [stuck(20, moment=0.0051)]),
    *told(MOMENT, [], [alike(20, end=0.0, moment=0.0051) + alike(20, end=1.3)]),
    *[case for n in (3, 4) for case in low((n, "low force and moment residuals"))],
    *[
        case
        for n in (3, 4)
        for case in told(
            (n, "perpendicular"), [alike(31, end=UPRIGHT - 0.095)], [alike(31, end=UPRIGHT - 0.105), alike(31, end=0.5)]
        )
    ],
]
# Too few trials for an interval of a number, which takes six; what the others of the run do makes no difference.
FEW = [
    (LARGEST, alike(5)),
    (PLACE, aside(5, 0.45)),
    (PLACE, aside(1, 0.83)),
    (LOW, alike(5)),
    (FIRST, falling(20, 40, count=5)),
    (MONOTONE, rising(0.5, count=5)),
    (ITERATIONS, alike(5, ticks=1000) + alike(53, ticks=None)),
    (START, alike(5)),
    (NEAR_0, alike(5, end=0.0)),
    (GOOD, stuck(56)),
    (FORCE, stuck(5)),
    (MOMENT, stuck(5)),
    *[((n, words), alike(5)) for n in (3, 4) for words in ("perpendicular", "low force and moment residuals")],
]


@pytest.mark.parametrize(("point", "trials", "verdict"), CASES)
def test_a_number_just_inside_and_just_outside_of_its_bound(point: Point, trials: Trials, verdict: Verdict) -> None:
    found = claim(point, trials)
    assert (found.verdict, found.needed) == (verdict, None)


@pytest.mark.parametrize(("point", "trials"), FEW)
def test_too_few_trials_tell_nothing(point: Point, trials: Trials) -> None:
    found = claim(point, trials)
    assert (found.verdict, found.needed) == (UNTOLD, 6)
    assert "at least 6 can" in found.why


def expected(*bounds: tuple[tuple[float, float], float, float]) -> Verdict:
    """The verdict on shares with these intervals between these bounds."""
    if any(high < least or low > most for (low, high), least, most in bounds):
        return DIFFERS
    return AGREES if all(least <= low and high <= most for (low, high), least, most in bounds) else UNTOLD


@pytest.mark.parametrize("of", [20, 58, 108])
def test_a_second_peak_has_several_trials_and_many_fewer_than_the_first(of: int) -> None:
    """One in a hundred at least and half of the first at most, by the intervals of shares; whatever the count."""
    found = {count: claim(SECOND, aside(count, 0.45, of)).verdict for count in range(of // 2)}
    several, smaller = 0.01, 1 / 3
    assert found == {
        count: expected((exact(count, of), several, 1.0), (exact(count, of), 0.0, smaller)) for count in found
    }
    assert found[1] is not AGREES
    assert set(found.values()) == ({AGREES, UNTOLD} if of == 20 else {AGREES, UNTOLD, DIFFERS})


def test_the_second_of_two_peaks_may_be_the_largest() -> None:
    """Where nearly as many end in the next peak, it cannot be told which is the largest, whichever leads."""
    found = {count: claim(LARGEST, aside(count, 0.45, 40)).verdict for count in range(41)}
    assert found == {count: expected((exact(40 - count, 40), 0.5, 1.0)) for count in found}
    assert (found[19], found[20], found[21]) == (UNTOLD, UNTOLD, UNTOLD)
    assert set(found.values()) == {AGREES, UNTOLD, DIFFERS}


@pytest.mark.parametrize(("point", "inverse"), [(STUCK, False), (NEAR_0, True)])
def test_more_than_one_in_ten_is_no_rarity(point: Point, inverse: bool) -> None:
    """From six on, fewer having no place of their peak."""
    shares = range(6, 56)
    found = {count: claim(point, stuck(61 - count if inverse else count)).verdict for count in shares}
    assert found == {count: expected((exact(count, 61), 0.1, 1.0)) for count in shares}
    assert set(found.values()) == {AGREES, UNTOLD}
    assert claim(point, stuck(61 if inverse else 0)).verdict is DIFFERS


@pytest.mark.parametrize(("experiment", "chapter"), [(3, 28), (4, 31)])
def test_one_mode_may_miss_one_of_the_chapter_s_trials(experiment: int, chapter: int) -> None:
    point = (experiment, "one mode")
    for of in (chapter, 3 * chapter):
        found = {count: claim(point, aside(of - count, 0.45, of)).verdict for count in range(of // 2 + 1, of + 1)}
        assert found == {count: expected((exact(count, of), 0.8, 1.0)) for count in found}
        assert set(found.values()) == {AGREES, UNTOLD, DIFFERS}
    assert claim(point, aside(1, 0.45, chapter)).verdict is AGREES
    fewest = next(n for n in range(1, chapter) if exact(n, n)[0] >= 0.8)
    short = claim(point, alike(fewest - 1))
    assert (short.verdict, short.needed) == (UNTOLD, fewest)
    assert claim(point, alike(1)).verdict is UNTOLD


def test_ticks_are_told_to_the_last_of_a_long_course() -> None:
    """Of trials that fall at two ticks far apart the mean is 90 % down at the later one."""
    trials = falling(431, 688, 30) + falling(211, 502, 30)
    measured = claim(FIRST, trials).measured
    assert "the mean force after 431 ticks, the mean moment after 688 ticks, 257 (" in measured


def test_a_mean_is_of_trials_that_keep_their_last_value() -> None:
    """A trial that ends early, and low, lowers the mean at every later tick: force by hand."""
    forces = [tuple(1.0 - tick / 1000.0 for tick in range(1001)), (1.0, 0.0)]
    moments = [tuple(1.0 - tick / 2000.0 for tick in range(1001)), (1.0, 1.0)]
    trials = [HandMade(forces=f, moments=m) for f, m in zip(forces, moments, strict=True)]
    # Mean force: (1 − t/1000)/2 from tick 1 on, 0.1 at 800. Mean moment: 1 − t/4000, of 0.75 in the end, 0.775 at 900.
    assert "the mean force after 800 ticks, the mean moment after 900 ticks, 100 later" in claim(FIRST, trials).measured


def test_trials_out_of_contact_do_not_count() -> None:
    trials = stuck(20) + alike(60, end=1.3, touching=False)
    assert "of 61 that ended in contact" in claim(STUCK, trials).measured
    assert claim(STUCK, trials).verdict is claim(STUCK, stuck(20)).verdict


def test_no_trials_tell_nothing() -> None:
    points = []
    for experiment in range(1, 5):
        for found in claims_of_run(evidence(experiment, [])):
            assert found.verdict is UNTOLD
            assert found.needed is not None
            assert found.why.startswith("0 such trials")
            points += [point for point in ALL if point[0] == experiment and point[1] in found.says]
    assert points == ALL  # every claim there is has its cases here


def test_an_interval_over_a_bound_says_how_many_trials_would_tell() -> None:
    """As many more trials, alike in their share, do tell; in a run larger by as much."""
    found = claim(SECOND, aside(1, 0.45))
    assert found.verdict is UNTOLD
    assert found.needed is not None
    count = round(found.needed / 58)
    assert claim(SECOND, aside(count, 0.45, found.needed)).verdict is AGREES
    few = claim(PLACE, aside(2, 0.45))
    assert few.why == "2 such trials cannot tell: at least 6 can, in a run of 174"


def test_near_a_number_is_told_by_the_estimate_and_far_from_it_by_the_interval() -> None:
    """Starts about 1 rad, however wide they lie; starts about 1.2 rad, when they are many enough."""

    def verdict(middle: float, count: int) -> Verdict:
        spread = NormalDist(middle, 0.2)
        starts = [spread.inv_cdf((place + 0.5) / count) for place in range(count)]
        return claim(START, [trial for start in starts for trial in alike(1, start=start)]).verdict

    assert [verdict(1.0, count) for count in (12, 600)] == [AGREES, AGREES]
    assert [verdict(1.2, count) for count in (12, 600)] == [UNTOLD, DIFFERS]


def test_every_claim_says_its_bound() -> None:
    bounds = {point: claim(point, alike(40)).bound for point in ALL}
    assert all(bounds.values())
    assert "within 0.05 of 1.55" in bounds[FORCE]
    assert "within 0.05 rad of 0.45" in bounds[PLACE]
    assert "750 to 1250" in bounds[ITERATIONS]
    assert "80 %" in bounds[(3, "one mode")]


def test_a_run_of_something_else_has_no_claims(tmp_path: Path) -> None:
    spec = Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml"
    assert claims_of_run(evidence_of(stored_run(tmp_path / "other", spec, begun=False))) == []
