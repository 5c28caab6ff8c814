"""A run as the output of a notebook's cell."""

from __future__ import annotations

import base64
import re
from dataclasses import replace
from xml.etree import ElementTree

from graspdsl.report.evidence import Evidence
from graspdsl.report.notebook import cell
from graspdsl.report.summary import summarised
from report.hand_made import HandMade, evidence


def _cell(made: Evidence, **changed: str) -> str:
    return cell(made, replace(summarised(made), **changed))


def _pictures(html: str) -> list[bytes]:
    return [base64.b64decode(found) for found in re.findall(r'src="data:image/svg\+xml;base64,([^"]*)"', html)]


def test_it_says_whether_it_worked_and_shows_the_funnel() -> None:
    html = _cell(evidence(1, [HandMade(), HandMade(), HandMade(ticks=None)]))
    assert "2 of 3 trials converged" in html
    assert re.search(r"<td[^>]*>timeout</td>\s*<td[^>]*>1</td>", html)
    [picture] = _pictures(html)
    assert ElementTree.fromstring(picture).tag.endswith("svg")


def test_it_is_a_part_of_any_page() -> None:
    """One well-formed element, with nothing that reaches beyond it: no style sheet, no script, no ids."""
    html = _cell(evidence(1, [HandMade()]))
    whole = ElementTree.fromstring(re.sub(r"(<img [^>]*)>", r"\1/>", html.strip()))
    assert whole.tag == "div"
    assert {part.tag for part in whole.iter()} & {"style", "script", "link"} == set()
    assert not any("id" in part.attrib for part in whole.iter())


def test_a_run_without_orientations_has_no_funnel() -> None:
    nothing = float("nan")
    html = _cell(evidence(1, [HandMade(start=nothing, end=nothing)]))
    assert _pictures(html) == []
    assert _pictures(_cell(evidence(1, []))) == []


def test_what_it_is_told_is_escaped() -> None:
    html = _cell(evidence(1, [HandMade()]), name="<script>x</script>", run="<b>&")
    assert "<script>" not in html
    assert "&lt;script&gt;x&lt;/script&gt;" in html
    assert "&lt;b&gt;&amp;" in html
