"""How a trial can end."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class Outcome(enum.StrEnum):
    """The classes of outcomes; every trial bears exactly one."""

    CONVERGED = "converged"
    LOCAL_MINIMUM = "local-minimum"
    PALM_COLLISION = "palm-collision"
    LINK_COLLISION = "link-collision"
    TABLE_CONTACT = "table-contact"
    CONTACT_LOST = "contact-lost"
    TOPPLED = "toppled"
    DRAGGED = "dragged"
    JOINT_LIMIT = "joint-limit"
    TIMEOUT = "timeout"
    DIVERGED = "diverged"
    INFEASIBLE_START = "infeasible-start"
    CRASHED = "crashed"


@dataclass(frozen=True, slots=True)
class Verdict:
    """An outcome and what brought it about, in words."""

    outcome: Outcome
    detail: str = ""
