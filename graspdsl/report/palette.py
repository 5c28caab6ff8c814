"""The colours of figures and page, on light and on dark ground.

Hues are those of Okabe and Ito, told apart with every kind of colour vision, made darker on light ground and lighter on
dark: all that is text or a line has a contrast of at least 4.5 with the ground (WCAG AA for text).
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

LIGHT: Mapping[str, str] = MappingProxyType(
    {
        "ground": "#ffffff",
        "panel": "#f5f6f8",
        "ink": "#1b1f24",
        "muted": "#565f69",
        "faint": "#d5dae0",
        "link": "#00598c",
        "before": "#6b7580",
        "series-1": "#0072b2",
        "series-2": "#c45200",
        "series-3": "#00805d",
        "series-4": "#ab5286",
        "series-5": "#9a6a00",
        "series-6": "#2479ab",
    }
)
DARK: Mapping[str, str] = MappingProxyType(
    {
        "ground": "#14181d",
        "panel": "#1c2229",
        "ink": "#e8ebee",
        "muted": "#a4adb7",
        "faint": "#38414b",
        "link": "#7cc4ee",
        "before": "#98a2ad",
        "series-1": "#56b4e9",
        "series-2": "#ff8c42",
        "series-3": "#2fc496",
        "series-4": "#df8fbf",
        "series-5": "#e6b422",
        "series-6": "#a9d4f2",
    }
)
SERIES = tuple(name for name in LIGHT if name.startswith("series-"))


def series(index: int) -> str:
    """The name of the colour of a mode; after the last comes the first again."""
    return SERIES[index % len(SERIES)]


def stylesheet() -> str:
    """Both sets of colours as CSS variables; dark where the reader's system is, light on paper."""
    light, dark = _variables(LIGHT), _variables(DARK)
    in_the_dark = f"@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}"
    return f":root {{ color-scheme: light dark; {light} }}\n{in_the_dark}\n"


def _variables(colours: Mapping[str, str]) -> str:
    return " ".join(f"--{name}: {colour};" for name, colour in colours.items())
