"""The files of a map: figure and numbers."""

from __future__ import annotations

import json

from graspdsl.places.files import MAP_DATA
from graspdsl.report.attraction import AttractionMap, as_data

FILES = ("map.svg", "map.png", MAP_DATA)


def map_files(made: AttractionMap) -> dict[str, str | bytes]:
    """A map's figure and numbers, by the names of their files."""
    from graspdsl.report.drawing import png_of, svg_of
    from graspdsl.report.map_figure import map_figure

    figure = map_figure(made)
    contents = (svg_of(figure, "map"), png_of(figure), json.dumps(as_data(made), allow_nan=False) + "\n")
    return dict(zip(FILES, contents, strict=True))
