"""Can the object of a scene be had: its shape be made, its files be read."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath
from pathlib import PurePosixPath

from graspdsl.compiler.complaints import Complaints
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.objects.bodies import body_in
from graspdsl.objects.floating_surface import surface_of
from graspdsl.objects.mesh_files import SUFFIXES
from graspdsl.objects.shapes import Body, Cylinder, catalogue, shape_from
from graspdsl.places.document import Document, Path
from graspdsl.places.files import NamedFile, SpecFolder
from graspdsl.places.wording import shortened
from graspdsl.spec.models import Spec
from graspdsl.spec.scene import InlineObject
from graspdsl.worlds.kinds import WORLDS


def file_hint(name: str, on_command_line: bool = False) -> str | None:
    """How the file that an object's name looks like is given as an object; None for any other name."""
    suffix, known = PurePosixPath(name).suffix.lower(), (".urdf", *SUFFIXES)
    if suffix not in known:
        return f"the file of an object is one of {', '.join(known)}" if suffix or "/" in name else None
    file = f"{{urdf: {shortened(name)}}}" if suffix == ".urdf" else f"{{mesh: {{file: {shortened(name)}}}}}"
    written = f"--set 'scene.object={file}'" if on_command_line else f"object: {file}"
    return f"for a file write {written}"


def found_object(
    spec: Spec, document: Document, complaints: Complaints, folder: FilePath
) -> tuple[Body, tuple[NamedFile, ...]] | None:
    """The object of a spec in a folder, and the files that it was read from; None, with complaints, without one."""
    thing = spec.scene.object
    if isinstance(thing, str):
        return (catalogue()[thing], ()) if thing in catalogue() else None
    if thing.like is not None and thing.like not in catalogue():
        return None
    from_file = thing.mesh is not None or thing.urdf is not None
    if from_file and WORLDS[spec.scene.world].floats:
        return None  # contacts cannot float on it, as has been said
    path: Path = ("scene", "object", "mesh", "file") if thing.mesh is not None else ("scene", "object", "urdf")
    complaints.about(path)
    span = document.span(path) if from_file else None

    def warn(diagnostic: Diagnostic) -> None:
        complaints.add(replace(diagnostic, span=span))

    try:
        if not from_file and not _possible(spec, thing, document, complaints):
            return None
        files = SpecFolder(folder)
        return body_in(files, thing, warn), tuple(files.files)
    except DiagnosticError as error:
        complaints.add(*(replace(diagnostic, span=span) for diagnostic in error.diagnostics))
        return None


def _possible(spec: Spec, thing: InlineObject, document: Document, complaints: Complaints) -> bool:
    """Whether the sizes of a shape go together; the edge of a cylinder is of floating contacts only."""
    if thing.shape is None or thing.box is not None:
        return True
    kind, fields = thing.shape
    shape = shape_from({kind: fields})
    if isinstance(shape, Cylinder) and not WORLDS[spec.scene.world].floats:
        return True
    try:
        surface_of(shape)
    except ValueError as error:
        path: Path = ("scene", "object", kind)
        complaints.about(path)
        message = f"there is no such {kind}: {error}"
        complaints.error("impossible-shape", message, document.span(path), "make its sizes and roundings fit together")
        return False
    return True
