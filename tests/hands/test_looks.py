"""What is only drawn of a hand is left out with a warning when it cannot be drawn; it never stops a run."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from graspdsl.diagnostics import Severity
from graspdsl.hands.description_files import DescriptionFileError
from graspdsl.hands.hand_files import FoundHand, hand_in
from graspdsl.places.files import SpecFolder
from graspdsl.worlds.bullet.engine import pybullet, silenced

from .models import URDF, changed, write

BALL = '<sphere radius="0.011"/>'
GEOMETRY = f"<geometry>{BALL}</geometry>"
RGBA = "0.5 0.5 0.5 1"
MATERIAL = '<material name="grey"/>'
SHAPES = {
    "no geometry": (GEOMETRY, "", "of a <visual>, found none"),
    "no shape": (BALL, "", "of a <visual>, found none"),
    "another shape": (BALL, '<cone radius="1"/>', "found <cone>"),
    "a size": (BALL, '<sphere radius="-1"/>', "the radius of <sphere> is negative: -1"),
    "no mesh": (BALL, "<mesh/>", "its <mesh> has no filename"),
    "a mesh of another kind": (BALL, '<mesh filename="a.step"/>', "a.step is no file of triangles"),
    "a mesh that is not there": (BALL, '<mesh filename="no.stl"/>', "no.stl"),
    "a mesh elsewhere": (BALL, '<mesh filename="../a.stl"/>', "leads out of the folder"),
}
COLOURS = {
    "of 255": (RGBA, "255 255 255 1", "1.0 1.0 1.0 1.0"),
    "of three": (RGBA, "0.5 0.5 0.5", None),
    "no number": (RGBA, "0.5 0.5 nan 1", None),
    "in the look": (MATERIAL, '<material name="b"><color rgba="2 0 0 1"/></material>', "1.0 0.0 0.0 1.0"),
}


def _found(folder: Path, urdf: str) -> FoundHand:
    write(folder, urdf)
    return hand_in(SpecFolder(folder), "hand.yaml")


def _draws_ball(found: FoundHand, folder: Path) -> bool:
    """Whether the engine draws the ball of the tip; of a link without looks it draws what touches, a smaller one."""
    (folder / "model.urdf").write_text(found.hand.model, encoding="utf-8")
    engine = pybullet()
    client = engine.connect(engine.DIRECT)
    try:
        with silenced():
            body = engine.loadURDF(str(folder / "model.urdf"), physicsClientId=client)
        shapes = [shape[2:4] for shape in engine.getVisualShapeData(body, physicsClientId=client)]
    finally:
        engine.disconnect(client)
    assert len(shapes) == 2  # of the finger and its tip
    return any(kind == engine.GEOM_SPHERE and sizes[0] == pytest.approx(0.011) for kind, sizes in shapes)


@pytest.mark.parametrize("name", SHAPES)
def test_a_look_that_cannot_be_drawn_is_left_out_with_a_warning(name: str, tmp_path: Path) -> None:
    old, new, said = SHAPES[name]
    found = _found(tmp_path, changed(URDF, (old, new)))
    (warning,) = found.warnings
    assert (warning.code, warning.severity) == ("undrawn", Severity.WARNING)
    assert said in warning.message
    assert "not drawn" in warning.message
    assert warning.span is not None
    assert "0.011" not in found.hand.model
    assert len(list(ElementTree.fromstring(found.hand.model).iter("collision"))) == 2
    assert not _draws_ball(found, tmp_path)


@pytest.mark.parametrize("name", COLOURS)
def test_a_look_is_drawn_with_the_nearest_colour_or_none(name: str, tmp_path: Path) -> None:
    old, new, colour = COLOURS[name]
    found = _found(tmp_path, changed(URDF, (old, new)))
    ball = ElementTree.fromstring(found.hand.model).find("link[@name='tip']/visual/material/color")
    assert found.warnings == ()
    assert (None if ball is None else ball.get("rgba")) == colour
    assert _draws_ball(found, tmp_path)


def test_each_kind_of_these_is_told_once(tmp_path: Path) -> None:
    kinds = (
        '<mesh filename="a.step"/>',
        '<mesh filename="b.igs"/>',
        '<mesh filename="no.stl"/>',
        '<mesh filename="nor.obj"/>',
        '<box size="0 1 1"/>',
        '<box size="1 1 -1"/>',
    )
    look = "<visual><geometry>{}</geometry></visual>"
    urdf = changed(URDF, ('<link name="thumb">', f'<link name="thumb">{"".join(map(look.format, kinds))}'))
    found = _found(tmp_path, urdf)
    said = [warning.message for warning in found.warnings]
    assert len(said) == 3
    assert [sum(name in message for message in said) for name in ("a.step", "no.stl", "0 1 1")] == [1, 1, 1]
    assert _draws_ball(found, tmp_path)


def test_a_mesh_that_is_also_felt_has_to_be_there(tmp_path: Path) -> None:
    """One file of both uses is one complaint, and no warning."""
    mesh = '<mesh filename="no.stl"/>'
    urdf = changed(changed(URDF, (BALL, mesh)), ('<sphere radius="0.01"/>', mesh))
    with pytest.raises(DescriptionFileError) as caught:
        _found(tmp_path, urdf)
    assert [fault.severity for fault in caught.value.diagnostics] == [Severity.ERROR]
