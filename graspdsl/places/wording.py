"""How values from a file are named in a message: short, and unable to steer a terminal."""

from __future__ import annotations

import math
import re

Data = None | bool | int | float | str | list["Data"] | dict[str, "Data"]

_BLANKS = re.compile("[ \t\n]+")  # those of other kinds are to be seen


def shortened(text: str, width: int = 60) -> str:
    """The text on one line, cut to ``width`` characters."""
    text = _BLANKS.sub(" ", text).strip(" ")
    return text if len(text) <= width else text[: width - 1] + "…"


def slug(text: str) -> str:
    """A text as a name that a file may have, of letters, digits, '-', '_' and '.'; empty where none is left."""
    return re.sub(r"[^\w.-]+", "-", text).strip("-_.")[:60].rstrip("-_.")


def shown(value: object) -> str:
    """What a value is, in words: ``the text 'abc'``, ``a mapping``, ``nothing``."""
    if value is None:
        return "nothing"
    if isinstance(value, str):
        return f"the text {shortened(value)!r}"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list | tuple):
        return "a list"
    return as_yaml(value)


def as_yaml(value: object) -> str:
    """A scalar as YAML writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        if math.isnan(value):
            return ".nan"
        if math.isinf(value):
            return ".inf" if value > 0 else "-.inf"
        return f"{value:g}" if float(f"{value:g}") == value else repr(value)
    return str(value)


def quoted(text: str) -> str:
    """The text as a quoted YAML scalar on one line."""
    text = " ".join(text.split())
    if '"' in text or "\\" in text:
        return "'" + text.replace("'", "''") + "'"
    return f'"{text}"'
