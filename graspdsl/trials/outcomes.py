"""How trials end."""

from __future__ import annotations

from dataclasses import dataclass

from graspdsl.spec.monitors import OUTCOMES
from graspdsl.spec.outcomes import Outcome

__all__ = ["OUTCOMES", "Ending", "Outcome"]


@dataclass(frozen=True, slots=True)
class Ending:
    """An outcome and what brought it about, in words."""

    outcome: Outcome
    detail: str = ""
