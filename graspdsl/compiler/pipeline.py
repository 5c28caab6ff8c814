"""The pipeline: a flat list of numerical steps that turns one observation into one command."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.basis.operations import times
from graspdsl.compiler.graph import ControllerNode
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
class Priority:
    """A level that others are subject to, with the steps that tell what these do to it.

    ``sensed``: what its sensor senses; ``effect``: its Jacobian (d, D) by what the pipeline commands; ``alone``: the
    command if the levels below it were not there, and all that follows them the same; ``shortened``: as that, but
    shortened by caps as the whole command is; ``rank``: the dimension of the null space that the levels below run in.
    """

    controller: ControllerNode
    sensed: int
    effect: int
    alone: int
    shortened: int
    rank: int

    @property
    def unit(self) -> str:
        """Of what the level senses."""
        return self.controller.potential.space.unit

    @property
    def effect_unit(self) -> str:
        """Of what its Jacobian tells: the same, but of forces what is pressed."""
        return self.controller.effector.pressed or self.unit


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

    ``ranks`` of the null spaces below the levels that others are subject to, highest first; ``disturbances``: how far
    the command takes what each of these senses from where that level alone would have taken it, by its Jacobian, of
    forces in metres of pressing; none where that was not asked for. ``locked``: (n,) joints that the command would have
    taken beyond their limits.
    """

    command: Command
    force_residual: Array
    moment_residual: Array
    force_error: float
    ranks: tuple[int, ...]
    disturbances: tuple[float, ...]
    locked: Flags


@dataclass(frozen=True, slots=True)
class Ticks:
    """What the pipeline made of many observations at once: as :class:`Tick`, with their leading axes.

    displacement: (..., n) or (..., k, 3); force_residual, moment_residual: (..., 3); force_error: (...); ranks:
    (..., L) of L priorities; locked: (..., n). What it takes to tell what becomes of the priorities, with zeros up to
    the largest width W of what one senses, and L = 0 where it was not asked for: sensed (..., L, W); effects
    (..., L, W, D) by the D coordinates of the command; own (..., L, W), what each level alone would have changed; parts
    (..., L, 3, W), what the command changes besides by the lower levels, by caps and by locked joints.
    """

    displacement: Array
    force_residual: Array
    moment_residual: Array
    force_error: Array
    ranks: Array
    locked: Flags
    sensed: Array
    effects: Array
    own: Array
    parts: Array

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
            ranks=tuple(int(rank) for rank in self.ranks),
            disturbances=tuple(np.linalg.norm(self.parts.sum(axis=-2), axis=-1).tolist()),
            locked=self.locked,
        )


@dataclass(frozen=True, slots=True)
class Pipeline:
    """A compiled controller. ``evaluate`` is pure: the same observation gives the same command.

    ``command`` is the step whose value is the displacement; ``force_residual`` and ``moment_residual`` the steps of the
    sensed net unit force (3,) and net moment (3,) [m] over the grasp's resources. ``priorities``: the levels that
    others are subject to, highest first in each chain; the steps from ``certificate`` on serve them alone.
    ``force_error``: the largest distance [N] of a contact force from its reference, None when no controller has one.
    ``projections``: those of lower levels. ``limits``: lower and upper (n,) of the joints that it drives [m or rad].
    """

    steps: tuple[Step, ...]
    command: int
    space: str
    force_residual: int
    moment_residual: int
    priorities: tuple[Priority, ...]
    certificate: int
    projections: tuple[Projection, ...] = ()
    force_error: int | None = None
    limits: tuple[Array, Array] | None = None

    def values(self, observation: Observation, *, certified: bool = True) -> list[Array]:
        """The value of every step for an observation, in the order of the steps; ``certified``: also of those that
        serve the priorities alone."""
        values: list[Array] = []
        for step in self.steps if certified else self.steps[: self.certificate]:
            if step.reading is not None:
                values.append(getattr(observation, step.reading))
            else:
                values.append(step.function(*[values[i] for i in step.inputs]))
        return values

    def evaluate(self, observation: Observation) -> Tick:
        """One tick: the command, the sensed residuals and the priorities."""
        return self.ticks(observation).alone(self.space)

    def ticks(self, observation: Observation, *, certified: bool = True) -> Ticks:
        """One tick of as many trials as the observation has leading axes for; what becomes of each is its own affair.

        A joint that the command would take beyond a limit is locked, and the command made anew by the others, until
        none is. ``certified``: whether to tell what becomes of the priorities.
        """
        evaluated: dict[bytes, list[Array]] = {}

        def carried_out(command: int) -> tuple[Array, Flags]:
            """The value of a command with its own locked joints, and which these are."""
            locked = np.zeros_like(observation.joints, dtype=bool)
            while True:
                if (key := locked.tobytes()) not in evaluated:
                    seen = _with_locked(observation, locked) if locked.any() else observation
                    evaluated[key] = self.values(seen, certified=certified)
                displacement = evaluated[key][command]
                displacement = np.where(locked, 0.0, displacement) if locked.any() else displacement
                beyond = self._beyond(observation.joints, displacement)
                if not beyond.any():
                    return displacement, locked
                locked = locked | beyond

        displacement, locked = carried_out(self.command)
        values, free = evaluated[locked.tobytes()], next(iter(evaluated.values()))
        batch = observation.points.shape[:-2]

        def of_each(steps: Iterable[int]) -> Array:
            columns = [np.broadcast_to(values[step], batch) for step in steps]
            return np.stack(columns, axis=-1) if columns else np.zeros((*batch, 0))

        def changed(priority: Priority) -> tuple[Array, Array, Array, Array]:
            """What is sensed (..., d), its Jacobian (..., d, D), and what changes it: itself and the three causes."""
            effect = np.broadcast_to(free[priority.effect], (*batch, *free[priority.effect].shape[-2:]))
            stages = (free[self.command], free[priority.shortened], free[priority.alone], displacement,
                      carried_out(priority.alone)[0])  # fmt: skip
            whole, shortened, alone, whole_locked, alone_locked = (step.reshape(*batch, -1) for step in stages)
            causes = [whole - shortened, shortened - alone, (whole_locked - whole) - (alone_locked - alone)]
            made = times(effect[..., None, :, :], np.stack([alone_locked, *causes], axis=-2))
            return free[priority.sensed].reshape(*batch, -1), effect, made[..., 0, :], made[..., 1:, :]

        error = np.full(batch, np.nan) if self.force_error is None else np.broadcast_to(values[self.force_error], batch)
        sensed, effects, own, parts = _side_by_side(batch, [changed(one) for one in self.priorities if certified])
        return Ticks(
            displacement=displacement,
            force_residual=values[self.force_residual],
            moment_residual=values[self.moment_residual],
            force_error=error,
            ranks=of_each(priority.rank for priority in self.priorities),
            locked=locked,
            sensed=sensed,
            effects=effects,
            own=own,
            parts=parts,
        )

    def _beyond(self, joints: Array, displacement: Array) -> Flags:
        """Which joints (..., n) a displacement takes beyond their limits."""
        if self.limits is None:
            return np.zeros(0, dtype=bool)
        lower, upper = self.limits
        after = joints + displacement
        return ((after < lower) & (displacement < 0.0)) | ((after > upper) & (displacement > 0.0))


def _side_by_side(batch: tuple[int, ...], found: Sequence[tuple[Array, ...]]) -> list[Array]:
    """Of each priority four arrays as one array of each, (..., L, …), with zeros where one senses less than another."""
    if not found:
        return [np.zeros((*batch, 0, *shape)) for shape in ((0,), (0, 0), (0,), (3, 0))]
    width = max(sensed.shape[-1] for sensed, *_ in found)

    def wide(values: Array, axis: int) -> Array:
        if values.shape[axis] == width:
            return values
        missing = list(values.shape)
        missing[axis] = width - values.shape[axis]
        return np.concatenate([values, np.zeros(missing)], axis=axis)

    axes = (-1, -2, -1, -1)
    return [
        np.stack([wide(values, axis) for values in arrays], axis=len(batch))
        for arrays, axis in zip(zip(*found, strict=True), axes, strict=True)
    ]


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

    def instead(self, output: int, replaced: Mapping[int, int]) -> int:
        """The step that does what an output does, were other steps in the place of those that are replaced."""
        now = dict(replaced)
        for index, step in enumerate(self.steps[: output + 1]):
            inputs = [now[place] for place in step.inputs]
            if index not in now:
                same = tuple(inputs) == step.inputs
                now[index] = index if same else self.apply(step.label, step.about, step.function, *inputs)
        return now[output]

    def needed(self, outputs: Iterable[int], besides: Iterable[int] = ()) -> tuple[tuple[Step, ...], Mapping[int, int]]:
        """The steps that some output depends on, then what those ``besides`` need more; and the new number of each."""
        first = self._below(outputs)
        order = [*sorted(first), *sorted(self._below(besides) - first)]
        number = {old: new for new, old in enumerate(order)}
        steps = [self.steps[old] for old in order]
        return tuple(replace(step, inputs=tuple(number[i] for i in step.inputs)) for step in steps), number

    def _below(self, outputs: Iterable[int]) -> set[int]:
        """The steps that some output depends on, and the outputs."""
        wanted = set(outputs)
        for index in range(len(self.steps) - 1, -1, -1):
            if index in wanted:
                wanted.update(self.steps[index].inputs)
        return wanted

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
