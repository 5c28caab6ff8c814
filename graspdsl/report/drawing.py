"""How figures are drawn, and written as files and as parts of a page; the same figure gives the same bytes.

Canvases write them, not ``Figure.savefig``, which draws and lays out each figure once more before it does.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import matplotlib
from markupsafe import Markup, escape
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.text import Text

from graspdsl.report.palette import LIGHT
from graspdsl.report.statistics import RIGHT_ANGLE

RESOLUTION = 200  # dots per inch
WIDTH = 5.4  # in
SMALL, MEDIUM = 8.0, 8.8  # pt
TURNS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, RIGHT_ANGLE)
_BY_COLOUR = {colour: name for name, colour in LIGHT.items()}


class Sheet(Figure):
    """A figure that a notebook shows by itself, whether or not it has pyplot."""

    def _repr_png_(self) -> bytes:
        return png_of(self)


@dataclass(frozen=True)
class Drawing:
    """A figure with its name, which is that of its files too, and its caption."""

    name: str
    figure: Figure
    caption: str

    @cached_property
    def file(self) -> str:
        """Itself as an SVG file."""
        return svg_of(self.figure, self.name)

    @property
    def svg(self) -> Markup:
        """Itself as a part of a page."""
        return Markup(inline_svg(self.file, self.name, str(escape(self.caption))))

    def files(self, folder: str = "") -> dict[str, str | bytes]:
        """Its files by their names, for papers too; both are laid out alike."""
        file, layout = self.file, self.figure.get_layout_engine()
        self.figure.set_layout_engine("none")
        picture = png_of(self.figure)
        self.figure.set_layout_engine(layout)
        return {f"{folder}{self.name}.svg": file, f"{folder}{self.name}.png": picture}


def panels_of(height: float, ratios: Sequence[float], *, shared: bool = True) -> tuple[Figure, list[Axes]]:
    """A figure and its panels, one above the other over the same abscissa, or each over its own."""
    figure = Sheet((WIDTH, height), layout="constrained", facecolor=LIGHT["ground"])
    panels = list(
        figure.subplots(len(ratios), 1, sharex=shared, squeeze=False, gridspec_kw={"height_ratios": ratios})[:, 0]
    )
    for axes in panels:
        axes.set_facecolor("none")
        axes.spines[["top", "right"]].set_visible(False)
        axes.spines[["left", "bottom"]].set(color=LIGHT["muted"], linewidth=0.7)
        axes.tick_params(colors=LIGHT["muted"], labelsize=SMALL, width=0.7, length=3)
        axes.xaxis.label.set(color=LIGHT["ink"], fontsize=MEDIUM)
        axes.yaxis.label.set(color=LIGHT["ink"], fontsize=MEDIUM)
    return figure, panels


def over_orientations(axes: Axes, label: str) -> None:
    """Let the abscissa be the orientation of grasps [rad]."""
    axes.set_xlim(0.0, RIGHT_ANGLE)
    axes.set_xticks(TURNS, [*(f"{turn:g}" for turn in TURNS[:-1]), "π/2"])
    axes.set_xlabel(label)


def legend_above(figure: Figure, axes: Axes, columns: int = 1) -> None:
    """Put the names of what axes show above the figure; they are users' text."""
    handles, labels = axes.get_legend_handles_labels()
    made = figure.legend(
        handles, labels, loc="outside upper left", frameon=False, fontsize=SMALL, labelcolor=LIGHT["ink"], ncols=columns
    )
    for text in made.get_texts():
        text.set_parse_math(False)


def svg_of(figure: Figure, name: str) -> str:
    """A figure as an SVG file, its text as text."""
    stream = io.StringIO()
    as_text = matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": name})
    with _written_out(figure), _kept(figure), _quiet(), as_text:
        canvas: Any = FigureCanvasSVG(figure)  # whose own types are missing
        canvas.print_svg(stream, metadata={"Date": None, "Creator": None})
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
def _kept(figure: Figure) -> Iterator[None]:
    """A figure has its own canvas and resolution again when it has been written: a notebook may show it later."""
    canvas, dpi = figure.canvas, figure.dpi
    try:
        yield
    finally:
        figure.set_canvas(canvas)
        figure.dpi = dpi


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
    with _kept(figure), _quiet():
        figure.dpi = RESOLUTION
        canvas: Any = FigureCanvasAgg(figure)
        canvas.print_png(stream, metadata={"Software": None})
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
