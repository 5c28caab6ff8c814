"""Names that a hand and the mount it is on both have; those of other mounts are free."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from graspdsl.cli.app import app
from graspdsl.compiler.program import examine

from .models import HAND, SPEC, URDF, changed, write

LINK = ('<link name="thumb">', '<link name="forearm">')
CHILD = ('<child link="thumb"/>', '<child link="forearm"/>')
CONTACT = ("{link: thumb,", "{link: forearm,")
TAKEN = {
    "link": ((LINK, CHILD), (CONTACT,), "the link forearm of the hand has the name of a link of the mount wam"),
    "joint": (
        (('<joint name="bend"', '<joint name="elbow"'),),
        (
            ("bend: {weight: 10.0, closes: 1}\n  thumb", "elbow: {weight: 10.0, closes: 1}\n  thumb"),
            ("finger: [bend]", "finger: [elbow]"),
            ("[bend, thumb-bend]", "[elbow, thumb-bend]"),
            ("{bend: 0.1}", "{elbow: 0.1}"),
        ),
        "the joint elbow of the hand has the name of a joint of the mount wam",
    ),
    "joint set": ((), (("  both:", "  elbow:"),), "the joint set elbow of the hand has the name of a joint or a joint"),
}


def _on(mount: str) -> str:
    return changed(SPEC, ("hand: hand.yaml,", f"hand: hand.yaml, mount: {mount},"))


@pytest.mark.parametrize("what", TAKEN)
def test_names_are_taken_by_the_mount_that_is_used_and_by_no_other(what: str, tmp_path: Path) -> None:
    models, files, said = TAKEN[what]
    urdf, hand = URDF, HAND
    for change in models:
        urdf = changed(urdf, change)
    for change in files:
        hand = changed(hand, change)
    write(tmp_path, urdf, hand)
    assert CliRunner().invoke(app, ["validate", str(tmp_path / "hand.yaml")]).exit_code == 0
    assert examine(_on("gantry"), "spec.yaml", (), tmp_path).diagnostics == ()
    (fault,) = examine(_on("wam"), "spec.yaml", (), tmp_path).diagnostics
    assert fault.code == "name-taken"
    assert fault.message.startswith(f"hand.yaml: {said}")
    assert fault.span is not None
    assert (fault.span.line, fault.span.column) == (3, 30)  # where the spec names the hand
