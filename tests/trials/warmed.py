"""Imported by a process that others are forked from: it has run a trial, so that these need not import anything."""

from __future__ import annotations

from compiler.specs import floating

from graspdsl.compiler.program import program_of
from graspdsl.trials.setup import trial_loop

trial_loop(program_of(floating(), "spec.yaml")).run(0, 1)
