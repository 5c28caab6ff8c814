"""The report of a run as files: one page that needs no other, and its figures for papers."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from markupsafe import Markup, escape

from graspdsl.report.drawing import inline_svg, png_of
from graspdsl.report.evidence import Evidence
from graspdsl.report.outcomes import representatives
from graspdsl.report.page_figures import (
    Drawing,
    drawn_convergence,
    drawn_funnel,
    drawn_map,
    drawn_residuals,
    drawn_starts,
    tick_of,
)
from graspdsl.report.page_quality import quality_tables
from graspdsl.report.page_tables import (
    claims_table,
    modes_table,
    outcomes_table,
    residuals_table,
    sensing_table,
    starts_tables,
    trials_table,
)
from graspdsl.report.page_words import left_out, notes, setting, verdict
from graspdsl.report.summary import numbers_of
from graspdsl.report.templating import DrawnFigure, rendered
from graspdsl.report.wording import conditions, number
from graspdsl.report.writing import replace
from graspdsl.trials.outcomes import OUTCOMES

PAGE, FIGURES = "report.html", "figures"
Frames = Mapping[str, bytes]
NO_FRAMES: Frames = MappingProxyType({})


def page(evidence: Evidence, *, frames: Frames = NO_FRAMES, claims: Sequence[Mapping[str, Any]] = ()) -> str:
    """The page of a run: one file that needs no other.

    frames: a PNG picture of the end of one trial for each outcome, by the outcome's name, of the trials that
    :func:`graspdsl.report.outcomes.representatives` names. claims: rows {experiment, says, bound, measured, verdict,
    why}.
    """
    numbers = numbers_of(evidence)
    return _page(evidence, numbers, _drawings(evidence, numbers), frames, claims)


def write_report(evidence: Evidence, *, frames: Frames = NO_FRAMES, claims: Sequence[Mapping[str, Any]] = ()) -> Path:
    """Write the page of a run and its figures, as SVG and PNG, into the run's folder; returns where the page is.

    Each file takes the place of an earlier one only once it is whole; figures that the run no longer has are removed.
    Raises DiagnosticError where the folder cannot be written to.
    """
    numbers = numbers_of(evidence)
    drawings = _drawings(evidence, numbers)
    files: dict[str, str | bytes] = {}
    for drawing in drawings:
        files[f"{FIGURES}/{drawing.name}.svg"] = drawing.svg
        files[f"{FIGURES}/{drawing.name}.png"] = png_of(drawing.figure)
    files[PAGE] = _page(evidence, numbers, drawings, frames, claims)
    folder = evidence.folder.path
    replace(folder, files, outdated=(f"{FIGURES}/*.svg", f"{FIGURES}/*.png"))
    return folder / PAGE


def _drawings(evidence: Evidence, numbers: Mapping[str, Any]) -> list[Drawing]:
    found = [
        drawn_funnel(evidence, numbers),
        *drawn_residuals(evidence, numbers),
        drawn_convergence(evidence),
        drawn_map(evidence),
        drawn_starts(evidence, numbers),
    ]
    return [drawing for drawing in found if drawing is not None]


def _page(
    evidence: Evidence,
    numbers: Mapping[str, Any],
    drawings: Sequence[Drawing],
    frames: Frames,
    claims: Sequence[Mapping[str, Any]],
) -> str:
    tick = tick_of(evidence)
    return rendered(
        "report.html",
        numbers=numbers,
        spec=evidence.program.spec,
        spec_text=evidence.folder.spec_text,
        overrides=evidence.folder.manifest.overrides,
        phases=[phase.label for phase in evidence.program.phases],
        setting=setting(evidence),
        verdict=verdict(numbers),
        conditions=conditions(numbers["converged"]["means"]),
        notes=notes(evidence, numbers),
        left_out=left_out(evidence),
        claims=claims_table(claims),
        funnel=_inlined(drawings, "funnel"),
        modes=modes_table(numbers),
        residual_figures=_inlined(drawings, "residuals"),
        residuals=residuals_table(numbers),
        convergence=_inlined(drawings, "convergence"),
        ticks=[number(numbers["ticks_to_converge"][which], "", 0) for which in ("median", "p90")],
        outcomes=outcomes_table(numbers),
        frames=_framed(evidence, frames),
        starts=starts_tables(numbers),
        start_figures=_inlined(drawings, "starts"),
        map=_inlined(drawings, "map"),
        quality=quality_tables(numbers["quality"]),
        sensing=sensing_table(numbers),
        tick=tick,
        trials=trials_table(numbers, tick),
    )


def _inlined(drawings: Sequence[Drawing], kind: str) -> list[DrawnFigure]:
    return [
        DrawnFigure(Markup(inline_svg(drawing.svg, drawing.name, str(escape(drawing.caption)))), drawing.caption)
        for drawing in drawings
        if drawing.name.startswith(kind)
    ]


def _framed(evidence: Evidence, frames: Frames) -> list[dict[str, str]]:
    """The pictures as addresses that hold them, with their captions."""
    return [
        {
            "address": f"data:image/png;base64,{base64.b64encode(frames[outcome]).decode('ascii')}",
            "caption": f"{outcome}: trial {record.number} at its end; {record.detail or OUTCOMES[outcome].means}",
        }
        for outcome, record in representatives(evidence.records).items()
        if outcome in frames
    ]
