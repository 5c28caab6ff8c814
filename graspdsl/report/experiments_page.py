"""What the experiments say together: one page and the claims as data."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from graspdsl.report.claims import Claim
from graspdsl.report.judgements import Verdict
from graspdsl.report.summary import plain
from graspdsl.report.templating import rendered
from graspdsl.report.writing import replace

PAGE, NUMBERS = "report.html", "conformance.json"
TITLE = "The chapter's experiments"


def verdict(claims: Sequence[Claim]) -> str:
    """How many claims agree, differ, cannot be told and are no evidence, in a sentence."""
    agree, differ, untold, nothing = (sum(claim.verdict is kind for claim in claims) for kind in Verdict)
    said = f"{agree} of {len(claims)} points agree with the chapter; differ: {differ}; cannot be told: {untold}"
    return f"{said}; no evidence: {nothing}."


def write_experiments(place: Path, claims: Sequence[Claim], reports: Mapping[str, str]) -> Path:
    """Write the page and the claims into a folder; reports: where the report of each experiment is, from there.

    Returns where the page is. Raises DiagnosticError where the folder cannot be written to.
    """
    page = rendered("experiments.html", title=TITLE, verdict=verdict(claims), claims=claims, links=reports)
    data = json.dumps(plain(claims), indent=2, ensure_ascii=False) + "\n"
    replace(place, {PAGE: page, NUMBERS: data})
    return place / PAGE
