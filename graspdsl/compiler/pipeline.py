"""The pipeline: a flat list of numerical steps that turns one observation into one command."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.worlds.protocol import Command, Observation


@dataclass(frozen=True, slots=True)
class Step:
    """One step: a label as the notation writes it, what it computes, its function and the steps it reads."""

    label: str
    about: str
    function: Callable[..., Array]
    inputs: tuple[int, ...] = ()
    reading: str | None = None

    @property
    def constants(self) -> tuple[Any, ...]:
        """What its function holds fixed: gains, caps, arrays."""
        return self.function.args if isinstance(self.function, partial) else ()


@dataclass(frozen=True, slots=True)
class Leak:
    """Where the pipeline measures how much of a lower level reaches a higher one (the priority certificate)."""

    lower: str
    higher: str
    step: int


@dataclass(frozen=True, slots=True)
class Projection:
    """Where a lower level goes through the null space of all higher ones: its displacement ``before`` and ``after``."""

    lower: str
    higher: tuple[str, ...]
    before: int
    after: int


@dataclass(frozen=True, slots=True)
class Tick:
    """What the pipeline made of one observation; units as in :class:`Pipeline`, NaN for an error that there is not.

    ``locked``: (n,) joints that the command would have taken beyond their limits.
    """

    command: Command
    force_residual: Array
    moment_residual: Array
    force_error: float
    leaks: tuple[float, ...]
    ranks: tuple[int, ...]
    locked: Flags


@dataclass(frozen=True, slots=True)
class Ticks:
    """What the pipeline made of many observations at once: as :class:`Tick`, with their leading axes.

    displacement: (..., n) or (..., k, 3); force_residual, moment_residual: (..., 3); force_error: (...); leaks and
    ranks: (..., number of them); locked: (..., n).
    """

    displacement: Array
    force_residual: Array
    moment_residual: Array
    force_error: Array
    leaks: Array
    ranks: Array
    locked: Flags

    def alone(self, space: str) -> Tick:
        """The tick of a single one, without leading axes; its command is in a space. Raises ValueError where that is no
        finite number."""
        if not np.isfinite(self.displacement).all():
            raise ValueError("the command is no finite number: what the observation holds is out of all proportion")
        return Tick(
            command=Command(space, self.displacement),
            force_residual=self.force_residual,
            moment_residual=self.moment_residual,
            force_error=float(self.force_error),
            leaks=tuple(self.leaks.tolist()),
            ranks=tuple(int(rank) for rank in self.ranks),
            locked=self.locked,
        )


@dataclass(frozen=True, slots=True)
class Pipeline:
    """A compiled controller. ``evaluate`` is pure: the same observation gives the same command.

    ``command`` is the step whose value is the displacement; ``force_residual`` and ``moment_residual`` the steps of the
    sensed net unit force (3,) and net moment (3,) [m] over the grasp's resources. ``ranks``: the dimensions of the null
    spaces that lower levels run in. ``force_error``: the largest distance [N] of a contact force from its reference,
    None when no controller has one. ``projections``: those of lower levels. ``limits``: lower and upper (n,) of the
    joints that it drives [m or rad].
    """

    steps: tuple[Step, ...]
    command: int
    space: str
    force_residual: int
    moment_residual: int
    leaks: tuple[Leak, ...]
    ranks: tuple[int, ...] = ()
    projections: tuple[Projection, ...] = ()
    force_error: int | None = None
    limits: tuple[Array, Array] | None = None

    def values(self, observation: Observation) -> list[Array]:
        """The value of every step for an observation, in the order of the steps."""
        values: list[Array] = []
        for step in self.steps:
            if step.reading is not None:
                values.append(getattr(observation, step.reading))
            else:
                values.append(step.function(*[values[i] for i in step.inputs]))
        return values

    def evaluate(self, observation: Observation) -> Tick:
        """One tick: the command, the sensed residuals and the leaks."""
        return self.ticks(observation).alone(self.space)

    def ticks(self, observation: Observation) -> Ticks:
        """One tick of as many trials as the observation has leading axes for; what becomes of each is its own affair.

        A joint that the command would take beyond a limit is locked, and the command made anew by the others, until
        none is.
        """
        values = self.values(observation)
        locked = np.zeros_like(observation.joints, dtype=bool)
        while (beyond := self._beyond(observation.joints, values[self.command])).any():
            locked |= beyond
            values = self.values(_with_locked(observation, locked))
            values[self.command] = np.where(locked, 0.0, values[self.command])
        batch = observation.points.shape[:-2]

        def of_each(steps: Iterable[int]) -> Array:
            columns = [np.broadcast_to(values[step], batch) for step in steps]
            return np.stack(columns, axis=-1) if columns else np.zeros((*batch, 0))

        error = np.full(batch, np.nan) if self.force_error is None else np.broadcast_to(values[self.force_error], batch)
        return Ticks(
            displacement=values[self.command],
            force_residual=values[self.force_residual],
            moment_residual=values[self.moment_residual],
            force_error=error,
            leaks=of_each(leak.step for leak in self.leaks),
            ranks=of_each(self.ranks),
            locked=locked,
        )

    def _beyond(self, joints: Array, displacement: Array) -> Flags:
        """Which joints (..., n) a displacement takes beyond their limits."""
        if self.limits is None:
            return np.zeros(0, dtype=bool)
        lower, upper = self.limits
        after = joints + displacement
        return ((after < lower) & (displacement < 0.0)) | ((after > upper) & (displacement > 0.0))


def _with_locked(observation: Observation, locked: Flags) -> Observation:
    """An observation in which locked joints (..., n) move no contact."""
    free = np.where(locked, 0.0, 1.0)[..., None, None, :]
    return replace(
        observation, jacobian=observation.jacobian * free, angular_jacobian=observation.angular_jacobian * free
    )


@dataclass(slots=True)
class PipelineBuilder:
    """Collects steps, each once: a step that does the same with the same inputs as an earlier one is that step."""

    steps: list[Step] = field(default_factory=list)
    _known: dict[Hashable, int] = field(default_factory=dict)

    def observe(self, name: str, about: str) -> int:
        """The step that reads a field of the observation."""
        return self._add(("read", name), Step(name, about, _nothing, reading=name))

    def constant(self, label: str, about: str, value: Array) -> int:
        """The step that gives a fixed array."""
        return self._add(fingerprint(value), Step(label, about, partial(_same, value)))

    def apply(self, label: str, about: str, function: Callable[..., Array], *inputs: int) -> int:
        """The step that applies a function, or a partial of one, to the values of earlier steps."""
        return self._add((fingerprint(function), inputs), Step(label, about, function, inputs))

    def needed(self, outputs: Iterable[int]) -> tuple[tuple[Step, ...], Mapping[int, int]]:
        """The steps that some output depends on, renumbered, and the new number of each."""
        wanted: set[int] = set(outputs)
        for index in range(len(self.steps) - 1, -1, -1):
            if index in wanted:
                wanted.update(self.steps[index].inputs)
        number = {old: new for new, old in enumerate(sorted(wanted))}
        steps = [self.steps[old] for old in sorted(wanted)]
        return tuple(replace(step, inputs=tuple(number[i] for i in step.inputs)) for step in steps), number

    def _add(self, key: Hashable, step: Step) -> int:
        if key not in self._known:
            self._known[key] = len(self.steps)
            self.steps.append(step)
        return self._known[key]


def _nothing() -> Array:
    return np.zeros(0)


def _same(value: Array) -> Array:
    return value


def fingerprint(value: object) -> Hashable:
    """Equal for functions that do the same: partials are told apart by what they fix, arrays by their numbers."""
    if isinstance(value, partial):
        fixed = [fingerprint(argument) for argument in (*value.args, *value.keywords.values())]
        return (value.func, *value.keywords, *fixed)
    if isinstance(value, np.ndarray):
        return (value.shape, value.tobytes())
    assert isinstance(value, Hashable)
    return value
