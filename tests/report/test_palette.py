"""Colours that can be read, and told apart."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from graspdsl.report.palette import DARK, LIGHT, SERIES

AA_TEXT = 4.5  # WCAG 2, contrast of text


def contrast(one: str, other: str) -> float:
    """The contrast of two colours by WCAG 2."""
    darker, lighter = sorted(map(_luminance, (one, other)))
    return (lighter + 0.05) / (darker + 0.05)


def _luminance(colour: str) -> float:
    shares = [channel / 255 for channel in bytes.fromhex(colour.lstrip("#"))]
    linear = [share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4 for share in shares]
    return sum(weight * value for weight, value in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


@pytest.mark.parametrize("colours", [LIGHT, DARK], ids=["light", "dark"])
def test_text_has_the_contrast_that_text_needs(colours: Mapping[str, str]) -> None:
    """Also the names of modes, in the colours of their series."""
    for name in ("ink", "muted", "link", "before", *SERIES):
        assert contrast(colours[name], colours["ground"]) >= AA_TEXT, name
    for name in ("ink", "muted", "link"):
        assert contrast(colours[name], colours["panel"]) >= AA_TEXT, name


def test_black_on_white_has_the_contrast_it_has_by_definition() -> None:
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
