"""A run as the output of a notebook's cell: whether it worked, how trials ended, where grasps started and ended."""

from __future__ import annotations

import base64

from graspdsl.report.evidence import Evidence
from graspdsl.report.figure_data import funnel_of
from graspdsl.report.figures import drawn_funnel
from graspdsl.report.page import notes, verdict
from graspdsl.report.run_tables import outcomes_table
from graspdsl.report.summary import Summary
from graspdsl.report.templating import rendered

BRIEF = 4  # columns


def cell(evidence: Evidence, summary: Summary) -> str:
    """The HTML of a cell: a part of any page, on light or dark ground, that needs nothing else of it.

    Its figure is a picture by itself, so that the ids of two cells do not meet.
    """
    funnel = funnel_of(evidence, summary)
    return rendered(
        "notebook.html",
        summary=summary,
        verdict=verdict(summary),
        notes=notes(evidence, summary),
        outcomes=outcomes_table(summary).first(BRIEF),
        place=_place,
        funnel=_address(drawn_funnel(funnel).file) if funnel else "",
    )


def _address(svg: str) -> str:
    return f"data:image/svg+xml;base64,{base64.b64encode(svg.encode('utf-8')).decode('ascii')}"


def _place(words: bool) -> str:
    side = "left" if words else "right"
    return f"text-align: {side}; padding: 0.15em 1.2em 0.15em 0; border-bottom: 1px solid rgba(128, 128, 128, 0.4)"
