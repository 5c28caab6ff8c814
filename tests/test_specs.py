"""Every spec that the project ships is sound and runs."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from shipped import ABSENT, HANDS, NAMES, SPECS

from graspdsl.api.programs import examined
from graspdsl.compiler.program import examine, program_of
from graspdsl.diagnostics import Severity, has_errors
from graspdsl.hands.descriptions import Hand
from graspdsl.trials.outcomes import OUTCOMES, Outcome
from graspdsl.trials.setup import trial_loop

CHAPTER = {
    "4_13_force_residual": Outcome.CONVERGED,
    "4_17_moment_residual": OUTCOMES["local-minimum"],
    "4_18_grasp": Outcome.CONVERGED,
    "4_22_hybrid": Outcome.CONVERGED,
    "4_24_slide": Outcome.CONVERGED,
    "4_26_slide_with_posture": Outcome.CONVERGED,
    "4_30_grasp_cartesian": Outcome.CONVERGED,
    "4_31_slide_to_grasp": Outcome.CONVERGED,
    "4_40_rotate": Outcome.CONVERGED,
    "4_41_rotate_orientation": Outcome.CONVERGED,
    "close": Outcome.CONVERGED,
    "cstar": Outcome.CONVERGED,
}


def test_the_chapter_is_whole() -> None:
    assert {name.removeprefix("chapter/") for name in NAMES if name.startswith("chapter/")} == {
        f"{name}.yaml" for name in CHAPTER
    }


@pytest.mark.parametrize("name", NAMES)
def test_a_spec_is_valid(name: str) -> None:
    examination = examine((SPECS / name).read_text("utf-8"), name)
    assert examination.program is not None
    assert not has_errors(examination.diagnostics)


@pytest.mark.parametrize("hand", HANDS, ids=lambda hand: hand.stem)
def test_a_hand_of_the_gallery_lacks_its_model_alone(hand: Path) -> None:
    """Where the model is not here, hand file and spec are sound but for it; where it is, ``NAMES`` has the spec."""
    known = Hand.model_validate(yaml.safe_load(hand.read_text("utf-8")))
    spec = hand.with_name(hand.name.replace("_hand", ""))
    assert {contact.onto or contact.cell for contact in known.contacts.values()} - {""}
    if spec in ABSENT:
        _, examination = examined(spec)
        assert [each.code for each in examination.diagnostics if each.severity is Severity.ERROR] == ["file-not-found"]
        assert "models/" in examination.diagnostics[0].message


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_trial_of_a_spec_runs(name: str) -> None:
    """One of full time no longer than to its end conditions; the chapter's in the engine that they name."""
    text = (SPECS / name).read_text("utf-8").replace("full_time: true", "full_time: false")
    if not name.startswith("chapter/"):
        text = text.replace("world: bullet", "world: mujoco")
    loop = trial_loop(program_of(text, name))
    record = loop.run(0, 19).record
    expected = CHAPTER.get(Path(name).stem) if name.startswith("chapter/") else None
    assert record.outcome is not Outcome.CRASHED, record.detail
    assert record.ticks > 0
    assert expected is None or record.outcome is expected, record.detail
