"""Arrows, marks and captions drawn over pictures."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from graspdsl.arrays import Array

Colour = tuple[int, int, int]

FORCE: Colour = (214, 84, 20)
NORMAL: Colour = (24, 92, 160)
EDGE: Colour = (255, 255, 255)
INK: Colour = (32, 36, 42)
STRIP: Colour = (250, 250, 250)
FINER = 3  # times, for smooth lines
HEAD = 10.0  # pixels
SHORTEST = 2.0  # pixels that an arrow needs to be drawn


@dataclass(frozen=True, eq=False, slots=True)
class Arrow:
    """An arrow from ``start`` to ``end``, (2,) pixels right and down each."""

    start: Array
    end: Array
    colour: Colour
    width: float


def annotated(picture: npt.NDArray[np.uint8], arrows: Sequence[Arrow], caption: Sequence[str]) -> Image.Image:
    """A picture (height, width, 3) with arrows over it and lines of text on a strip at its lower edge."""
    height, width = picture.shape[:2]
    image = Image.fromarray(picture)
    if arrows:
        image = image.resize((FINER * width, FINER * height), Image.Resampling.BILINEAR)
        pen = ImageDraw.Draw(image)
        for arrow in arrows:
            _draw(pen, arrow, EDGE, 2.0)
            _draw(pen, arrow, arrow.colour, 0.0)
        image = image.resize((width, height), Image.Resampling.LANCZOS)
    if caption:
        _write(image, caption)
    return image


def png(image: Image.Image) -> bytes:
    """The bytes of an image as a PNG file."""
    buffer = io.BytesIO()
    image.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def _draw(pen: ImageDraw.ImageDraw, arrow: Arrow, colour: Colour, border: float) -> None:
    along = arrow.end - arrow.start
    length = float(np.linalg.norm(along))
    if not np.isfinite(length) or length < SHORTEST:
        return
    along = along / length
    across = np.array([-along[1], along[0]])
    head = min(HEAD, 0.6 * length) * (0.6 + 0.2 * arrow.width / 2)
    neck = arrow.end - head * along
    thick = arrow.width / 2 + border / 2
    tail = arrow.start - border / 2 * along
    shaft = [tail + thick * across, neck + thick * across, neck - thick * across, tail - thick * across]
    wing = head / 2 + border
    point = [arrow.end + border * along, neck + wing * across - border * along, neck - wing * across - border * along]
    for corners in (shaft, point):
        pen.polygon([(FINER * x, FINER * y) for x, y in corners], fill=colour)


def _write(image: Image.Image, lines: Sequence[str]) -> None:
    size = max(10, image.width // 38)
    font, spacing, margin = _font(size), round(1.35 * size), size // 2
    top = image.height - spacing * len(lines) - margin
    strip = Image.new("RGB", (image.width, image.height - top), STRIP)
    image.paste(Image.blend(image.crop((0, top, image.width, image.height)), strip, 0.82), (0, top))
    pen = ImageDraw.Draw(image)
    for row, line in enumerate(lines):
        pen.text((margin, top + margin // 2 + row * spacing), line, font=font, fill=INK)


@cache
def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """A font that has ‖ and ρ: the one that comes with matplotlib, found without importing that."""
    found = find_spec("matplotlib")
    if found is not None and found.origin is not None:
        path = Path(found.origin).with_name("mpl-data") / "fonts" / "ttf" / "DejaVuSans.ttf"
        if path.is_file():
            return ImageFont.truetype(str(path), size)
    return ImageFont.load_default(size)
