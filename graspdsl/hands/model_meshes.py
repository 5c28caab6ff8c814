"""The mesh files of a robot's model: where they are, and which of them the engine cannot take."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from graspdsl.arrays import Array
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.hands.mesh_check import mesh_corners
from graspdsl.hands.robot_model import RobotModel
from graspdsl.hands.urdf_check import undrawn
from graspdsl.places.files import SpecFolder
from graspdsl.places.mesh_places import MeshPlaces


class ModelMeshes(NamedTuple):
    """Meshes that the engine can take, by what the model calls them: the corners (c, 3) of those that collide, in the
    units of their files, and the places of all; complaints about the others, warnings of those that are only drawn."""

    corners: Mapping[str, Array]
    places: Mapping[str, str]
    complaints: tuple[Diagnostic, ...]


def meshes_of(files: SpecFolder, file: str, model: RobotModel) -> ModelMeshes:
    """The meshes that a model in a file names, as they lie beside it."""
    known = MeshPlaces(files, file)
    corners, places = dict[str, Array](), dict[str, str]()
    faulty, doubtful = list[Diagnostic](), dict[str, Diagnostic]()
    for mesh in (*model.meshes, *model.drawn):
        try:
            name = known.name(mesh)
            corners[mesh] = mesh_corners(mesh, files.read(name))
            places[mesh] = str(files.place(name).resolve())
        except DiagnosticError as error:
            [fault, *_] = error.diagnostics
            if mesh in model.meshes:
                faulty.append(fault)
            else:  # one warning for each kind of fault
                doubtful.setdefault(fault.code, undrawn(fault, "this mesh"))
    colliding = {mesh: found for mesh, found in corners.items() if mesh in model.meshes}
    return ModelMeshes(colliding, places, (*faulty, *doubtful.values()))
