"""Mesh files of a hand's model: what the engine would leave out without a word, or could not take."""

from __future__ import annotations

import math
import struct
from pathlib import PurePosixPath

import numpy as np

from graspdsl.spec.named_files import refusal
from graspdsl.spec.wording import shortened

LARGEST = 16 * 1024 * 1024  # bytes
HEADER, FACE = 84, 50  # bytes of a binary STL file
AGAIN = "export it anew, as binary STL or as OBJ"


def check_mesh(name: str, content: bytes) -> None:
    """Raises DiagnosticError for a file that is too large, or not all triangles of finite corners."""
    if len(content) > LARGEST:
        message = f"{name} is too large: {len(content)} bytes, where a mesh of a hand may have {LARGEST}"
        raise refusal("file-too-large", message, "simplify it")
    if PurePosixPath(name).suffix.lower() == ".stl":
        _check_stl(name, content)
    else:
        _check_obj(name, content)


def _check_stl(name: str, content: bytes) -> None:
    count = struct.unpack_from("<I", content, HEADER - 4)[0] if len(content) >= HEADER else 0
    held = max(len(content) - HEADER, 0) // FACE
    if count != held or len(content) != HEADER + FACE * count:
        if content.lstrip()[:5] == b"solid" and b"facet" in content[:1024]:
            raise refusal("unreadable-mesh", f"{name} is STL in text, which the engine does not read", AGAIN)
        if held < count and len(content) >= HEADER:
            message = f"{name} is cut short: of the {count} triangles that it announces it holds {held}"
            raise refusal("unreadable-mesh", message, AGAIN)
        raise refusal("unreadable-mesh", f"{name} is no STL file", AGAIN)
    if count == 0:
        raise refusal("empty-mesh", f"{name} holds no triangles", AGAIN)
    faces = np.frombuffer(content, dtype=np.uint8, offset=HEADER).reshape(count, FACE)
    if not np.isfinite(faces[:, 12:48].copy().view("<f4")).all():
        raise refusal("bad-mesh", f"{name} has corners whose coordinates are no numbers", AGAIN)


def _check_obj(name: str, content: bytes) -> None:
    corners, faces = 0, 0
    for number, line in enumerate(content.decode("utf-8", errors="replace").split("\n"), 1):
        key, _, rest = line.strip().partition(" ")
        try:
            if key == "v":
                corners += 1
                _check_corner(rest)
            elif key == "f":
                faces += 1
                _check_face(rest, corners)
        except ValueError:
            message = f"{name}, line {number}: this is no corner or no face of an OBJ file: {shortened(line)!r}"
            raise refusal("unreadable-mesh", message, AGAIN) from None
    if not faces:
        raise refusal("empty-mesh", f"{name} holds no triangles", AGAIN)


def _check_corner(text: str) -> None:
    place = [float(word) for word in text.split()[:3]]
    if len(place) < 3 or not all(map(math.isfinite, place)):
        raise ValueError


def _check_face(text: str, corners: int) -> None:
    indices = [int(word.partition("/")[0]) for word in text.split()]
    if len(indices) < 3 or not all(0 < index <= corners or -corners <= index < 0 for index in indices):
        raise ValueError
