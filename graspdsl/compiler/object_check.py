"""The object of a scene: of the catalogue, described in the spec, or read from a user's files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath
from pathlib import PurePosixPath

from graspdsl.compiler.complaints import Complaints
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.objects.object_files import DEFAULT_MASS, Warn, body_of_mesh, body_of_mjcf, body_of_urdf
from graspdsl.objects.shapes import Body, catalogue
from graspdsl.objects.turned import posed
from graspdsl.places.document import Document, Path
from graspdsl.places.files import NamedFile, SpecFolder
from graspdsl.places.wording import shortened
from graspdsl.spec.models import Spec
from graspdsl.spec.scene import InlineObject
from graspdsl.worlds.kinds import WORLDS


def file_hint(name: str, on_command_line: bool = False) -> str | None:
    """How the file that an object's name looks like is given as an object; None for any other name."""
    from graspdsl.models.mesh_files import FORMATS

    suffix, known = PurePosixPath(name).suffix.lower(), (".urdf", ".xml", *FORMATS)
    if suffix not in known:
        return f"the file of an object is one of {', '.join(known)}" if suffix or "/" in name else None
    key = {".urdf": "urdf", ".xml": "mjcf"}.get(suffix)
    file = f"{{{key}: {shortened(name)}}}" if key else f"{{mesh: {{file: {shortened(name)}}}}}"
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
    from_file = bool(thing.file)
    if from_file and not WORLDS[spec.scene.world].has("edges"):
        return None  # contacts cannot float on it, as has been said
    path: Path = ("scene", "object", *thing.file)
    complaints.about(path)
    span = document.span(path) if from_file else None

    def warn(diagnostic: Diagnostic) -> None:
        complaints.add(replace(diagnostic, span=span, fixes=()))

    try:
        if not from_file and not _possible(spec, thing, document, complaints):
            return None
        files = SpecFolder(folder)
        return body_in(files, thing, warn), tuple(files.files)
    except DiagnosticError as error:
        complaints.add(*(replace(diagnostic, span=span, fixes=()) for diagnostic in error.diagnostics))
        return None


def _possible(spec: Spec, thing: InlineObject, document: Document, complaints: Complaints) -> bool:
    """Whether the sizes of a shape go together, and where contacts float its roundings too."""
    shape = thing.shape
    if shape is None:
        return True
    try:
        _ = shape.solid if shape.edged or WORLDS[spec.scene.world].has("edges") else shape.surface()
    except ValueError as error:
        path: Path = ("scene", "object", shape.name)
        complaints.about(path)
        message = f"there is no such {shape.name}: {error}"
        complaints.error("impossible-shape", message, document.span(path), "make its sizes and roundings fit together")
        return False
    return True


def body_in(folder: SpecFolder, choice: str | InlineObject, warn: Warn) -> Body:
    """The object that a scene names or describes; its files are in the folder, what is odd about them goes to ``warn``.

    Raises DiagnosticError when a file cannot be read or holds no solid.
    """
    if isinstance(choice, str):
        return catalogue()[choice]
    body = _as_described(folder, choice, warn)
    return replace(body, shape=posed(body.shape, choice.pose))


def _as_described(folder: SpecFolder, choice: InlineObject, warn: Warn) -> Body:
    """The object that a scene describes, in the pose in which its shape or file has it."""
    if choice.mesh is not None:
        return body_of_mesh(choice.mesh, choice.mass, choice.name, folder, warn)
    if choice.urdf is not None:
        return body_of_urdf(choice.urdf, choice.mass, choice.name, folder, warn)
    if choice.mjcf is not None:
        return body_of_mjcf(choice.mjcf, choice.mass, choice.name, folder, warn)
    if choice.shape is None:
        known = catalogue()[choice.like or ""]
        return replace(known, name=choice.name or known.name, mass=choice.mass or known.mass)
    return Body(choice.name or choice.shape.name, choice.shape, choice.mass or DEFAULT_MASS)
