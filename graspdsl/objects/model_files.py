"""URDF and MJCF files as solids: what touches of a body, about the centre of its bounding box, as one rigid body."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import PurePosixPath
from typing import NamedTuple

from graspdsl.angles import roll_pitch_yaw
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity
from graspdsl.models.joint_kinds import FIXED
from graspdsl.models.model import HERE, Frame, Model, Solid
from graspdsl.models.reading import model_in
from graspdsl.objects.box import Box
from graspdsl.objects.capsule import Capsule
from graspdsl.objects.compound import Compound, Placed, centred
from graspdsl.objects.cylinder import Cylinder
from graspdsl.objects.ellipsoid import Ellipsoid
from graspdsl.objects.mesh_files import SPECK, mesh_of_triangles, warn_of_size
from graspdsl.objects.overlaps import overlaps
from graspdsl.objects.shape import Shape
from graspdsl.objects.sphere import Sphere
from graspdsl.places.files import SpecFolder, refusal
from graspdsl.places.xml_files import xml_tree

MOST_PARTS = 200
MOST_FAULTS = 20  # that are told at once

Warn = Callable[[Diagnostic], None]


class ModelObject(NamedTuple):
    """The shape in a model and the mass [kg] that it has by the file, zero where the file says none."""

    shape: Compound
    mass: float


def object_of_urdf(name: str, folder: SpecFolder, warn: Warn) -> ModelObject:
    """What touches of a URDF as one solid, and the sum of the masses that its links state.

    Each part is of even density, whatever inertias the file states, so that the centre of mass and the inertia count
    twice what is in two of them: that is said to ``warn`` where two notably overlap, as ``overlaps`` estimates it.
    Raises DiagnosticError when it has none, is no URDF, or has joints that move.
    """
    if PurePosixPath(name).suffix.lower() != ".urdf":
        raise refusal("unknown-urdf-format", f"{name} is no URDF file: expected .urdf", "name a .urdf, or use mesh")
    content = folder.read(name)
    model = model_in(content, folder, name)
    masses = (float(mass.get("value", "0")) for mass in xml_tree(content, name).iterfind("link/inertial/mass"))
    return ModelObject(_solid_of(name, model, warn), sum(masses))


def object_of_mjcf(name: str, body: str | None, folder: SpecFolder, warn: Warn) -> ModelObject:
    """What touches of a body of an MJCF file, and of those fixed to it, as one solid, and its mass, which the file
    states or gives by the densities of its geoms. By default it is the one body of the world.

    What ``object_of_urdf`` says of densities holds here too. Raises DiagnosticError when there is no such body, the
    file is no MJCF, or something moves on the body.
    """
    try:
        model = model_in(folder.read(name), folder, name, body or "")
    except DiagnosticError as error:
        raise DiagnosticError([_about_body(fault, name) for fault in error.diagnostics]) from None
    return ModelObject(_solid_of(name, model, warn), sum(link.mass for link in model.links.values()))


def _about_body(fault: Diagnostic, name: str) -> Diagnostic:
    if fault.code == "no-root":
        message = fault.message.replace("where a robot is one", "where an object is one")
        hint = f"name one of them: mjcf: {{file: {name}, body: …}}; body: world for all that is fixed"
        return replace(fault, message=message, hint=hint)
    return fault


def _solid_of(name: str, model: Model, warn: Warn) -> Compound:
    """What touches of a model, all of which is fixed to one link; joints that this one moves by are passed over, and
    what the model's warnings are about, joints, looks and inertias, an object has no use for."""
    root, joints = model.root, dict(model.joints)
    while not model.links[root].solids and len(inner := [j for j, made in joints.items() if made.parent == root]) == 1:
        root = joints.pop(inner[0]).child
    moving = [(joint, made) for joint, made in joints.items() if made.kind != FIXED]
    if moving:
        raise DiagnosticError([_moves(joint, made.kind, made.where) for joint, made in moving[:MOST_FAULTS]])
    frames: dict[str, Frame] = {root: HERE}
    for joint in joints.values():  # parents before children
        frames[joint.child] = frames[joint.parent].then(joint.frame)
    solids = [
        (frame.then(solid.frame), solid)
        for link, frame in frames.items()
        for solid in model.links[link].solids
        if solid.touches
    ]
    if not solids:
        raise refusal("no-collisions", f"{name} is no object: nothing of it touches", "give it collision geometry")
    if len(solids) > MOST_PARTS:
        message = f"{name} has {len(solids)} parts that touch, where an object may have {MOST_PARTS}"
        raise refusal("too-many-parts", message, "leave some out, or use one mesh")
    parts = [_placed(frame, solid, warn) for frame, solid in solids]
    _warn_of_overlaps(parts, [solid.where for _, solid in solids], warn)
    whole = centred(parts)
    warn_of_size(name, max(whole.extent), warn, "lengths are in metres")
    return whole


def _placed(frame: Frame, solid: Solid, warn: Warn) -> Placed:
    x, y, z = frame.place.tolist()
    part = _part(solid, warn)
    if solid.mesh is None and min(part.extent) < SPECK:
        message = f"{solid.where}: the {solid.kind} is {min(part.extent):.3g} m thick"
        raise refusal("object-size", message, f"lengths are in metres; no engine has less than {SPECK:g}")
    return Placed(part, (x, y, z), roll_pitch_yaw(frame.rotation))


def _part(solid: Solid, warn: Warn) -> Shape:
    # Not validated: a part may be smaller or larger than a shape in a spec.
    match solid.kind, solid.sizes:
        case "box", (x, y, z):
            return Box.model_construct(size=(x, y, z))
        case "ellipsoid", (x, y, z):
            return Ellipsoid.model_construct(size=(2 * x, 2 * y, 2 * z))
        case "sphere", (radius,):
            return Sphere.model_construct(diameter=2 * radius)
        case "cylinder", (radius, length):
            return Cylinder.model_construct(diameter=2 * radius, height=length)
        case "capsule", (radius, length):
            return Capsule(radius, length)
    assert solid.mesh is not None
    return mesh_of_triangles(f"the mesh at {solid.where}", solid.mesh.corners, solid.mesh.faces, None, warn)


def _warn_of_overlaps(parts: Sequence[Placed], places: Sequence[str], warn: Warn) -> None:
    found = next(overlaps(parts), None)
    if found is None:
        return
    message = (
        f"the collision parts at {places[found.first]} and {places[found.second]} share about {found.share:.0%} of the "
        "smaller: the centre of mass and the inertia of the object count twice what is in both"
    )
    hint = "make the parts touch without overlapping"
    warn(Diagnostic("overlapping-parts", message, None, hint, Severity.WARNING))


def _moves(name: str, kind: str, where: str) -> Diagnostic:
    message = f"{where}: the joint {name} is {kind}, where an object is one rigid body"
    return Diagnostic("moving-joint", message, hint="name a body on which nothing moves, or make the joint fixed")
