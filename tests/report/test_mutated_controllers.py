"""Claims held against a real run of a controller that cannot do what the chapter says."""

from __future__ import annotations

from pathlib import Path

import pytest
from stored_runs import stored_run

from graspdsl.report.claims import claims_of
from graspdsl.report.evidence import evidence_of
from graspdsl.report.judgements import Verdict

SPECS = Path(__file__).parents[2] / "specs" / "experiments"


@pytest.mark.slow
def test_contacts_that_do_not_slide_differ(tmp_path: Path) -> None:
    """In all that can be told of so few trials: grasps stay where the hand closed, and never converge."""
    settings = (
        "scene.world=mujoco",
        "evaluate=[]",
        "scene.mount=gantry",
        "trials.count=8",
        "trials.seed=3",
        "program.1.limit=1.0",
    )
    folder = stored_run(tmp_path / "run", SPECS / "1_towel_roll_two_contacts.yaml", *settings, "control.step=1e-9")
    found = {claim.says: claim.verdict for claim in claims_of(evidence_of(folder))}
    assert Verdict.AGREES not in {verdict for says, verdict in found.items() if "outside" not in says}, found
    differs = {says for says, verdict in found.items() if verdict is Verdict.DIFFERS}
    assert differs >= {
        "The controller funnels a range of starts to π/2.",
        "Residuals converge in about 1000 iterations at 50 Hz.",
    }
