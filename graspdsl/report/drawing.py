"""Figures as files and as parts of a page; the same figure gives the same bytes."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Callable, Iterator
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
    with _written_out(figure), _quiet(), matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    without_comments = re.sub(r"<!--.*?-->\n?", "", stream.getvalue(), flags=re.DOTALL)
    lowered = re.sub(
        r"ρ_(\w)([^<]*)", r'ρ<tspan dy="2" font-size="70%">\1</tspan><tspan dy="-2">\2</tspan>', without_comments
    )
    return _in_tags(r"-?\d+\.\d{3,}", lambda match: f"{float(match[0]):.2f}", lowered)


@contextmanager
def _written_out(figure: Figure) -> Iterator[None]:
    """Labels without TeX, of which SVG would place every letter by itself; users' text is none (``parse_math``)."""
    before = {label: label.get_text() for label in figure.findobj(Text) if label.get_parse_math()}
    for label, text in before.items():
        label.set_text(re.sub(r"\$(.*?)\$", r"\1", text))
    try:
        yield
    finally:
        for label, text in before.items():
            label.set_text(text)


@contextmanager
def _quiet() -> Iterator[None]:
    """No word about letters that the font lacks: the reader's font may have them."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph \d+ .* missing from", UserWarning)
        yield


def _in_tags(pattern: str, replacement: str | Callable[[re.Match[str]], str], text: str) -> str:
    """Substitute within tags, and leave the text between them alone."""
    return re.sub(r"<[^>]*>", lambda tag: re.sub(pattern, replacement, tag[0]), text)


def png_of(figure: Figure) -> bytes:
    """A figure as a PNG picture, for papers."""
    stream = io.BytesIO()
    with _quiet():
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
    body = _in_tags(r"xlink:href", "href", body)
    body = _in_tags(r'\bid="', f'id="{name}-', body)
    body = _in_tags(r'(href="#|url\(#)', rf"\1{name}-", body)
    body = _in_tags(r"#[0-9a-f]{6}\b", lambda match: _variable(match[0]), body)
    body = _in_tags(r"font-family: [^;\"]*", "font-family: inherit", body)
    return re.sub(r"<svg\b[^>]*>", lambda _: opening, body, count=1)


def _variable(colour: str) -> str:
    return f"var(--{_BY_COLOUR[colour]})" if colour in _BY_COLOUR else colour
