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


@pytest.mark.parametrize(("colour", "published"), [("#767676", 4.54), ("#777777", 4.48), ("#0000ff", 8.59)])
def test_contrasts_with_white_are_those_that_others_publish(colour: str, published: float) -> None:
    """Of the lightest grey that passes, of the next that does not, and of blue: WebAIM's contrast checker."""
    assert contrast(colour, "#ffffff") == pytest.approx(published, abs=0.005)
