"""What mean courses do, found where trials scatter: against courses whose means are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from scipy.ndimage import gaussian_filter1d

from graspdsl.arrays import Array
from graspdsl.report.evidence import ResidualCourse
from graspdsl.report.mean_courses import MeanCourses, fall_times, mean_courses

TICKS, RUNS = 400, 60


def falling(time: float) -> Array:
    """A course from one to nothing, exponential with this time constant [ticks]."""
    return np.exp(-np.arange(TICKS) / time)


def scattered(random: np.random.Generator, mean: Array, count: int, size: float) -> Array:
    """Courses (count, t) about a mean: each disturbed smoothly, by ``size`` of the start at first and ever less."""
    noise = gaussian_filter1d(random.normal(size=(count, TICKS)), 10.0, axis=1)
    noise *= size / noise.std() * np.linspace(1.0, 0.0, TICKS)
    found: Array = mean + noise
    return found


def found(force: Array, moment: Array) -> MeanCourses:
    time = np.arange(TICKS) / 50.0
    answer = mean_courses([ResidualCourse(time, f, m) for f, m in zip(force, moment, strict=True)])
    assert answer is not None
    return answer


@pytest.mark.slow
@pytest.mark.parametrize(("count", "size"), [(10, 0.1), (20, 0.2), (58, 0.1)])
def test_scatter_alone_is_no_rise(count: int, size: float) -> None:
    """Of courses whose mean falls all the way, the interval of the rise lies above nothing hardly ever."""
    random = np.random.default_rng(7)
    courses = [scattered(random, falling(35.0), count, size) for _ in range(RUNS)]
    above = sum((found(force, force).rise_interval or (1.0, 1.0))[0] > 0.0 for force in courses)
    assert stats.binomtest(above, RUNS, 0.05, alternative="greater").pvalue > 1e-3


@pytest.mark.slow
def test_a_rise_of_the_mean_is_found() -> None:
    """Of 30 % of the start: its interval holds it, or what is left where the ticks of the rise are guessed wrongly."""
    random = np.random.default_rng(8)
    mean = falling(17.0) + 0.3 * np.exp(-(((np.arange(TICKS) - 150.0) / 20.0) ** 2))
    true = float((mean - np.minimum.accumulate(mean)).max())
    rises = []
    for _ in range(RUNS):
        answer = found(force := scattered(random, mean, 30, 0.1), force)
        assert answer.rise_interval is not None
        assert answer.rise_interval[0] <= answer.rise <= answer.rise_interval[1]
        assert answer.rise_interval[0] > 0.05
        rises.append(answer.rise)
    assert 0.9 * true < np.mean(rises) < 1.02 * true


@pytest.mark.slow
@pytest.mark.parametrize("lag", [0.0, 10.0])
def test_the_interval_of_a_lag_holds_it(lag: float) -> None:
    random, held = np.random.default_rng(9), 0
    for _ in range(RUNS):
        force, moment = (scattered(random, falling(at), 40, 0.05) for at in (35.0, 35.0 + lag))
        low, high = found(force, moment).lag_interval or (np.nan, np.nan)
        held += low <= lag <= high
    assert stats.binomtest(held, RUNS, 0.95, alternative="less").pvalue > 1e-3


def test_how_long_a_mean_takes_to_fall() -> None:
    """τ of an exponential; of steps the mean of their ticks, by how far they fall; whatever a course has of a level."""
    once = np.ones((1, 1))
    assert fall_times(falling(30.0)[None], once) == pytest.approx(30.5, abs=0.01)  # a sum of ticks, half a tick more
    steps = np.array([1.0] * 10 + [0.75] * 30 + [0.0] * 60)
    assert fall_times(steps[None], once) == pytest.approx(0.25 * 10 + 0.75 * 40)
    assert fall_times(0.3 + 2.0 * steps[None], once) == pytest.approx(0.25 * 10 + 0.75 * 40)
    early, late = (np.array([1.0] * tick + [0.0] * (100 - tick)) for tick in (10, 50))
    assert fall_times(np.stack([early, late]), np.array([[1.0, 1.0], [2.0, 0.0]])) == pytest.approx([30.0, 10.0])
    assert np.isnan(fall_times(np.array([[1.0, 0.2, 1.0]]), once)).all()


def test_the_same_trials_have_no_scatter() -> None:
    answer = found(*(np.tile(falling(at), (12, 1)) for at in (20.0, 40.0)))
    assert answer.rise_interval == (0.0, 0.0)
    assert answer.lag_interval == pytest.approx((answer.lag, answer.lag))
    assert answer.lag == pytest.approx(20.0, abs=0.5)
    assert found(*(np.tile(falling(at), (5, 1)) for at in (20.0, 40.0))).rise_interval is None
