"""Figures as files and as parts of a page; the same figure gives the same bytes."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager

import matplotlib
from matplotlib.figure import Figure
from matplotlib.text import Text

from graspdsl.report.palette import LIGHT

RESOLUTION = 200  # dots per inch
_BY_COLOUR = {colour: name for name, colour in LIGHT.items()}


def svg_of(figure: Figure, name: str) -> str:
    """A figure as an SVG file, its text as text."""
    stream = io.StringIO()
    with _written_out(figure), matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    lowered = re.sub(
        r"ρ_(\w)([^<]*)", r'ρ<tspan dy="2" font-size="70%">\1</tspan><tspan dy="-2">\2</tspan>', stream.getvalue()
    )
    return re.sub(r"-?\d+\.\d{3,}", lambda match: f"{float(match[0]):.2f}", lowered)


@contextmanager
def _written_out(figure: Figure) -> Iterator[None]:
    """Labels without TeX, of which SVG would place every letter by itself."""
    before = {label: label.get_text() for label in figure.findobj(Text)}
    for label, text in before.items():
        label.set_text(re.sub(r"\$(.*?)\$", r"\1", text))
    try:
        yield
    finally:
        for label, text in before.items():
            label.set_text(text)


def png_of(figure: Figure) -> bytes:
    """A figure as a PNG picture, for papers."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=RESOLUTION, metadata={"Software": None})
    return stream.getvalue()


def inline_svg(file: str, name: str, label: str) -> str:
    """The SVG of a file as a part of a page: in the page's colours, with ids that are its own, no wider than its place.

    label: what the figure shows, as HTML text already escaped.
    """
    body = file[file.index("<svg") :]
    body = re.sub(r"<metadata>.*?</metadata>|<style[^>]*>.*?</style>", "", body, flags=re.DOTALL)
    box = re.search(r'viewBox="([^"]*)"', body)
    assert box is not None
    opening = f'<svg class="figure" viewBox="{box[1]}" role="img" aria-label="{label}">'
    body = re.sub(r"<svg\b[^>]*>", opening, body, count=1).replace("xlink:href", "href")
    body = re.sub(r'\bid="', f'id="{name}-', body)
    body = re.sub(r'(href="#|url\(#)', rf"\1{name}-", body)
    body = re.sub(r"#[0-9a-f]{6}\b", lambda match: _variable(match[0]), body)
    return re.sub(r"font-family: [^;\"]*", "font-family: inherit", body)


def _variable(colour: str) -> str:
    return f"var(--{_BY_COLOUR[colour]})" if colour in _BY_COLOUR else colour
