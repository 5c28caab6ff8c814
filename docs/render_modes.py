"""Measure how often the modes of a report are wrong: docs/modes.md.

Run it with the package installed: python docs/render_modes.py. It takes some minutes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from graspdsl.arrays import Array
from graspdsl.report.excess_mass import CELLS, levels_of
from graspdsl.report.modes import LEVEL, SAMPLES, modes, share_intervals
from graspdsl.report.statistics import FEWEST, LEAST_BANDWIDTH, RESAMPLES, RIGHT_ANGLE

PLACE = Path(__file__).resolve().parent / "modes.md"
DRAWN, FEWER = 300, 100  # samples of a law with one mode, and of one with two
COUNTS = (20, 58, 200)  # the chapter has 58 trials of its first experiment
ASIDE = 0.45  # rad: where the chapter's smaller peak is
SPREADS = (0.02, 0.05, 0.10, 0.15, 0.20)  # rad
Draws = Callable[[np.random.Generator, int], Array]


@dataclass(frozen=True)
class Law:
    """What samples are drawn from: its name on the page."""

    name: str
    draws: Draws


def folded(values: Array) -> Array:
    """Angles of lines, in 0…π/2."""
    return np.asarray(np.abs(math.pi * np.round(values / math.pi) - values))


ONE_MODE = (
    Law("uniform, 0 to π/2", lambda random, n: random.uniform(0.0, RIGHT_ANGLE, n)),
    Law("normal, 1.3 ± 0.3, cut off at π/2", lambda random, n: random.normal(1.3, 0.3, n).clip(0.0, RIGHT_ANGLE)),
    Law("normal, 1.45 ± 0.1, cut off at π/2", lambda random, n: random.normal(1.45, 0.1, n).clip(0.0, RIGHT_ANGLE)),
    Law("normal, π/2 ± 0.2, folded", lambda random, n: folded(random.normal(RIGHT_ANGLE, 0.2, n))),
    Law("Student's, 2 degrees, 0.8 ± 0.1, folded", lambda random, n: folded(0.8 + 0.1 * random.standard_t(2, n))),
    Law("Cauchy's, π/2 ± 0.05, folded", lambda random, n: folded(RIGHT_ANGLE + 0.05 * random.standard_cauchy(n))),
    Law("uniform, 0.4 to 1.1", lambda random, n: random.uniform(0.4, 1.1, n)),
)


def _mixed(random: np.random.Generator, share: float, some: Array, others: Array) -> Array:
    return np.where(random.random(len(some)) < share, some, others)


def _peak_on_a_plain(random: np.random.Generator, count: int) -> Array:
    return _mixed(random, 0.5, random.uniform(0.0, RIGHT_ANGLE, count), folded(random.normal(1.2, 0.05, count)))


def _in_steps(random: np.random.Generator, count: int) -> Array:
    return 0.05 * np.round(folded(random.normal(0.8, 0.2, count)) / 0.05).clip(0, 31)


# Chosen when the rule was as it is.
STRANGERS = (
    Law("beta, 2 and 5", lambda random, n: RIGHT_ANGLE * random.beta(2.0, 5.0, n)),
    Law("exponential, 0.3 from π/2 down, folded", lambda random, n: folded(RIGHT_ANGLE + random.exponential(0.3, n))),
    Law("half uniform, half normal, 1.2 ± 0.05", _peak_on_a_plain),
    Law("normal, 0.8 ± 0.2, in steps of 0.05", _in_steps),
)


def two_modes(share: float, spread: float) -> Draws:
    """A law with two modes: this share about ASIDE, the rest about π/2, each normal and folded."""
    return lambda random, n: folded(
        _mixed(random, share, random.normal(ASIDE, spread, n), random.normal(RIGHT_ANGLE, spread, n))
    )


def samples(draws: Draws, count: int, how_many: int) -> Iterator[Array]:
    """So many samples of so many values, the same whenever they are drawn."""
    random = np.random.default_rng(count)
    return (draws(random, count) for _ in range(how_many))


def parted(draws: Draws, count: int, how_many: int) -> float:
    """The share of samples that have more than one mode."""
    return float(np.mean([len(modes(values)) > 1 for values in samples(draws, count, how_many)]))


def covered(share: float, spread: float) -> str:
    """Of samples in which two modes are found, how many have the true share in the interval, and its mean ends."""
    found, low, high = [], 0.0, 0.0
    for values in samples(two_modes(share, spread), COUNTS[1], FEWER):
        ranks = modes(values)
        if len(ranks) == 2:
            lesser = share_intervals(values, ranks)[1]
            found.append(lesser[0] <= share <= lesser[1])
            low, high = low + lesser[0], high + lesser[1]
    return f"{sum(found)} of {len(found)} | {percent(low / len(found))} to {percent(high / len(found))}"


def percent(share: float) -> str:
    """A share, to a tenth of a percent."""
    return f"{100.0 * share:.1f} %"


def false_row(law: Law) -> str:
    """How often samples of a law with one mode seem to have more."""
    return _row(law.name, *(percent(parted(law.draws, count, DRAWN)) for count in COUNTS))


def found_row(share: float, count: int) -> str:
    """How often two modes are found, by their spread."""
    rates = (percent(parted(two_modes(share, spread), count, FEWER)) for spread in SPREADS)
    return _row(f"{100 * share:.0f} %", str(count), *rates)


def covered_row(share: float, spread: float) -> str:
    """How often the interval of the lesser mode's share has the true one."""
    return _row(f"{100 * share:.0f} %", f"{spread:.2f} rad", covered(share, spread))


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def _table(heads: Sequence[str], rows: Sequence[str]) -> str:
    return "\n".join([_row(*heads), _row(*("---" for _ in heads)), *rows])


def rows_of(place: int) -> str:
    """One of all rows, by its place."""
    make, *of = ROWS[place]
    return str(make(*of))


MIXTURES = ((0.2, 20), (0.2, 58), (0.2, 200), (0.1, 58), (0.35, 58), (0.5, 58))
INTERVALS = ((0.2, 0.05), (0.2, 0.1), (0.2, 0.15), (0.35, 0.15))
ROWS: list[tuple[Callable[..., str], *tuple[object, ...]]] = [
    *[(false_row, law) for law in (*ONE_MODE, *STRANGERS)],
    *[(found_row, *of) for of in MIXTURES],
    *[(covered_row, *of) for of in INTERVALS],
]
COUNTED = tuple(f"{count} values" for count in COUNTS)


def page(rows: Sequence[str]) -> str:
    """The page, of all rows."""
    one, strange = len(ONE_MODE), len(ONE_MODE) + len(STRANGERS)
    two = strange + len(MIXTURES)
    return f"""# Modes of the end orientation

A report says in how many modes the orientations of grasps ended, where these part, and what share each has. It looks at
trials that settled: those that a monitor stopped (the palm on the object, a joint at its limit) end where they were
stopped, and have a row and ticks of their own.

## The rule

1. *Smoothing.* A Gaussian kernel of {LEAST_BANDWIDTH:g} rad, reflected at 0 and π/2, on {CELLS} cells: grasps that a
   figure does not tell apart are no two modes.
2. *Excess mass* (Müller and Sawitzki 1991). At a level λ, an interval has its mass less λ times its length in excess.
   By how much two intervals have more of it than one, at the level where that is most, is the excess mass of a second
   mode: twice Hartigan's dip. {levels_of(np.ones((1, CELLS))).size} levels are looked at.
3. *Test.* The density of the orientations, by Silverman's rule of thumb, is made to have one mode: on each side of its
   highest peak it becomes the nearest one that only falls. {SAMPLES} samples of as many values are drawn from it. There
   is a second mode where no more than {100 * LEVEL:g} % of them have as much excess mass.
4. *Parts.* Modes part at the lowest point between the two intervals, and each part is asked in turn. Fewer than
   {FEWEST} values have one mode.

What is drawn is drawn from a fixed seed: the same orientations have the same modes.

A density made from a sample is nearer to it than the law that it came from: samples of one mode may seem to have two in
more than {100 * LEVEL:g} % of cases. In how many is measured below: in no law's samples in more than 5 %. What a report
cannot say is that there is no second mode, only that none could be shown; how often one is found stands below, too.

## False second modes

The share of {DRAWN} samples of a law with one mode that seem to have more than one.

{_table(("law", *COUNTED), rows[:one])}

Laws that were chosen when the rule was as it is:

{_table(("law", *COUNTED), rows[one:strange])}

## Second modes that are found

The share of {FEWER} samples in which more than one mode is found. Values are normal about π/2 rad, or with the share
in the first column about {ASIDE:g} rad, where the chapter's first experiment has its peaks, and folded into 0 to π/2.

{_table(("share of the lesser", "values", *(f"± {spread:.2f} rad" for spread in SPREADS)), rows[strange:two])}

The grasps of that experiment that settle scatter by less than 0.02 rad, as their residuals are small only near π/2.

## Intervals of shares

The boundary between modes was chosen in the sample that their shares are counted in. Therefore {RESAMPLES} samples are
drawn from the orientations, each parted anew where that is best, as often as they were; the interval is the middle 95 %
of the shares, and never narrower than Wilson's. It holds given that there are so many modes.

Of {FEWER} samples of {COUNTS[1]} values, those with two modes; how many of them have the true share of the lesser in
its interval, and the mean ends of that:

{_table(("share of the lesser", "spread", "has the true share", "mean interval"), rows[two:])}

Made by `docs/render_modes.py`.
"""


if __name__ == "__main__":
    with ProcessPoolExecutor() as pool:
        PLACE.write_text(page(list(pool.map(rows_of, range(len(ROWS))))), encoding="utf-8")
