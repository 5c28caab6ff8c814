"""The object of a scene: of the catalogue, described in the spec, or read from a user's files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path, PurePath

import numpy as np

from graspdsl.diagnostics import Diagnostic
from graspdsl.objects.mesh_files import mesh_of_file
from graspdsl.objects.shapes import Body, catalogue, shape_from
from graspdsl.objects.urdf_files import object_of_urdf
from graspdsl.places.files import SpecFolder
from graspdsl.spec.scene import InlineObject, Mesh

DEFAULT_MASS = 0.5  # kg

Warn = Callable[[Diagnostic], None]


def body_of(choice: str | InlineObject, folder: Path = Path()) -> Body:
    """The object that a scene names or describes; its files are in the folder of the spec.

    Raises DiagnosticError when a file cannot be read or holds no solid.
    """
    return body_in(SpecFolder(folder), choice, lambda _: None)


def body_in(folder: SpecFolder, choice: str | InlineObject, warn: Warn) -> Body:
    """The object that a scene names or describes; what is odd about its files goes to ``warn``."""
    if isinstance(choice, str):
        return catalogue()[choice]
    if choice.mesh is not None:
        return _of_mesh(folder, choice, choice.mesh, warn)
    if choice.urdf is not None:
        found = object_of_urdf(choice.urdf, folder, warn)
        mass = choice.mass or found.mass or DEFAULT_MASS
        return Body(choice.name or PurePath(choice.urdf).stem, found.shape, mass, digest=folder.digest)
    if choice.shape is None:
        known = catalogue()[choice.like or ""]
        return replace(known, name=choice.name or known.name, mass=choice.mass or known.mass)
    kind, fields = choice.shape
    return Body(choice.name or kind, shape_from({kind: fields}), choice.mass or DEFAULT_MASS)


def _of_mesh(folder: SpecFolder, choice: InlineObject, mesh: Mesh, warn: Warn) -> Body:
    content = folder.read(mesh.file)
    shape = mesh_of_file(mesh.file, content, np.full(3, mesh.scale), mesh.convex, warn)
    mass = choice.mass or (DEFAULT_MASS if mesh.density is None else mesh.density * shape.solid.volume)
    return Body(choice.name or PurePath(mesh.file).stem, shape, mass, digest=folder.digest)
