"""Overlaps of parts against closed forms, and what is said of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from graspdsl.diagnostics import Diagnostic, Severity
from graspdsl.models.mesh_files import triangles
from graspdsl.objects.box import Box
from graspdsl.objects.compound import Placed
from graspdsl.objects.cylinder import Cylinder
from graspdsl.objects.mesh_files import mesh_of_triangles
from graspdsl.objects.model_files import object_of_urdf
from graspdsl.objects.overlaps import overlaps
from graspdsl.objects.sphere import Sphere
from graspdsl.objects.triangles import TriangleMesh
from graspdsl.places.files import SpecFolder

from .parts import URDF, cylinder, ring, without, write

CLOSE = 0.01  # of the smaller part


def _mesh(folder: Path, mesh: trimesh.Trimesh) -> TriangleMesh:
    content = write(mesh, folder / "part.stl").read_bytes()
    return mesh_of_triangles("part.stl", *triangles("part.stl", content), None, lambda _: None)


def _lens(radius: float, away: float) -> float:
    """The share of a ball that an equal ball covers, ``away`` [m] from centre to centre."""
    return (2 * radius - away) ** 2 * (away + 4 * radius) / (16 * radius**3)


def _box(*size: float) -> Box:
    return Box.model_construct(size=size)  # larger than a spec can have it


def _ball(diameter: float) -> Sphere:
    return Sphere.model_construct(diameter=diameter)


def _rod(diameter: float, height: float) -> Cylinder:
    return Cylinder.model_construct(diameter=diameter, height=height)


TURNED = (0.3, -0.7, 1.1)
PAIRS = {
    "boxes": (Placed(_box(1, 1, 1), (0, 0, 0)), Placed(_box(2, 2, 2), (1.2, 0, 0)), 0.3),
    "one in the other": (
        Placed(_box(4, 4, 4), (0, 0, 0), TURNED),
        Placed(_ball(1.0), (0.2, 0, 0)),
        1.0,
    ),
    "balls": (Placed(_ball(2.0), (0, 0, 0)), Placed(_ball(2.0), (0.6, 0.8, 0)), _lens(1.0, 1.0)),
    "crossed cylinders": (  # Steinmetz's solid, 16/3 r³
        Placed(_rod(2.0, 4.0), (0, 0, 0)),
        Placed(_rod(2.0, 4.0), (0, 0, 0), (np.pi / 2, 0, 0)),
        16 / 3 / (np.pi * 4.0),
    ),
    "a turned rod in a box": (  # of length 10, from the centre to a face: at 45° √2 of 5
        Placed(_box(2, 4, 2), (0, 0, 0)),
        Placed(_rod(0.01, 10.0), (5 / np.sqrt(2), 0, 5 / np.sqrt(2)), (0, np.pi / 4, 0)),
        np.sqrt(2) / 10,
    ),
}


@pytest.mark.parametrize(("one", "other", "share"), PAIRS.values(), ids=PAIRS)
def test_the_share_of_the_smaller_part(one: Placed, other: Placed, share: float) -> None:
    for pair in ([one, other], [other, one]):
        ((first, second, found),) = overlaps(pair)
        assert (first, second) == (0, 1)
        assert found == pytest.approx(share, abs=CLOSE)


@pytest.mark.parametrize("gap", [0.0, -0.01, 0.01])
def test_parts_that_touch_do_not_overlap(gap: float) -> None:
    boxes = [
        Placed(_box(1, 1, 1), (0, 0, 0), TURNED),
        Placed(_box(1, 1, 1), (0, 0, 0), TURNED),
    ]
    aside = boxes[0].rotation @ [1.0 + gap, 0.0, 0.0]
    x, y, z = aside.tolist()
    assert list(overlaps([boxes[0], Placed(boxes[1].part, (x, y, z), TURNED)])) == []


def test_a_thing_in_the_hole_of_a_ring_is_not_in_the_ring(tmp_path: Path) -> None:
    """The ring from 3 to 5 cm; its outline is a polygon of 24 sides."""
    around = Placed(_mesh(tmp_path, ring()), (0.1, 0.2, 0.3), TURNED)
    for across, expected in ((0.056, None), (0.08, 1.0 - (0.03 / 0.04) ** 2)):
        found = overlaps([around, Placed(_rod(across, 0.05), (0.1, 0.2, 0.3), TURNED)])
        assert [overlap.share for overlap in found] == ([] if expected is None else [pytest.approx(expected, abs=0.02)])


def test_a_mesh_with_holes_holds_what_its_mass_is_counted_for(tmp_path: Path) -> None:
    inside = Placed(_ball(0.02), (1.0, 2.0, 3.0))
    for mesh in (cylinder(), without(cylinder(), 9)):
        ((_, _, share),) = overlaps([Placed(_mesh(tmp_path, mesh), (0.0, 0.0, 0.0)), inside])
        assert share == pytest.approx(1.0, abs=CLOSE)


TWO = """<robot name="t"><link name="a">{inertial}
<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>
<collision><origin xyz="{x} 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision>
</link></robot>"""
STATED = '<inertial><mass value="0.3"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'


def _said(folder: Path, text: str) -> list[Diagnostic]:
    (folder / "thing.urdf").write_text(text)
    said: list[Diagnostic] = []
    object_of_urdf("thing.urdf", SpecFolder(folder), said.append)
    return said


@pytest.mark.parametrize("inertial", ["", STATED])
def test_a_urdf_with_overlapping_parts_is_warned_of(inertial: str, tmp_path: Path) -> None:
    """Its inertia is worked out of its parts, whatever it says itself."""
    (found,) = _said(tmp_path, TWO.format(inertial=inertial, x=0.06))
    assert (found.code, found.severity) == ("overlapping-parts", Severity.WARNING)
    assert "thing.urdf:2:1 and thing.urdf:3:1 share about 40% of the smaller" in found.message
    assert _said(tmp_path, TWO.format(inertial=inertial, x=0.1)) == []


def test_parts_that_stand_on_each_other_are_fine(tmp_path: Path) -> None:
    write(trimesh.creation.box((0.1, 0.1, 0.1)), tmp_path / "shade.stl")
    assert _said(tmp_path, URDF.format(mesh="shade.stl")) == []
