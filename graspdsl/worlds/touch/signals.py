"""How a sensor's readings differ from what it measures: noise, bias, drift, quantisation, rate, filter, latency."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from graspdsl.arrays import Array

BLOCK = 256  # samples of noise that are drawn at once
ROUNDING = 1e-6  # of a step


@dataclass(frozen=True, slots=True)
class Flaws:
    """Noise, bias, drift and quantum of each of the d numbers of a reading, (d,), in its units.

    noise: standard deviation of a sample; bias: of what is drawn once; drift: of a random walk after one second;
    quantum: the step that samples are rounded to, 0 for none.
    """

    noise: Array
    bias: Array
    drift: Array
    quantum: Array

    @property
    def none(self) -> bool:
        """Whether samples are exact."""
        return not any(part.any() for part in (self.noise, self.bias, self.drift, self.quantum))


@dataclass(frozen=True, slots=True)
class Timing:
    """When samples are taken and arrive.

    rate [Hz]; latency, filter (a time constant) and step (of the clock) [s]; period: of the readings, in steps.
    """

    rate: float
    latency: float
    filter: float
    step: float
    period: int


class Sample(NamedTuple):
    """Samples taken at one step: how many, and their mean (k, d)."""

    step: int
    taken: int
    values: Array


class SensorSignal:
    """Readings of k alike sensors of d numbers each, with their memory; time is counted in steps of a clock, from 1.

    Each sensor has its own random numbers, made from its own seed. A reading is the mean of the samples that arrived
    within the last period; when none did, it is the newest that has arrived, and before any has, the first.
    """

    def __init__(self, flaws: Flaws, timing: Timing, seeds: Sequence[np.random.SeedSequence]) -> None:
        self._flaws, self._timing, self._is_exact = flaws, timing, flaws.none
        self._random = [np.random.default_rng(seed) for seed in seeds]
        shape = (len(seeds), len(flaws.noise))
        self._bias = np.array([random.normal(size=shape[1]) for random in self._random]).reshape(shape) * flaws.bias
        self._drift = np.zeros(shape)
        self._noise = np.zeros((shape[0], 0, shape[1]))
        self._taken = 0
        self._filtered: Array | None = None
        self._samples: deque[Sample] = deque()

    def due(self, step: int) -> bool:
        """Whether a sample falls on this step of the clock or lies behind."""
        return self._due(step) > self._taken

    def wait(self, step: int) -> int:
        """In how many steps after this one the next sample falls due."""
        return max(1, math.ceil((self._taken + 1 - ROUNDING) / (self._timing.step * self._timing.rate)) - step)

    def _due(self, step: int) -> int:
        return math.floor(step * self._timing.step * self._timing.rate + ROUNDING)

    def sample(self, step: int, values: Array) -> None:
        """Take the samples that are due, of the true values (k, d)."""
        count = self._due(step) - self._taken
        self._taken += count
        measured = values if self._is_exact else self._measured(values, count)
        if self._filtered is not None and self._timing.filter > 0.0:
            share = -math.expm1(-count / (self._timing.rate * self._timing.filter))
            measured = self._filtered + share * (measured - self._filtered)
        self._filtered = measured
        self._samples.append(Sample(step, count, measured))

    def _measured(self, values: Array, count: int) -> Array:
        """The mean of ``count`` samples of the same values."""
        flaws = self._flaws
        walk = math.sqrt(count / self._timing.rate)
        if flaws.drift.any():
            steps = np.array([random.normal(size=len(flaws.drift)) for random in self._random])
            self._drift = self._drift + walk * flaws.drift * steps
        samples = (values + self._bias + self._drift)[:, None] + self._draw(count) * flaws.noise
        if flaws.quantum.any():
            quantum = np.where(flaws.quantum > 0.0, flaws.quantum, 1.0)
            samples = np.where(flaws.quantum > 0.0, np.round(samples / quantum) * quantum, samples)
        return np.asarray(samples.mean(axis=1))

    def _draw(self, count: int) -> Array:
        while self._noise.shape[1] < count:
            size = (BLOCK, self._noise.shape[2])
            more = np.array([random.normal(size=size) for random in self._random])
            self._noise = np.concatenate([self._noise, more], axis=1)
        drawn, self._noise = self._noise[:, :count], self._noise[:, count:]
        return drawn

    def read(self, step: int) -> Array:
        """The reading (k, d) at this step of the clock. At least one sample must have been taken."""
        timing = self._timing
        latest = step - timing.latency / timing.step + ROUNDING
        while len(self._samples) > 1 and self._samples[1].step <= latest - timing.period:
            self._samples.popleft()
        arrived = [sample for sample in self._samples if sample.step <= latest]
        fresh = [sample for sample in arrived if sample.step > latest - timing.period] or arrived[-1:]
        if len(fresh) <= 1:
            return (fresh or self._samples)[0].values
        total = sum(sample.taken for sample in fresh)
        return np.asarray(sum(sample.taken * sample.values for sample in fresh) / total)
