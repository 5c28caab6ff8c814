"""Pages as a browser takes them: their elements, links and texts."""

from __future__ import annotations

import re
from html import unescape
from html.parser import HTMLParser
from typing import Any

import numpy as np

VOID = {"meta", "img", "br", "path", "use", "rect", "circle", "line", "stop", "link"}


class Reader(HTMLParser):
    """Reads a page: what it refers to, its ids, and whether its elements close."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """An element begins."""
        self.ids += [value or "" for name, value in attrs if name == "id"]
        self.links += [value or "" for name, value in attrs if name in ("href", "src", "xlink:href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """An element without content."""
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        """An element ends."""
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        """Text."""
        self.text += data


def untold(page: str, document: Any) -> set[str]:
    """The numbers in the tables of a page that a JSON document does not have, rounded as there, in words or as such, in
    per cent or in thousandths."""
    told, found = np.abs(_numbers(document)), set[str]()
    for cell in re.findall(r"<td[^>]*>(.*?)</td>", page, flags=re.S):
        for word in re.findall(r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?", unescape(re.sub(r"<[^>]*>", "", cell))):
            digits, _, exponent = word.partition("e")
            last = 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2]))
            if not any((np.abs(scale * told - float(word)) < 0.501 * last).any() for scale in (1.0, 1e2, 1e3)):
                found.add(word)
    return found


def _numbers(part: Any) -> list[float]:
    if isinstance(part, dict | list):
        return [number for one in (part.values() if isinstance(part, dict) else part) for number in _numbers(one)]
    if isinstance(part, str):
        return [float(word) for word in re.findall(r"\d+(?:\.\d+)?", part)]
    return [] if part is None else [float(part)]
