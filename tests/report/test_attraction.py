"""Classes of a map, its numbers and its figure."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Mapping

import numpy as np
import pytest
from PIL import Image

from graspdsl.report.attraction import AttractionMap, as_data, classes_of
from graspdsl.report.drawing import png_of, svg_of
from graspdsl.report.map_figure import map_figure, style_of
from graspdsl.report.statistics import wilson
from graspdsl.trials.maps import Axis, Cells
from graspdsl.trials.outcomes import OUTCOMES, Outcome

X, Y = Axis("roll", "rad", -1.0, 1.0, 4), Axis("height", "m", 0.0, 0.3, 3)
ENDS = ["converged"] * 8 + ["timeout"] * 3 + ["infeasible-start"]
ORIENTATION = [0.1, 0.1, 0.1, 1.5, 1.5, 1.5, 1.5, math.nan, 0.8, 0.8, 0.8, math.nan]


def made(cells: Cells) -> AttractionMap:
    """A map of cells."""
    return AttractionMap("a-map", "bullet", 7, "graspdsl map", "ticks", cells, classes_of(cells))


def some(outcomes: list[str] = ENDS, marks: Mapping[str, tuple[float, float]] | None = None) -> Cells:
    """Twelve cells that ended so."""
    ticks = [10.0 * (place + 1) if name == "converged" else math.nan for place, name in enumerate(outcomes)]
    details = tuple("" if name == "converged" else f"{name} after {place} s" for place, name in enumerate(outcomes))
    values = np.array(ORIENTATION), np.array(ticks)
    return Cells(X, Y, tuple(outcomes), *values, {"yaw": "0 rad"}, marks or {}, details)


def test_converged_cells_part_by_mode_and_others_by_outcome() -> None:
    found = classes_of(some())
    assert [(entry.outcome, entry.mode, entry.cells) for entry in found] == [
        ("converged", 1, (3, 4, 5, 6)),
        ("converged", 2, (0, 1, 2)),
        ("converged", None, (7,)),
        ("timeout", None, (8, 9, 10)),
        ("infeasible-start", None, (11,)),
    ]
    assert found[0].centre == pytest.approx(1.5, abs=0.1)


def test_infeasible_starts_come_last_however_many() -> None:
    found = classes_of(some(["infeasible-start"] * 8 + ["crashed"] + ["timeout"] * 3))
    assert [entry.outcome for entry in found] == ["timeout", "crashed", "infeasible-start"]


def test_numbers_of_a_map() -> None:
    numbers = json.loads(json.dumps(as_data(made(some())), allow_nan=False))
    assert numbers["grid"] == [[1, 1, 1, 0], [0, 0, 0, 2], [3, 3, 3, 4]]
    assert numbers["ticks"][2] == [None] * 4
    assert (numbers["cells"], numbers["feasible"]) == (12, 11)
    assert numbers["converged"] == {"count": 8, "share": 8 / 11, "interval": list(wilson(8, 11))}
    assert numbers["classes"][3]["interval"] == list(wilson(3, 12))
    assert numbers["axes"][0]["middles"] == [-0.75, -0.25, 0.25, 0.75]


def test_a_map_says_why_cells_did_not_converge() -> None:
    numbers = json.loads(json.dumps(as_data(made(some()))))
    assert numbers["details"][:2] == [[None] * 4] * 2
    assert numbers["details"][2] == [
        *(f"timeout after {second} s" for second in (8, 9, 10)),
        "infeasible-start after 11 s",
    ]
    assert [entry["mostly"] for entry in numbers["classes"]] == [
        *[None] * 3,
        {"detail": "timeout after 8 to 10 s", "count": 3},
        {"detail": "infeasible-start after 11 s", "count": 1},
    ]


def test_nothing_feasible_has_no_share() -> None:
    numbers = as_data(made(some(["infeasible-start"] * 12)))
    assert (numbers["feasible"], numbers["converged"]["share"]) == (0, None)


def test_every_outcome_has_a_style_of_its_own() -> None:
    """Also in black and white: no two outcomes share grey and hatching."""
    outcomes = [outcome.value for outcome in OUTCOMES.values() if outcome is not Outcome.CONVERGED]
    found = classes_of(some(outcomes + outcomes[: 12 - len(outcomes)]))
    assert len({style_of(entry) for entry in found}) == len(outcomes)
    for entry in found:
        colour = style_of(entry)[0].lstrip("#")
        red, green, blue = bytes.fromhex(colour)
        assert max(red, green, blue) - min(red, green, blue) < 24  # of 255: grey


@pytest.mark.slow
def test_the_figure_shows_each_cell_where_it_lies() -> None:
    """The middle of each cell in the picture has the colour of its class: the first row below, x to the right."""
    whole = made(some(["converged"] * 8 + ["local-minimum"] * 3 + ["converged"]))
    figure = map_figure(whole)
    picture = Image.open(io.BytesIO(png_of(figure))).convert("RGB")
    axes = figure.axes[0]
    scale = picture.width / figure.bbox.width
    colours = {cell: style_of(entry)[0] for entry in whole.classes for cell in entry.cells}
    for cell, colour in colours.items():
        row, column = divmod(cell, 4)
        across, up = axes.transData.transform((X.middles[column], Y.middles[row]))
        pixel = picture.getpixel((round(across * scale), picture.height - round(up * scale)))
        assert isinstance(pixel, tuple)
        assert bytes(pixel[:3]).hex() == colour.lstrip("#")


@pytest.mark.slow
def test_the_figure_says_what_it_shows() -> None:
    whole = made(some(marks={"point-2": (0.5, 0.1)}))
    text = svg_of(map_figure(whole), "map")
    for said in ("roll (rad)", "height (m)", "a-map, seed 7. Fixed: yaw 0 rad.", "ticks to converge", "point-2"):
        assert said in text
    low, high = wilson(3, 12)
    assert f"timeout: 3 cells, 25 % ({100 * low:.0f} to {100 * high:.0f} %)" in text
    assert svg_of(map_figure(whole), "map") == text


def test_a_map_without_convergence_has_one_panel() -> None:
    assert len(map_figure(made(some(["timeout"] * 12))).axes) == 1


def test_a_floating_map_has_the_top_of_the_object_above() -> None:
    axis = Axis("polar", "rad", 0.0, 3.0, 3)
    cells = Cells(X, axis, ("converged",) * 12, np.zeros(12), np.ones(12), {"contact": "point-1"}, {}, ("",) * 12)
    axes = map_figure(made(cells)).axes[0]
    assert axes.get_ylim() == (3.0, 0.0)
    assert axes.get_ylabel() == "polar angle of point-1 from the top (rad)"
