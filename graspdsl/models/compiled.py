"""The compiler's part: MjSpec is given the text and the triangles, what it finds wrong is told at the user's place."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from graspdsl.arrays import Array
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.models.inertia import ROUNDING, physical
from graspdsl.models.mesh_files import Triangles, check_format, triangles
from graspdsl.models.model import Frame, Mesh
from graspdsl.models.source import Complaints, Prepared, place
from graspdsl.places.files import SpecFolder
from graspdsl.places.mesh_places import MeshPlaces

if TYPE_CHECKING:
    import mujoco

LEAST = 2e-15  # kg or kg m²: what the compiler takes for a mass; lighter links are told of afterwards
LINE = re.compile(r",? line (\d+)")
NAMED = re.compile(r"Element name '([^']+)'")
ALREADY = re.compile(r"^(XML )?Error:? ?(Error: )?")
# A body that stands for one that is only drawn: about its own centre, so that the compiler leaves its frame alone.
STAND_IN = Triangles(
    np.array([[1.0, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]]) * 0.01,
    np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
)


@dataclass(frozen=True, slots=True)
class Compiled:
    """What the compiler made of a model, and its meshes by their numbers there, each with the frame in which a MJCF
    puts it by refpos and refquat."""

    model: mujoco.MjModel
    meshes: Mapping[int, tuple[Mesh, Frame]]


def compiled(given: Prepared, files: SpecFolder, name: str, complaints: Complaints) -> Compiled:
    """The model that a text describes. What is only doubtful about it, and meshes that are not there, are noted.

    Raises DiagnosticError with all faults that were noted, or with the first that the compiler finds.
    """
    import mujoco

    complaints.refuse()
    try:
        with _silenced():
            spec = mujoco.MjSpec.from_string(given.text)
    except ValueError as error:
        raise DiagnosticError([_translated(str(error), given)]) from None
    meshes = _give_meshes(spec, given, files, name, complaints)
    for body in spec.bodies:
        if body.mass < 0.0:
            message = f"the mass of {body.name} is negative: {body.mass:g} kg"
            complaints.fault(given.place("body", body.name), "out-of-range", message, "masses are in kilograms")
    for joint in spec.joints:
        low, high = joint.range
        if low > high:
            message = f"the joint {joint.name}: its limits leave no room: {low:g} to {high:g}"
            complaints.fault(given.place("joint", joint.name), "out-of-range", message, "the lower one comes first")
    _mend_all(spec, given, complaints)
    complaints.refuse()
    spec.compiler.boundmass = max(spec.compiler.boundmass, LEAST)
    spec.compiler.boundinertia = max(spec.compiler.boundinertia, LEAST)
    model = _compile(spec, given)
    numbered = {model.mesh(mesh).id: found for mesh, found in meshes.items()}
    return Compiled(model, numbered)


def _compile(spec: mujoco.MjSpec, given: Prepared) -> mujoco.MjModel:
    """The compiled model, meshes without a volume taken for shells."""
    import mujoco

    thin = set[str]()
    while True:
        try:
            with _silenced():
                return spec.compile()
        except ValueError as error:
            found = next((mesh for mesh in spec.meshes if "volume" in str(error) and _names(mesh, str(error))), None)
            if found is None or found.name in thin:
                raise DiagnosticError([_translated(str(error), given)]) from None
            thin.add(found.name)
            found.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL


@contextmanager
def _silenced() -> Iterator[None]:
    """The compiler says nothing aloud: what it warns of is checked here, or does not matter to a hand."""
    import mujoco

    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        with warnings.catch_warnings(action="ignore"):
            yield
    finally:
        mujoco.set_mju_user_warning(before)


def _names(mesh: Any, message: str) -> bool:
    return bool(re.search(rf"(?<![\w-]){re.escape(mesh.name)}(?![\w-])", message))


def _translated(message: str, given: Prepared) -> Diagnostic:
    """What the compiler complains about, at the place in the user's file."""
    first, *rest = (line.strip() for line in message.splitlines() if line.strip())
    where = ""
    line, named = LINE.search(" ".join(rest) or first), NAMED.search(message)
    if line is not None and 0 < int(line[1]) <= len(given.lines):
        where = place(given.lines[int(line[1]) - 1])
    if not where and named is not None:
        found = [element for (_, name), element in given.elements.items() if name == named[1]]
        where = place(found[0]) if found else ""
    subject = f" (of {named[1]})" if named is not None else ""
    told = LINE.sub("", ALREADY.sub("", first))
    return Diagnostic("bad-model", f"{where or given.file}: {told}{subject}", hint="so says the compiler of MuJoCo")


def _give_meshes(
    spec: mujoco.MjSpec, given: Prepared, files: SpecFolder, name: str, complaints: Complaints
) -> dict[str, tuple[Mesh, Frame]]:
    """Give the compiler the triangles of files, and leave out what is only drawn and cannot be."""
    from scipy.spatial.transform import Rotation  # which takes its time to import

    known, read = MeshPlaces(files, name), dict[str, Triangles]()
    found = dict[str, tuple[Mesh, Frame]]()
    for mesh in list(spec.meshes):
        users = [geom for geom in spec.geoms if geom.meshname == mesh.name]
        element = given.meshes.get(mesh.file)
        if element is None:
            continue  # a fault of it is noted already
        touches, scale = any(geom.contype or geom.conaffinity for geom in users), np.array(mesh.scale)
        shown, place = STAND_IN, ""
        try:
            if not users:
                raise DiagnosticError([])
            file = known.name(element.get("filename", ""))
            check_format(file)
            content, place = files.read(file), str(files.place(file).resolve())
            if touches or _weigh(spec, users) or _are_all(users):
                shown = read[file] = read[file] if file in read else triangles(file, content)
        except DiagnosticError as error:
            for fault in error.diagnostics[:1]:
                at = replace(fault, message=f"{given.place('geom', users[0].name)}: {fault.message}")
                if touches:
                    complaints.faults.append(at)
                else:
                    complaints.undrawn(at)
            if not touches:
                for part in (*users, mesh):
                    spec.delete(part)
                continue
        mesh.file, mesh.uservert, mesh.userface = "", shown.corners.ravel(), shown.faces.ravel()
        x, y, z = scale.tolist()
        rotation = Rotation.from_quat(mesh.refquat, scalar_first=True).as_matrix().T
        put = Frame(-rotation @ (scale * mesh.refpos), rotation)
        if np.ptp(scale) and not np.allclose(rotation, np.eye(3)):
            message = f"the mesh {mesh.name} is turned by refquat and scaled unevenly: a file cannot be drawn so"
            complaints.fault(given.place("mesh", mesh.name), "bad-mesh", message, "turn its geom instead")
        found[mesh.name] = Mesh(place, (x, y, z), shown.corners * scale, shown.faces), put
    return found


def _are_all(geoms: Sequence[Any]) -> bool:
    """Whether these are all that is known of the shape of some body, for nothing of it touches."""
    return any(not any(part.contype or part.conaffinity for part in geom.parent.geoms) for geom in geoms)


def _weigh(spec: mujoco.MjSpec, geoms: Sequence[Any]) -> bool:
    """Whether the masses of bodies follow from some of these."""
    import mujoco

    always = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    stated = [geom for geom in geoms if geom.parent.explicitinertial and not always]
    return any(geom not in stated and geom.mass != 0.0 and geom.density > 0.0 for geom in geoms)


def _mend_all(spec: mujoco.MjSpec, given: Prepared, complaints: Complaints) -> None:
    """Make the stated inertias of bodies such as bodies can have, and tell of the worst."""
    mended = [found for body in spec.bodies if body.explicitinertial if (found := _mended(body)) is not None]
    if mended:
        _, name, old, new = max(mended, key=lambda found: found[0])
        told, now = (", ".join(f"{moment:.3g}" for moment in np.linalg.eigvalsh(tensor)) for tensor in (old, new))
        more = f"; and {len(mended) - 1} others are mended" if len(mended) > 1 else ""
        message = f"no body has the principal moments of inertia of {name}, {told} kg m²: it is given {now}{more}"
        complaints.warn(given.place("body", name), "wrong-inertia", message, "work them out anew from the shape")


def _mended(body: Any) -> tuple[float, str, Array, Array] | None:
    """How far off the inertia of a body was, its name, the inertia (3, 3) and what it was made; None where that is
    within the rounding of a file."""
    whole = not np.isnan(body.fullinertia[0])
    if whole:
        xx, yy, zz, xy, xz, yz = body.fullinertia
        tensor: Array = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    else:
        tensor = np.diag(body.inertia)
    new = physical(tensor, body.mass)
    if whole:
        body.fullinertia = [new[0, 0], new[1, 1], new[2, 2], new[0, 1], new[0, 2], new[1, 2]]
    else:
        body.inertia = np.diag(new)
    off = float(np.abs(new - tensor).max() / np.abs(new).max()) if new.any() else 0.0
    return (off, body.name, tensor, new) if off > ROUNDING else None
