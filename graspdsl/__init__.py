"""Grasp controllers as formulas: run them in simulation, or compile them for a loop of one's own.

    import graspdsl as g

    program = g.load("spec.yaml")
    run = g.run(program, trials=10)
    controller = g.compile("π_s|Γ Γ (π_gx|Γ Γ)", hand="barrett")

``docs/python.md`` shows all of it. Nothing is imported before it is asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graspdsl.api.controllers import Controller, compile
    from graspdsl.api.formulas import Formula, parse
    from graspdsl.api.grasps import Residuals, ferrari_canny, force_closure, residuals
    from graspdsl.api.programs import SpecWarning, load, loads
    from graspdsl.api.runs import Run, open_run, resume, run
    from graspdsl.api.sweeps import Sweep, open_sweep, resume_sweep, sweep
    from graspdsl.api.told import Columns
    from graspdsl.api.trajectories import Trajectory
    from graspdsl.compiler.program import Program
    from graspdsl.diagnostics import Diagnostic, DiagnosticError
    from graspdsl.trials.control_loop import ControlLoop, Turn, sensed_truth
    from graspdsl.trials.setup import hand_of
    from graspdsl.trials.workers import WorkerEndedError
    from graspdsl.worlds.protocol import Command, Observation
    from graspdsl.worlds.real_hand import Reading, RealHand

    __version__: str
else:

    def __getattr__(name: str) -> object:
        """What is asked for, imported now."""
        if name == "__version__":
            from importlib.metadata import version

            return version("graspdsl")
        if name not in _HOMES:
            raise AttributeError(f"module 'graspdsl' has no attribute {name!r}")
        from importlib import import_module

        found = globals()[name] = getattr(import_module(f"graspdsl.{_HOMES[name]}"), name)
        return found


__all__ = [
    "Columns",
    "Command",
    "ControlLoop",
    "Controller",
    "Diagnostic",
    "DiagnosticError",
    "Formula",
    "Observation",
    "Program",
    "Reading",
    "RealHand",
    "Residuals",
    "Run",
    "SpecWarning",
    "Sweep",
    "Trajectory",
    "Turn",
    "WorkerEndedError",
    "compile",
    "ferrari_canny",
    "force_closure",
    "hand_of",
    "load",
    "loads",
    "open_run",
    "open_sweep",
    "parse",
    "residuals",
    "resume",
    "resume_sweep",
    "run",
    "sensed_truth",
    "sweep",
]

# By name, the module that a thing is from.
_HOMES = {
    "Columns": "api.told",
    "Command": "worlds.protocol",
    "ControlLoop": "trials.control_loop",
    "Controller": "api.controllers",
    "Diagnostic": "diagnostics",
    "DiagnosticError": "diagnostics",
    "Formula": "api.formulas",
    "Observation": "worlds.protocol",
    "Program": "compiler.program",
    "Reading": "worlds.real_hand",
    "RealHand": "worlds.real_hand",
    "Residuals": "api.grasps",
    "Run": "api.runs",
    "SpecWarning": "api.programs",
    "Sweep": "api.sweeps",
    "Trajectory": "api.trajectories",
    "Turn": "trials.control_loop",
    "WorkerEndedError": "trials.workers",
    "compile": "api.controllers",
    "ferrari_canny": "api.grasps",
    "force_closure": "api.grasps",
    "hand_of": "trials.setup",
    "load": "api.programs",
    "loads": "api.programs",
    "open_run": "api.runs",
    "open_sweep": "api.sweeps",
    "parse": "api.formulas",
    "residuals": "api.grasps",
    "resume": "api.runs",
    "resume_sweep": "api.sweeps",
    "run": "api.runs",
    "sensed_truth": "trials.control_loop",
    "sweep": "api.sweeps",
}


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__", *(name for name in globals() if name.startswith("__"))})
