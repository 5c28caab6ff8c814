"""Arrows, labels and captions drawn over pictures."""

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
Box = tuple[float, float, float, float]

FORCE: Colour = (214, 84, 20)
NORMAL: Colour = (24, 92, 160)
EDGE: Colour = (255, 255, 255)
INK: Colour = (32, 36, 42)
STRIP: Colour = (250, 250, 250)
FINER = 3  # times, for smooth lines
LINE = 1.35  # sizes of the text from one line to the next
HEAD = 10.0  # pixels
MARK = 2.0  # pixels, radius
SHORTEST = 2.0  # pixels that an arrow needs to be drawn


@dataclass(frozen=True, eq=False, slots=True)
class Arrow:
    """An arrow from ``start`` to ``end``, (2,) pixels right and down each."""

    start: Array
    end: Array
    colour: Colour
    width: float


@dataclass(frozen=True, eq=False, slots=True)
class Label:
    """A text beside a place ``at``, (2,) pixels right and down, with a line from one to the other."""

    at: Array
    text: str


def annotated(
    picture: npt.NDArray[np.uint8], arrows: Sequence[Arrow], caption: Sequence[str], labels: Sequence[Label] = ()
) -> Image.Image:
    """A picture (height, width, 3) with arrows and labels over it and lines of text on a strip at its lower edge."""
    height, width = picture.shape[:2]
    image = Image.fromarray(picture)
    if arrows:
        image = image.resize((FINER * width, FINER * height), Image.Resampling.BILINEAR)
        pen = ImageDraw.Draw(image)
        for arrow in arrows:
            _draw(pen, arrow, EDGE, 2.0)
            _draw(pen, arrow, arrow.colour, 0.0)
        image = image.resize((width, height), Image.Resampling.LANCZOS)
    _name(image, labels)
    if caption:
        _write(image, caption)
    return image


def label_boxes(labels: Sequence[Label], width: int, height: int) -> list[Box]:
    """Where the labels are written in a picture of this size: left, top, right and bottom of each [pixels].

    To the right of its place, or to the left of one that is left of the middle of all places or near the right edge;
    below or above another label that is there already.
    """
    font, gap = _font(_text_size(width)), 2 * _text_size(width)
    middle = float(np.mean([label.at[0] for label in labels])) if labels else 0.0
    boxes: list[Box] = []
    for label in labels:
        wide, high = font.getbbox(label.text)[2], round(LINE * _text_size(width))
        x, y = (float(value) for value in label.at)
        goes_left = x + gap + wide > width or (x < middle and x - gap - wide >= 0)
        left = x - gap - wide if goes_left else x + gap
        wanted = min(max(round(y - high / 2), 0), height - high)
        beside = [top for box in boxes for top in (box[1] - high, box[3]) if 0 <= top <= height - high]
        tops = sorted([wanted, *beside], key=lambda top: abs(top - wanted))
        places = [(left, top, left + wide, top + high) for top in tops]
        boxes.append(next((place for place in places if not any(_meet(place, box) for box in boxes)), places[0]))
    return boxes


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


def _meet(one: Box, other: Box) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def _name(image: Image.Image, labels: Sequence[Label]) -> None:
    pen, font = ImageDraw.Draw(image), _font(_text_size(image.width))
    boxes = label_boxes(labels, image.width, image.height)
    for label, (left, top, right, bottom) in zip(labels, boxes, strict=True):
        x, y = (float(value) for value in label.at)
        end = (left - MARK if left > x else right + MARK, (top + bottom) / 2)
        for colour, border in ((EDGE, 1), (INK, 0)):  # the place may be hidden by what is before it
            pen.line([(x, y), end], fill=colour, width=1 + 2 * border)
            radius = MARK + border
            pen.ellipse((x - radius, y - radius, x + radius, y + radius), fill=colour)
    for label, (left, top, _, _) in zip(labels, boxes, strict=True):
        pen.text((left, top), label.text, font=font, fill=INK, stroke_width=2, stroke_fill=EDGE)


def _text_size(width: int) -> int:
    return max(10, width // 38)


def _write(image: Image.Image, lines: Sequence[str]) -> None:
    size = _text_size(image.width)
    font, spacing, margin = _font(size), round(LINE * size), size // 2
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
