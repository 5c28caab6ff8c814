"""The files of a map: figure and numbers."""

from __future__ import annotations

import json
from pathlib import Path

from graspdsl.report.attraction import AttractionMap, as_data
from graspdsl.report.writing import replace
from graspdsl.spec.named_files import MAP_DATA

FILES = ("map.svg", "map.png", MAP_DATA)


def write_map(folder: Path, made: AttractionMap) -> None:
    """Write a map's figure and numbers into a folder. Raises DiagnosticError where it cannot."""
    from graspdsl.report.drawing import png_of, svg_of
    from graspdsl.report.map_figure import map_figure

    figure = map_figure(made)
    contents = (svg_of(figure, "map"), png_of(figure), json.dumps(as_data(made), allow_nan=False) + "\n")
    replace(folder, dict(zip(FILES, contents, strict=True)))
