"""Whether what evaluates the pipelines of a program is there, and can evaluate each of their steps."""

from __future__ import annotations

from collections.abc import Iterable

from graspdsl.backends import NUMPY, Backend
from graspdsl.compiler.general_position import in_general_position
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.diagnostics import Diagnostic, listed
from graspdsl.hands.descriptions import Robot


def unfit(backend: Backend, pipelines: Iterable[Iterable[Pipeline]], robot: Robot) -> Diagnostic | None:
    """What there is to say of a backend that is not installed, or for which a step is not written; else None."""
    if backend is NUMPY:
        return None
    if backend.missing:
        message = f"the {backend.name} backend needs {listed(backend.missing)}, which this Python has not"
        ways = dict.fromkeys(backend.libraries[name] for name in backend.missing)
        return Diagnostic("engine-missing", message, hint=f"{'; '.join(ways)}; or leave backend out")
    observation = in_general_position(robot)
    for pipeline in (made for stages in pipelines for made in stages):
        values = pipeline.values(observation)
        for step in pipeline.steps:
            arrays = [values[place] for place in step.inputs]
            if step.reading is None and (reason := backend.refusal(step.function, *arrays)):
                message = f"{step.label}, {step.about}, cannot be compiled by {backend.name}: {reason}"
                hint = "leave backend out, or write it with the functions of graspdsl.arrays.namespace(array)"
                return Diagnostic("numpy-alone", message, hint=hint)
    return None
