"""What stands between a quantity and its readings, number by number."""

from __future__ import annotations

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.worlds.touch.signals import Flaws, SensorSignal, Timing

ENGINE, PERIOD = 500.0, 10  # Hz, and steps of the engine a control tick


def signal(
    *,
    noise: float = 0.0,
    bias: float = 0.0,
    drift: float = 0.0,
    quantum: float = 0.0,
    rate: float = 50.0,
    latency: float = 0.0,
    filter: float = 0.0,  # noqa: A002
    seed: int = 0,
    size: int = 1,
) -> SensorSignal:
    """Two sensors of ``size`` numbers."""
    flaws = Flaws(*(np.full(size, value) for value in (noise, bias, drift, quantum)))
    return SensorSignal(flaws, Timing(rate, latency, filter, 1 / ENGINE, PERIOD), np.random.SeedSequence(seed).spawn(2))


def readings(sensor: SensorSignal, values: Array) -> Array:
    """The readings (n / 10, 2, d) at each control tick while the quantity takes values (n, …), one each step.

    They begin with the first sample.
    """
    read, sampled = [], False
    for step, value in enumerate(values, start=1):
        if sensor.due(step):
            sampled = True
            sensor.sample(step, np.broadcast_to(value, (2, sensor_size(sensor))))
        if sampled and step % PERIOD == 0:
            read.append(sensor.read(step))
    return np.array(read)


def sensor_size(sensor: SensorSignal) -> int:
    """How many numbers a reading has."""
    return len(sensor._flaws.noise)


RAMP = np.arange(1.0, 501.0)  # the number of the step


def test_a_perfect_sensor_reads_what_is() -> None:
    np.testing.assert_array_equal(readings(signal(), RAMP)[:, 0, 0], RAMP[9::10])


@pytest.mark.parametrize("latency", [0.002, 0.02, 0.05, 0.1])
def test_latency_delays_readings(latency: float) -> None:
    sensor = signal(rate=ENGINE, latency=latency)
    late = readings(sensor, RAMP)[:, 0, 0]
    steps = round(latency * ENGINE)
    settled = late[steps // PERIOD + 1 :]
    # The mean of ten samples is half a tick old on its own.
    np.testing.assert_allclose(settled, RAMP[9::10][-len(settled) :] - steps - 4.5)


def test_latency_of_a_sensor_read_once_a_tick_is_rounded_up_to_ticks() -> None:
    late = readings(signal(latency=0.025), RAMP)[:, 0, 0]
    np.testing.assert_array_equal(late[4:], RAMP[9::10][2:-2])


def test_the_first_sample_stands_in_for_those_before() -> None:
    late = readings(signal(latency=0.1), RAMP)[:, 0, 0]
    np.testing.assert_array_equal(late[:6], 10.0)


def test_a_slow_sensor_holds_its_samples() -> None:
    held = readings(signal(rate=12.5), RAMP)[:, 0, 0]
    np.testing.assert_array_equal(held, np.repeat(RAMP[39::40], 4)[: len(held)])


def test_a_fast_sensor_averages_its_samples() -> None:
    np.testing.assert_allclose(readings(signal(rate=ENGINE), RAMP)[:, 0, 0], RAMP.reshape(-1, 10).mean(axis=1))


@pytest.mark.parametrize(("rate", "averaged"), [(50.0, 1), (500.0, 10), (5000.0, 100)])
def test_white_noise_averages_out(rate: float, averaged: int) -> None:
    read = readings(signal(noise=2.0, rate=rate, size=50), np.zeros(2000))
    assert read.std() == pytest.approx(2.0 / np.sqrt(averaged), rel=0.03)
    assert abs(read.mean()) < 0.1
    assert abs(np.corrcoef(read[:-1].ravel(), read[1:].ravel())[0, 1]) < 0.04


def test_a_bias_is_drawn_once() -> None:
    read = np.array([readings(signal(bias=0.5, seed=seed, size=6), np.zeros(30)) for seed in range(300)])
    assert np.ptp(read, axis=1).max() == 0.0
    assert read[:, 0].std() == pytest.approx(0.5, rel=0.05)
    assert abs(read[:, 0].mean()) < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("rate", [50.0, 500.0, 2000.0])
def test_drift_is_a_random_walk(rate: float) -> None:
    read = np.array([readings(signal(drift=0.1, rate=rate, seed=seed, size=20), np.zeros(1000)) for seed in range(20)])
    assert read[:, -1].std() == pytest.approx(0.1 * np.sqrt(2.0), rel=0.1)
    assert read[:, 49].std() == pytest.approx(0.1, rel=0.1)


def test_samples_are_rounded_to_the_quantum() -> None:
    values = np.linspace(-1.0, 1.0, 500)
    read = readings(signal(quantum=0.3), values)[:, 0, 0]
    np.testing.assert_allclose(read / 0.3, np.round(read / 0.3), atol=1e-9)
    assert np.abs(read - values[9::10]).max() <= 0.15 + 1e-9
    assert len(np.unique(np.round(read / 0.3))) == 7


def test_the_filter_has_its_time_constant() -> None:
    step = np.concatenate([np.zeros(50), np.ones(450)])
    read = readings(signal(rate=ENGINE, filter=0.1), step)[:, 0, 0]
    after = (np.arange(50, 500).reshape(-1, 10).mean(axis=1) - 50 + 1) / ENGINE
    np.testing.assert_allclose(read[5:], 1.0 - np.exp(-after / 0.1), atol=2e-3)


def test_sensors_and_seeds_differ_and_repeat() -> None:
    one, again = (readings(signal(noise=1.0, bias=1.0, drift=1.0, rate=ENGINE), RAMP) for _ in range(2))
    other = readings(signal(noise=1.0, bias=1.0, drift=1.0, rate=ENGINE, seed=1), RAMP)
    np.testing.assert_array_equal(one, again)
    assert np.abs(one - other).min() > 0.0
    assert np.abs(one[:, 0] - one[:, 1]).min() > 0.0


def test_reading_twice_changes_nothing() -> None:
    sensor = signal(noise=1.0, rate=ENGINE, latency=0.02)
    for step in range(1, 101):
        sensor.sample(step, np.full((2, 1), float(step)))
    np.testing.assert_array_equal(sensor.read(100), sensor.read(100))
