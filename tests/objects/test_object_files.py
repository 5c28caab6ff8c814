"""Files of objects of elsewhere."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from graspdsl.diagnostics import DiagnosticError
from graspdsl.objects.object_files import DEFAULT_MASS, objects_in

STRANGER = Path(__file__).parents[1] / "plugin" / "src" / "graspdsl_stranger" / "objects"
WIDTH, HEIGHT = 0.06, 0.14  # m, of the hexagonal bar


def test_shapes_and_meshes_are_read_by_their_names() -> None:
    found = objects_in(STRANGER)
    assert [*found] == [body.name for body in found.values()] == ["juice-carton", "hexagonal-bar"]
    bar = found["hexagonal-bar"]
    assert bar.shape.solid.volume == pytest.approx(3**0.5 / 2 * WIDTH**2 * HEIGHT, rel=1e-4)
    assert bar.digest
    assert (bar.mass, bar.about) == (0.4, "A hexagonal bar, standing.")


def test_a_urdf_lies_beside_the_file(tmp_path: Path) -> None:
    collision = '<collision><geometry><box size="0.05 0.05 0.1"/></geometry></collision>'
    (tmp_path / "block.urdf").write_text(f'<robot name="block"><link name="a">{collision}</link></robot>', "utf-8")
    (tmp_path / "things.yaml").write_text("block: {urdf: block.urdf}\ncopy: {sphere: {diameter: 0.1}}\n", "utf-8")
    found = objects_in(tmp_path / "things.yaml")
    assert found["block"].shape.extent == pytest.approx((0.05, 0.05, 0.1))
    assert found["copy"].mass == DEFAULT_MASS


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: {spere: {diameter: 0.1}}", "things.yaml:1:5: 'a' has no key 'spere'"),
        ("a: {sphere: {diameter: 0.1}, mass: 0}", "things.yaml:1:36: expected a number above 0"),
        ("a: {about: a thing}", "things.yaml:1:4: an object has exactly one shape"),
        ("a: {mesh: {file: no.stl}}", "things.yaml: there is no file no.stl"),
        ("a: {mesh: {file: ../b.stl}}", "things.yaml: ../b.stl leads out of the folder"),
        (
            "a: {bottle: {diameter: 0.08, height: 0.22, neck_diameter: 0.1, body_height: 0.13, neck_height: 0.04, "
            "shoulder: 0.015, edge: 0.008}}",
            "things.yaml:1:4: there is no such bottle: the neck is as wide as the body or wider",
        ),
        ("a: [", "things.yaml:1:"),
    ],
)
def test_a_fault_is_told_with_its_place(text: str, said: str, tmp_path: Path) -> None:
    shutil.copytree(STRANGER, tmp_path / "objects")
    (tmp_path / "objects" / "things.yaml").write_text(text, "utf-8")
    with pytest.raises(DiagnosticError) as refused:
        objects_in(tmp_path / "objects")
    assert refused.value.diagnostics[0].message.startswith(said), refused.value.diagnostics
