"""The contract of potentials."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.effectors import EFFECTORS
from graspdsl.basis.potentials import POTENTIALS, Potential
from graspdsl.basis.sensors import SENSORS, Sensor
from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler.program import Program, program_of_expression
from graspdsl.contracts.differences import central_differences
from graspdsl.contracts.drawing import drawn, generator, sensed_by, sets_of
from graspdsl.contracts.entries import misplaced, misspelt, not_one_by_one, not_pure, undocumented
from graspdsl.contracts.rule import Breach, contract
from graspdsl.contracts.scene import CONTACTS, JOINTS, WITH_GRAVITY, faulty_ticks, uneven_ticks
from graspdsl.declared import misdeclared
from graspdsl.diagnostics import DiagnosticError, known_names_hint, listed
from graspdsl.notation.names import canonical
from graspdsl.spec.program import Control, Until

BATCH = (2, 3)
SIZES = (0.01, 0.1, 1.0)  # of errors, in the units of their space
ALLOWED = 1e-5  # of a gradient
CONDITIONS = sorted(set(Until.model_fields) - {"contact", "hold"})


def declared(potential: Potential) -> Iterator[Breach]:
    """What a potential says of itself is there, and of the right type."""
    yield from misdeclared(potential, Potential)


def symbol(potential: Potential) -> Iterator[Breach]:
    """A potential is called φ_…, in every spelling."""
    yield from misspelt(potential, "φ")


def table(potential: Potential) -> Iterator[Breach]:
    """A potential is found by its own symbol."""
    yield from misplaced(potential, POTENTIALS)


def docstring(potential: Potential) -> Iterator[Breach]:
    """A docstring tells symbol, source and unit."""
    yield from undocumented(potential)


def value(potential: Potential) -> Iterator[Breach]:
    """φ is one number, zero where the error is zero, nowhere below that, and above it where the error is large."""
    for errors in _errors(potential):
        found = np.asarray(potential.value(errors.copy()))
        if found.shape != errors.shape[:-1]:
            yield f"value gives {found.shape} for errors {errors.shape}", "give (...) for (..., d)"
        elif not (np.isfinite(found).all() and (found >= 0.0).all()):
            yield f"its value is {found.min():.3g} at some error", "controllers descend: zero is the end"
        elif np.abs(errors).max() > SIZES[-1] and not (found > 0.0).all():
            yield "its value is zero at a large error", "let it grow with the error, from some error on"
        elif not np.all(np.abs(potential.value(0.0 * errors)) == 0.0):
            yield f"its value at no error is {potential.value(0.0 * errors[0, 0])}", "let it be zero there"
        else:
            continue
        return


def gradient(potential: Potential) -> Iterator[Breach]:
    """The gradient is that of the value, (..., d), against central differences."""
    for errors in _errors(potential):
        for error in errors.reshape(-1, errors.shape[-1]):
            slope = np.asarray(potential.gradient(error.copy()))
            if slope.shape != error.shape:
                yield f"gradient gives {slope.shape} for an error {error.shape}", "give (..., d) for (..., d)"
                return
            differences = central_differences(potential.value, error)
            if not np.abs(slope - differences).max() <= ALLOWED * np.abs(differences).max():
                of, found, told = (_numbers(vector) for vector in (error, slope, differences))
                yield f"its gradient at {of} is {found}; differences of its value give {told}", "give dφ/de"
                return


def batches(potential: Potential) -> Iterator[Breach]:
    """Errors of many trials at once are taken as one by one."""
    for errors in _errors(potential):
        for function in (potential.value, potential.gradient):
            each = [np.asarray(function(errors[place].copy())) for place in np.ndindex(BATCH)]
            breaches = list(not_one_by_one(np.asarray(function(errors.copy())), each))
            yield from breaches
            if breaches:
                return


def pure(potential: Potential) -> Iterator[Breach]:
    """Value and gradient leave the error as it is, and keep nothing."""
    errors = next(_errors(potential))
    for function in (potential.value, potential.gradient):
        yield from not_pure(function, errors)


def transforms(potential: Potential) -> Iterator[Breach]:
    """The transforms that a potential names are there, of its space, and go together."""
    for names, what in ((potential.sensors, "sensor"), (potential.effectors, "effector")):
        if not names:
            yield f"it names no {what} transform", f"name the {what} transforms that it is joined with"
    for name in (*potential.sensors, *potential.references):
        if name not in SENSORS:
            yield f"there is no sensor transform {name}", known_names_hint(name, SENSORS, "sensor transforms")
    for name in potential.effectors:
        if name not in EFFECTORS:
            yield f"there is no effector transform {name}", known_names_hint(name, EFFECTORS, "effector transforms")
    for sensor in _sensors(potential):
        if sensor.space != potential.space:
            hint = f"sense {potential.space.about}"
            yield f"it works on {potential.space.about}; {sensor.symbol} senses {sensor.space.about}", hint
    all_of_them = [SENSORS[name] for name in (*potential.sensors, *potential.references) if name in SENSORS]
    for kind, said in (("per_contact", "a row for each contact"), ("over_joints", "joints")):
        if len({getattr(sensor, kind) for sensor in all_of_them}) > 1:
            yes = listed(sensor.symbol for sensor in all_of_them if getattr(sensor, kind))
            yield f"of its sensor transforms only {yes} give {said}", "let all be alike"


def conditions(potential: Potential) -> Iterator[Breach]:
    """What a potential lowers is what a phase can wait for."""
    for name in potential.lowers:
        if name not in CONDITIONS:
            yield f"it lowers {name!r}, which no phase waits for", f"name {listed(CONDITIONS, 'or')}, or nothing"


def gain(potential: Potential) -> Iterator[Breach]:
    """The gain of a law is a control setting, and the law says what a gain of zero leaves undone."""
    law = potential.law
    if law.gain and law.gain not in Control.model_fields:
        yield f"the gain of its law is {law.gain!r}", known_names_hint(law.gain, Control.model_fields, "settings")
    elif law.gain and not law.without:
        yield f"its law does not say what {law.gain} 0 leaves undone", "say it in 'without', as 'moves no contact'"


def normals(potential: Potential) -> Iterator[Breach]:
    """The potentials that its gradient is at right angles to are there."""
    for name in potential.normal_to:
        if name not in POTENTIALS:
            yield f"there is no potential {name}", known_names_hint(name, POTENTIALS, "potentials")


def references(potential: Potential) -> Iterator[Breach]:
    """A residual strives for zero; defaults, displacements and caps are of references."""
    if potential.is_residual and potential.references:
        yield "a residual strives for zero and takes no reference", "leave references out, or is_residual"
    if potential.references:
        return
    for name in ("has_default_reference", "displaced_by", "is_capped"):
        if getattr(potential, name):
            yield f"{name} is of a reference, and it takes none", f"leave {name} out, or name references"


def difference(potential: Potential) -> Iterator[Breach]:
    """The displacement between two places, made at the one, leads to the other; none leads nowhere; in batches too."""
    between, displaced = potential.difference.between, potential.difference.displaced
    end, start = generator().normal(scale=0.5, size=(2, *BATCH, 4, 3))
    way = np.asarray(between(end, start))
    if way.shape != start.shape:
        yield f"the difference of places {start.shape} is {way.shape}", "give (..., 3) for (..., 3)"
    elif not np.allclose(displaced(way, start), end, rtol=0.0, atol=1e-10):
        yield "the displacement between two places does not lead from one to the other", "let displaced undo between"
    elif not np.allclose(displaced(np.zeros_like(start), start), start, rtol=0.0, atol=1e-10):
        yield "a displacement of nothing leads elsewhere", "let displaced(0, start) be start"
    else:
        yield from not_one_by_one(way, (np.asarray(between(end[place], start[place])) for place in np.ndindex(BATCH)))


def formula(potential: Potential) -> Iterator[Breach]:
    """Each formula with the potential and its transforms is checked without an error."""
    for text in _formulas(potential):
        try:
            program_of_expression(text)
        except DiagnosticError as error:
            yield from ((f"{text}: {fault.message}", fault.hint or "") for fault in error.diagnostics)


def tick(potential: Potential) -> Iterator[Breach]:
    """A tick of each such formula commands a displacement, finite and of the right shape."""
    for text, program in _programs(potential):
        for (pipeline,) in program.pipelines():
            yield from faulty_ticks(pipeline, program.robot, text)


def side_by_side(potential: Potential) -> Iterator[Breach]:
    """Of trials side by side, each is commanded what it is by itself."""
    for text, program in _programs(potential):
        for (pipeline,) in program.pipelines():
            yield from uneven_ticks(pipeline, program.robot, text)


RULES = contract(
    declared,
    symbol,
    table,
    docstring,
    value,
    gradient,
    batches,
    pure,
    transforms,
    conditions,
    gain,
    normals,
    references,
    difference,
    formula,
    tick,
    side_by_side,
    wording=(docstring,),
)


def _sensors(potential: Potential) -> list[Sensor]:
    return [SENSORS[name] for name in potential.sensors if name in SENSORS]


def _errors(potential: Potential) -> Iterator[Array]:
    """Errors (2, 3, d) of its task space, small and large; of six numbers where nothing is known of that."""
    sizes = {
        sensed_by(sensor, resources, next(drawn(resources))).size
        for sensor in _sensors(potential)
        for resources in sets_of(sensor).values()
    }
    random = generator()
    for count in sorted(sizes or {6}):
        for size in SIZES:
            yield random.normal(scale=size, size=(*BATCH, count))


def _formulas(potential: Potential) -> Iterator[str]:
    """φ|τ(Γ) σ(Γ) (reference) over contacts or joints, for all of its transforms and references, where its symbol is
    read as it is written."""
    if POTENTIALS.get(canonical(potential.symbol)) is not potential:
        return
    for sensor in _sensors(potential):
        for effector in [EFFECTORS[name] for name in potential.effectors if name in EFFECTORS]:
            moved = sensed = JOINTS if sensor.over_joints else CONTACTS
            if effector.gradient_space is GradientSpace.ROTATION and sensor.feels_gravity:
                sensed = WITH_GRAVITY
            head = f"{potential.symbol}|{effector.symbol}({moved}) {sensor.symbol}({sensed})"
            yield from [f"{head} (0.5 {name}({moved}))" for name in potential.references if name in SENSORS]
            if potential.has_default_reference or not potential.references:
                yield head


def _programs(potential: Potential) -> Iterator[tuple[str, Program]]:
    for text in _formulas(potential):
        try:
            yield text, program_of_expression(text)
        except DiagnosticError:
            continue  # for the rule of formulas


def _numbers(vector: Array) -> str:
    return f"({', '.join(f'{number:.3g}' for number in vector)})"
