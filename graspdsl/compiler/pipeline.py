"""The pipeline: a flat list of numerical steps that turns one observation into one command."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from graspdsl.arrays import Array, Flags, packed
from graspdsl.backends import NUMPY, Backend
from graspdsl.basis import operations
from graspdsl.compiler.graph import ControllerNode
from graspdsl.worlds.protocol import Command, Observation

Values = Mapping[int, Array] | Sequence[Array]  # by the numbers of steps
LOCKED = ("jacobian", "angular_jacobian")  # what of an observation locked joints change


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

    def told_by(self, command: int) -> tuple[int, int, int, int]:
        """The steps that tell what a command changes, as :func:`~graspdsl.basis.operations.changes` takes them."""
        return self.effect, command, self.shortened, self.alone

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
class Certificate:
    """The steps of what it takes to tell what becomes of the priorities, all of them side by side, with zeros up to the
    largest width W of what one senses: ``sensed`` (..., L, W), their Jacobians ``effects`` (..., L, W, D) and
    ``changes`` (..., L, 4, W): what each level alone would change, and what the command changes besides, by causes."""

    sensed: int
    effects: int
    changes: int


@dataclass(frozen=True, slots=True)
class Pipeline:
    """A compiled controller. ``evaluate`` is pure: the same observation gives the same command.

    ``command`` is the step whose value is the displacement; ``force_residual`` and ``moment_residual`` the steps of the
    sensed net unit force (3,) and net moment (3,) [m] over the grasp's resources. ``priorities``: the levels that
    others are subject to, highest first in each chain; ``certificate``: what is told of them, None where there are
    none; the steps from number ``bare`` on serve that alone. ``force_error``: the largest distance [N] of a contact
    force from its reference, None when no controller has one. ``projections``: those of lower levels. ``limits``: lower
    and upper (n,) of the joints that it drives [m or rad]. ``backend``: what evaluates the steps of a tick. ``locked``:
    the steps to the commands and the ranks that locked joints change.
    """

    steps: tuple[Step, ...]
    command: int
    space: str
    force_residual: int
    moment_residual: int
    priorities: tuple[Priority, ...]
    certificate: Certificate | None
    bare: int
    projections: tuple[Projection, ...] = ()
    force_error: int | None = None
    limits: tuple[Array, Array] | None = None
    backend: Backend = NUMPY
    locked: tuple[int, ...] = ()
    _compiled: dict[bool, Callable[[Observation, Flags | None], Values]] = field(
        init=False, default_factory=dict, compare=False, repr=False
    )

    def values(self, observation: Observation, *, certified: bool = True) -> list[Array]:
        """The value of every step for an observation, in the order of the steps; ``certified``: also of those that
        serve the priorities alone."""
        values: list[Array] = []
        for step in self.steps if certified else self.steps[: self.bare]:
            if step.reading is not None:
                values.append(getattr(observation, step.reading))
            else:
                values.append(step.function(*[values[i] for i in step.inputs]))
        return values

    def _values_with(self, observation: Observation, locked: Flags, free: Values) -> Values:
        """The values, by their steps, of those that change when joints are locked; of the others those of a free
        hand."""
        values = dict(enumerate(free)) if isinstance(free, Sequence) else dict(free)
        for place in self.locked:
            step = self.steps[place]
            if step.reading is not None:
                values[place] = _read(observation, step.reading, locked)
            elif place in values:
                values[place] = step.function(*[values[i] for i in step.inputs])
        return values

    def evaluate(self, observation: Observation) -> Tick:
        """One tick: the command, the sensed residuals and the priorities."""
        return self.ticks(observation).alone(self.space)

    def ticks(self, observation: Observation, *, certified: bool = True) -> Ticks:
        """One tick of as many trials as the observation has leading axes for; what becomes of each is its own affair.

        A joint that the command would take beyond a limit is locked, and the command made anew by the others, until
        none is. ``certified``: whether to tell what becomes of the priorities.
        """
        batch, told = observation.points.shape[:-2], self.certificate if certified else None
        free = values = self._tick_values(observation, certified=certified)
        displacement, locked = free[self.command], np.zeros(observation.joints.shape, dtype=bool)
        changes = free[told.changes] if told else np.zeros((*batch, 0, 4, 0))
        commands = [self.command, *(one.alone for one in self.priorities if told)]
        beyond = [(step, self._beyond(observation.joints, free[step])) for step in commands]
        if any(joints.any() for _, joints in beyond):
            (displacement, locked, values), *alone = self._with_locks(observation, free, beyond, certified=certified)
            if told:
                made = (
                    operations.changes(*(free[step] for step in one.told_by(self.command)), displacement, moved)
                    for one, (moved, _, _) in zip(self.priorities, alone, strict=True)
                )
                locks = np.any([locked, *(others for _, others, _ in alone)], axis=(0, -1))
                changes = np.where(locks[..., None, None, None], operations.side_by_side(2, -1, *made), changes)

        def of_each(value: Array, *shape: int) -> Array:
            return value if value.ndim == len(batch) + len(shape) else np.broadcast_to(value, (*batch, *shape))

        sensed = free[told.sensed] if told else np.zeros((*batch, 0, 0))
        effects = free[told.effects] if told else np.zeros((*batch, 0, 0, 0))
        ranks = [of_each(values[one.rank]) for one in self.priorities]
        return Ticks(
            displacement=displacement,
            force_residual=values[self.force_residual],
            moment_residual=values[self.moment_residual],
            force_error=np.full(batch, np.nan) if self.force_error is None else of_each(values[self.force_error]),
            ranks=packed(*ranks) if ranks else np.zeros((*batch, 0)),
            locked=locked,
            sensed=sensed,
            effects=of_each(effects, *effects.shape[-3:]),
            own=changes[..., 0, :],
            parts=changes[..., 1:, :],
        )

    def _tick_values(self, observation: Observation, *, certified: bool) -> Values:
        """The values, by their steps, of all that a tick is made of."""
        if self.backend is NUMPY:
            return self.values(observation, certified=certified)
        if certified not in self._compiled:
            self._compiled[certified] = self._as_compiled(certified=certified)
        return self._compiled[certified](observation, None)

    def _as_compiled(self, *, certified: bool) -> Callable[[Observation, Flags | None], Values]:
        """The values of all that a tick is made of, as the backend compiles them."""
        told = self.certificate if certified else None
        outputs = {self.command, self.force_residual, self.moment_residual, *(one.rank for one in self.priorities)}
        outputs |= set() if self.force_error is None else {self.force_error}
        if told is not None:
            outputs |= {told.sensed, told.effects, told.changes}
            outputs |= {step for one in self.priorities for step in one.told_by(self.command)}
        steps = self.steps if certified else self.steps[: self.bare]
        evaluation = _Evaluation(steps, tuple(sorted(outputs)))
        compiled = self.backend.compiled(evaluation)

        def values(observation: Observation, locked: Flags | None) -> Values:
            read = [np.asarray(_read(observation, name, locked)) for name in evaluation.read]
            return dict(zip(evaluation.outputs, compiled(observation.points.shape[:-2], *read), strict=True))

        return values

    def _with_locks(
        self, observation: Observation, free: Values, beyond: Iterable[tuple[int, Flags]], *, certified: bool
    ) -> Iterator[tuple[Array, Flags, Values]]:
        """Of each command what of it can be carried out, the joints that it locks, and all values when these are.

        free: the values when none is; beyond: the commands, with the joints that each would then take beyond limits.
        """
        evaluated = dict[bytes, Values]()
        for command, joints in beyond:
            displacement, locked, values = free[command], np.zeros(observation.joints.shape, dtype=bool), free
            while joints.any():
                locked = locked | joints
                if (key := locked.tobytes()) not in evaluated:
                    if self.backend is NUMPY:
                        evaluated[key] = self._values_with(observation, locked, free)
                    else:
                        evaluated[key] = self._compiled[certified](observation, locked)
                values = evaluated[key]
                displacement = np.where(locked, 0.0, values[command])
                joints = self._beyond(observation.joints, displacement)
            yield displacement, locked, values

    def _beyond(self, joints: Array, displacement: Array) -> Flags:
        """Which joints (..., n) a displacement takes beyond their limits."""
        if self.limits is None:
            return np.zeros(0, dtype=bool)
        lower, upper = self.limits
        after = joints + displacement
        return ((after < lower) & (displacement < 0.0)) | ((after > upper) & (displacement > 0.0))


class _Evaluation:
    """The values of some steps as a function of what is read, the same for steps that do the same."""

    def __init__(self, steps: Sequence[Step], outputs: tuple[int, ...]) -> None:
        self.outputs = outputs
        self.read = tuple(step.reading for step in steps if step.reading is not None)
        self._steps = steps
        self._does = (outputs, *((fingerprint(step.function), step.inputs, step.reading) for step in steps))

    def __call__(self, call: Callable[..., Array], *read: Array) -> tuple[Array, ...]:
        left, values = iter(read), list[Array]()
        for step in self._steps:
            if step.reading is not None:
                values.append(next(left))
            else:
                values.append(call(step.function, *[values[i] for i in step.inputs]))
        return tuple(values[output] for output in self.outputs)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Evaluation) and self._does == other._does

    def __hash__(self) -> int:
        return hash(self._does)


def _read(observation: Observation, name: str, locked: Flags | None) -> Array:
    """A field of an observation, in which locked joints (..., n) move no contact."""
    value: Array = getattr(observation, name)
    return value if locked is None or name not in LOCKED else value * np.where(locked, 0.0, 1.0)[..., None, None, :]


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


def steps_between(steps: Sequence[Step], readings: Collection[str], outputs: Iterable[int]) -> tuple[int, ...]:
    """The steps by which some output depends on some reading, in order."""
    after, before = set[int](), set(outputs)
    for place, step in enumerate(steps):
        if step.reading in readings or not after.isdisjoint(step.inputs):
            after.add(place)
    for place in reversed(range(len(steps))):
        if place in before:
            before.update(steps[place].inputs)
    return tuple(sorted(after & before))


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
