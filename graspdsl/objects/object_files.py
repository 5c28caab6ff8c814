"""Objects from files: of triangles, URDF and MJCF; files of objects by their names as other packages bring them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, create_model, model_validator

from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.objects.shape import DescribedShape
from graspdsl.objects.shapes import SHAPES, Body
from graspdsl.objects.turned import ObjectPose, posed
from graspdsl.places.document import parse_document
from graspdsl.places.fields import Kilograms, Model, Number, fault, form, forms
from graspdsl.places.files import SpecFolder, read_text
from graspdsl.places.folders import SUFFIXES, told_of
from graspdsl.places.validation import validate_document

if TYPE_CHECKING:
    from graspdsl.objects.model_files import ModelObject

DEFAULT_MASS = 0.5  # kg
FILES = ("mesh", "urdf", "mjcf")

FilePath = Annotated[str, Field(min_length=1, max_length=1000)]
Mass = Annotated[Kilograms, Field(gt=0.0, le=100.0)]
Warn = Callable[[Diagnostic], None]


class Mesh(Model):
    """A file of triangles."""

    file: FilePath = Field(
        description="an STL, OBJ, PLY, GLB, DAE or OFF file; a relative path starts at the folder of the spec and "
        "stays in it",
        examples=["part.stl"],
    )
    scale: Number = Field(
        default=1.0,
        gt=0.0,
        le=1e6,
        description="what a length in the file is in m: 0.001 for millimetres; a DAE says that itself",
    )
    convex: Literal["hull", "decomposition"] | None = Field(
        default=None,
        description="what collides, by default the parts where the hull is 5 % larger; hull: the convex hull; "
        "decomposition: convex parts",
    )
    density: Number | None = Field(
        default=None, gt=0.0, le=30000.0, description="density (kg/m³), instead of a mass of the object"
    )


def body_of_mesh(mesh: Mesh, mass: float | None, name: str | None, folder: SpecFolder, warn: Warn) -> Body:
    """The object in a file of triangles, of a mass [kg], or by its density.

    Raises DiagnosticError when the file cannot be read or holds no solid; what is odd about it goes to ``warn``.
    """
    from graspdsl.objects.mesh_files import mesh_of_file

    shape = mesh_of_file(mesh.file, folder.read(mesh.file), mesh.scale, mesh.convex, warn)
    mass = mass or (DEFAULT_MASS if mesh.density is None else mesh.density * shape.solid.volume)
    return Body(name or PurePath(mesh.file).stem, shape, mass, digest=folder.digest)


class MjcfBody(Model):
    """A body in an MJCF file."""

    file: FilePath = Field(description="the file; a relative path starts at the folder of the spec", examples=["a.xml"])
    body: str | None = Field(
        default=None,
        min_length=1,
        max_length=200,
        description="the name of the body; by default the one body of the world; world: all of it",
    )


def _mjcf_form(value: Any) -> str | None:
    if isinstance(value, str):
        return "file"
    return "body" if isinstance(value, dict | MjcfBody) else None


MjcfChoice = Annotated[
    Annotated[FilePath, form("file")] | Annotated[MjcfBody, form("body")],
    forms("an MJCF file, or {file: part.xml, body: the name of one of its bodies}", _mjcf_form),
]


def body_of_urdf(file: str, mass: float | None, name: str | None, folder: SpecFolder, warn: Warn) -> Body:
    """The object in a URDF file, of a mass [kg], or of those that the file states.

    Raises DiagnosticError when the file cannot be read or holds no rigid body; what is odd about it goes to ``warn``.
    """
    from graspdsl.objects.model_files import object_of_urdf

    return _body(object_of_urdf(file, folder, warn), mass, name or PurePath(file).stem, folder)


def body_of_mjcf(choice: str | MjcfBody, mass: float | None, name: str | None, folder: SpecFolder, warn: Warn) -> Body:
    """The object in an MJCF file, of a mass [kg], or of that of the body there.

    Raises DiagnosticError when the file cannot be read or holds no rigid body; what is odd about it goes to ``warn``.
    """
    from graspdsl.objects.model_files import object_of_mjcf

    file, body = (choice, None) if isinstance(choice, str) else (choice.file, choice.body)
    return _body(object_of_mjcf(file, body, folder, warn), mass, name or body or PurePath(file).stem, folder)


def _body(found: ModelObject, mass: float | None, name: str, folder: SpecFolder) -> Body:
    return Body(name, found.shape, mass or found.mass or DEFAULT_MASS, digest=folder.digest)


def objects_in(place: Path) -> dict[str, Body]:
    """The objects in a file, or in every YAML file of a folder, by name.

    Each is ``name: {SHAPE: {…}, mass: …, about: …}`` with one of the table of shapes, or with ``mesh: {file: …}``,
    ``urdf: FILE`` or ``mjcf: FILE``. Raises DiagnosticError with the faults of the first file that has any, each told
    with its place.
    """
    files = [place] if place.is_file() else [path for path in sorted(place.glob("*")) if path.suffix in SUFFIXES]
    return {name: body for path in files for name, body in _objects(path).items()}


class _Entry(Model):
    mesh: Mesh | None = None
    urdf: FilePath | None = None
    mjcf: MjcfChoice | None = None
    mass: Mass | None = None
    pose: ObjectPose | None = None
    about: str = Field(default="", max_length=1000)

    @property
    def shape(self) -> DescribedShape | None:
        """The one of the table of shapes, if there is one."""
        return next((shape for name in SHAPES if (shape := getattr(self, name, None)) is not None), None)

    @model_validator(mode="after")
    def _one_shape(self) -> _Entry:
        found = [name for name in (*SHAPES, *FILES) if getattr(self, name) is not None]
        if len(found) != 1:
            known = ", ".join((*SHAPES, *FILES))
            message = f"an object has exactly one shape ({known}), found {' and '.join(found) or 'none'}"
            raise fault("wrong-form", message, "for example {cylinder: {diameter: 0.10, height: 0.20}, mass: 0.5}")
        try:
            _ = None if self.shape is None else self.shape.solid
        except ValueError as error:
            raise fault("impossible-shape", f"there is no such {found[0]}: {error}") from None
        return self

    def body(self, name: str, files: SpecFolder) -> Body:
        """The object; its files lie in a folder."""
        if self.mesh is not None:
            body = body_of_mesh(self.mesh, self.mass, name, files, _passed_over)
        elif self.urdf is not None:
            body = body_of_urdf(self.urdf, self.mass, name, files, _passed_over)
        elif self.mjcf is not None:
            body = body_of_mjcf(self.mjcf, self.mass, name, files, _passed_over)
        else:
            assert self.shape is not None
            body = Body(name, self.shape, self.mass or DEFAULT_MASS)
        return replace(body, shape=posed(body.shape, self.pose), about=self.about)


def _objects(path: Path) -> dict[str, Body]:
    try:
        document = parse_document(read_text(path), path.name)
        shapes: dict[str, Any] = {name: (kind | None, None) for name, kind in SHAPES.items()}
        entry = create_model("Entry", __base__=_Entry, **shapes)
        # Their names may be any that YAML can write, which those of fields may not.
        fields: dict[str, Any] = {
            f"object_{number}": (entry, Field(alias=name)) for number, name in enumerate(document.data)
        }
        found = validate_document(document, create_model("Objects", __base__=Model, **fields))
        bodies = zip(document.data, dict(found).values(), strict=True)
        return {name: entry.body(name, SpecFolder(path.parent)) for name, entry in bodies}
    except DiagnosticError as error:
        raise DiagnosticError(told_of(path.name, error.diagnostics)) from None


def _passed_over(warning: Diagnostic) -> None:
    """What is odd about a file is its author's to see."""
    del warning
