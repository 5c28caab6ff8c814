"""Files of triangles, in any format that trimesh reads. It is loaded only where a model names such a file."""

from __future__ import annotations

import io
import struct
from functools import cache
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array
from graspdsl.diagnostics import DiagnosticError, listed
from graspdsl.places.files import refusal

if TYPE_CHECKING:
    from trimesh import Trimesh

FORMATS = (".stl", ".obj", ".dae", ".ply", ".glb", ".off", ".msh")
MOST_FACES = 500_000
AGAIN = "export it anew, as STL or OBJ"
BINARY_HEADER, BINARY_FACE = 84, 50  # bytes of an STL
MSH_HEADER = 16  # bytes


class Triangles(NamedTuple):
    """Corners (v, 3) [m, or the unit of the file] and the faces (f, 3) between them."""

    corners: Array
    faces: npt.NDArray[np.int64]


def check_format(name: str) -> None:
    """Raises DiagnosticError for a file whose name ends as that of no format that is read."""
    suffix = PurePosixPath(name).suffix.lower()
    if suffix not in FORMATS:
        message = f"{name} is no file of triangles that can be read"
        raise refusal("unknown-mesh-format", message, f"convert it to {listed(FORMATS, 'or')}")


def triangles(name: str, content: bytes) -> Triangles:
    """The triangles in a file, its parts put in their places; those of a DAE, which says its unit, in metres.

    Raises DiagnosticError for a format that is not read, and for a file that holds no triangles of finite corners.
    """
    check_format(name)
    if not content.strip():
        raise refusal("empty-mesh", f"{name} is empty", AGAIN)
    kind = PurePosixPath(name).suffix.lower().removeprefix(".")
    if kind == "stl":
        _check_stl(name, content)
    elif kind in ("obj", "off"):
        _check_text(name, content)
    found = _msh(name, content) if kind == "msh" else _parsed(name, content, kind)
    if len(found.faces) == 0:
        raise refusal("empty-mesh", f"{name} holds no triangles", AGAIN)
    if len(found.faces) > MOST_FACES:
        raise _too_many(name, len(found.faces))
    if found.corners.shape[1:] != (3,):  # as many as its shortest line has
        what = f"corners of {found.corners.shape[-1]} coordinates, where a solid has corners of three"
    elif not 0 <= found.faces.min() <= found.faces.max() < len(found.corners):
        what = "triangles of corners that are not in it"
    elif not np.isfinite(found.corners).all():
        what = "corners whose coordinates are no numbers"
    else:
        return found
    raise refusal("bad-mesh", f"{name} has {what}", AGAIN)


@cache
def stl_of(path: str) -> bytes:
    """The triangles in a file of any of the formats as a binary STL, which every engine reads alike."""
    import trimesh

    found = triangles(path, Path(path).read_bytes())
    return cast("bytes", trimesh.Trimesh(found.corners, found.faces, process=False).export(file_type="stl"))


def _parsed(name: str, content: bytes, kind: str) -> Triangles:
    import trimesh

    if kind == "obj":  # the library takes blanks between words for all that white space is, and remarks for words
        lines = (line.partition(b"#")[0].split() for line in content.splitlines())
        content = b"\n".join(map(b" ".join, lines))
    try:
        # Materials would be read from yet other files.
        loaded = trimesh.load(io.BytesIO(content), file_type=kind, skip_materials=True, process=False)
        scene = loaded if isinstance(loaded, trimesh.Scene) else trimesh.Scene([loaded])
        parts = [part for part in scene.dump() if isinstance(part, trimesh.Trimesh) and len(part.faces)]
        if not parts:
            return Triangles(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
        starts = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
        corners = np.concatenate([np.array(part.vertices, dtype=float) * _unit(part) for part in parts])
        faces = np.concatenate([np.array(part.faces) + start for part, start in zip(parts, starts, strict=True)])
        return Triangles(corners, faces.astype(np.int64))
    except Exception as error:  # whatever a parser makes of a file that is none of its kind
        message = f"{name} cannot be read as {kind.upper()}: {error or type(error).__name__}"
        raise refusal("unreadable-mesh", message.splitlines()[0][:200], AGAIN) from None


def _msh(name: str, content: bytes) -> Triangles:
    """The triangles in a binary file of MuJoCo's: how many corners, normals, places on a texture and faces it has, then
    three, three and two floats for each of them, and three whole numbers for a face."""
    whole = len(content) >= MSH_HEADER
    corners, normals, places, faces = struct.unpack("<4i", content[:MSH_HEADER]) if whole else (-1,) * 4
    end = len(content) - 12 * faces
    if min(corners, normals, places, faces) < 0 or end != MSH_HEADER + 12 * corners + 12 * normals + 8 * places:
        raise refusal("unreadable-mesh", f"{name} is no MSH file of MuJoCo, or cut short", AGAIN)
    if faces > MOST_FACES:
        raise _too_many(name, faces)
    found = np.frombuffer(content, "<f4", 3 * corners, MSH_HEADER).reshape(-1, 3)
    return Triangles(found.astype(float), np.frombuffer(content, "<i4", 3 * faces, end).reshape(-1, 3).astype(np.int64))


def _unit(part: Trimesh) -> float:
    """The unit [m] of a part of a DAE, as trimesh tells it: ``meters`` or ``0.01 * meters``."""
    number, times, _ = str(part.metadata.get("units")).partition("*")
    return float(number) if times else 1.0


def _check_stl(name: str, content: bytes) -> None:
    """Whether a file is an STL and a whole one, which its reader does not look at."""
    announced = struct.unpack("<I", content[80:84])[0] if len(content) >= BINARY_HEADER else 0
    held = (len(content) - BINARY_HEADER) // BINARY_FACE
    text = content.lstrip()[:5].lower() == b"solid" and announced != held
    if not text and announced > held:
        if announced > MOST_FACES or held < 0:
            message = f"{name} is no STL file, neither a binary one nor a text"
            raise refusal("unreadable-mesh", message, "export it anew")
        message = f"{name} is cut short: of the {announced} triangles that it announces it holds {held}"
        raise refusal("unreadable-mesh", message, "export it anew")
    faces = content.lower().count(b"endfacet") if text else announced
    if faces > MOST_FACES:
        raise _too_many(name, faces)


def _check_text(name: str, content: bytes) -> None:
    """Whether a file is text of no more triangles than may be."""
    lines = content.count(b"\nf ")
    if lines > MOST_FACES:
        raise _too_many(name, lines)
    try:
        content.decode("utf-8")
    except UnicodeDecodeError:
        kind = PurePosixPath(name).suffix.upper().removeprefix(".")
        raise refusal("unreadable-mesh", f"{name} is no {kind} file: it is not text", "export it anew") from None


def _too_many(name: str, faces: int) -> DiagnosticError:
    message = f"{name} has {faces} triangles, where a mesh may have {MOST_FACES}"
    return refusal("file-too-large", message, "simplify it")
