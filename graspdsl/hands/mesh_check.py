"""Mesh files of a hand's model: what the engine would leave out without a word, or could not take."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Sequence
from pathlib import PurePosixPath

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.urdf_check import NUMBER
from graspdsl.places.files import refusal
from graspdsl.places.wording import shortened

LARGEST = 16 * 1024 * 1024  # bytes
HEADER, FACE = 84, 50  # bytes of a binary STL file
BLANKS = re.compile(r"[ \t]+")  # other white space parts no words for the engine
INDICES = re.compile(r"[+-]?\d{1,9}(?:/[+-]?\d{0,9}){0,2}", re.ASCII)  # of a corner, its texture and its normal
AGAIN = "export it anew, as binary STL or as OBJ"


def mesh_corners(name: str, content: bytes) -> Array:
    """The corners (c, 3) of the triangles in a file. Raises DiagnosticError where it is too large, or not all triangles
    of finite corners."""
    if len(content) > LARGEST:
        message = f"{name} is too large: {len(content)} bytes, where a mesh of a hand may have {LARGEST}"
        raise refusal("file-too-large", message, "simplify it")
    if PurePosixPath(name).suffix.lower() == ".stl":
        return _stl_corners(name, content)
    return _obj_corners(name, content)


def _stl_corners(name: str, content: bytes) -> Array:
    count = struct.unpack_from("<I", content, HEADER - 4)[0] if len(content) >= HEADER else 0
    held = max(len(content) - HEADER, 0) // FACE
    if count != held or len(content) != HEADER + FACE * count:
        if content.lstrip()[:5] == b"solid" and b"facet" in content[:1024]:
            raise refusal("unreadable-mesh", f"{name} is STL in text, which the engine does not read", AGAIN)
        if held < count and len(content) >= HEADER:
            message = f"{name} is cut short: of the {count} triangles that it announces it holds {held}"
            raise refusal("unreadable-mesh", message, AGAIN)
        if 0 < count <= held:
            excess = len(content) - HEADER - FACE * count
            message = f"{name} has {excess} bytes more than the {count} triangles that it announces take"
            raise refusal("unreadable-mesh", f"{message}: the engine reads none of them", AGAIN)
        raise refusal("unreadable-mesh", f"{name} is no STL file", AGAIN)
    if count == 0:
        raise refusal("empty-mesh", f"{name} holds no triangles", AGAIN)
    faces = np.frombuffer(content, dtype=np.uint8, offset=HEADER).reshape(count, FACE)
    corners = faces[:, 12:48].copy().view("<f4").reshape(-1, 3)
    if not np.isfinite(corners).all():
        raise refusal("bad-mesh", f"{name} has corners whose coordinates are no numbers", AGAIN)
    return corners.astype(float)


def _obj_corners(name: str, content: bytes) -> Array:
    corners, used = list[list[float]](), set[int]()
    for number, line in enumerate(content.decode("utf-8", errors="replace").split("\n"), 1):
        told, mark, _ = line.partition("#")
        key, *words = BLANKS.split(told.strip(" \t\r"))
        if key == "f" and mark:
            message = f"{name}, line {number}: a comment after a face, with which the engine reads no face at all"
            raise refusal("unreadable-mesh", message, "put it on a line of its own, or leave it out")
        if key == "v" and _is_corner(words):
            corners.append([float(word) for word in words[:3]])
        elif key == "f" and (face := _face(words, len(corners))):
            used.update(face)
        elif key in ("v", "f"):
            message = f"{name}, line {number}: this is no corner or no face of an OBJ file: {shortened(line)!r}"
            raise refusal("unreadable-mesh", message, AGAIN)
    if not used:
        raise refusal("empty-mesh", f"{name} holds no triangles", AGAIN)
    return np.array(corners)[sorted(used)]


def _is_corner(words: Sequence[str]) -> bool:
    place = words[:3]
    return len(place) == 3 and all(NUMBER.fullmatch(word) and math.isfinite(float(word)) for word in place)


def _face(words: Sequence[str], corners: int) -> list[int]:
    """The corners of a face, counted from 0; none of what is no face."""
    indices = [int(word.partition("/")[0]) if INDICES.fullmatch(word) else 0 for word in words]
    right = len(indices) >= 3 and all(0 < index <= corners or -corners <= index < 0 for index in indices)
    return [index - 1 if index > 0 else corners + index for index in indices] if right else []
