"""How a trial can end."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class Outcome(enum.StrEnum):
    """The classes of outcomes; every trial bears exactly one."""

    CONVERGED = "converged"
    LOCAL_MINIMUM = "local-minimum"
    PALM_COLLISION = "palm-collision"
    CONTACT_LOST = "contact-lost"
    TOPPLED = "toppled"
    JOINT_LIMIT = "joint-limit"
    TIMEOUT = "timeout"
    DIVERGED = "diverged"
    CRASHED = "crashed"
    INFEASIBLE = "infeasible"


@dataclass(frozen=True, slots=True)
class Verdict:
    """An outcome and what brought it about, in words."""

    outcome: Outcome
    detail: str = ""
