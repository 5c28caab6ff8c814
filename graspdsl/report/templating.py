"""Pages from templates: every text that goes into one is escaped."""

from __future__ import annotations

import re

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from graspdsl.report.palette import stylesheet


def rendered(template: str, **values: object) -> str:
    """A page from a template: one file that needs no other."""
    environment = Environment(
        loader=PackageLoader("graspdsl.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["notation"] = notation
    return environment.get_template(template).render(stylesheet=Markup(stylesheet()), **values)


def notation(text: str) -> Markup:
    """Text as HTML, with the indices of the notation lowered, ρ_f, ε_mr, φ_fr, and numbers kept beside their units."""
    whole = re.sub(r"(?<=\d) (?=%|(?:rad|mm|s|N|Hz)\b)|(?<=[≤≥]) (?=\d)", "\N{NO-BREAK SPACE}", str(escape(text)))
    return Markup(re.sub(r"([ρεφτσπ])_(\w+)", r"\1<sub>\2</sub>", whole))
