"""Draw the rooms of the house and which of them import which, from the imports themselves.

Run it anywhere: python docs/render_design.py
"""

from __future__ import annotations

import ast
import html
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
PICTURE = ROOT / "docs" / "images" / "design.svg"
WIDTH, ROW, LEFT, BOX, HEIGHT = 900, 34, 190, 96, 26
LETTERS = 100  # of a line beside a room
COLOURS = {"box": "#f5f6f8", "edge": "#565f69", "ink": "#1b1f24", "arrow": "#0072b2"}


def imported(room: Path) -> set[str]:
    """The rooms that the modules of one import, at their top or later."""
    modules = sorted(room.rglob("*.py")) if room.is_dir() else [room]
    return {name for module in modules for name in _names(ast.parse(module.read_text("utf-8")))}


def _names(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        names = [node.module] if isinstance(node, ast.ImportFrom) and node.module else []
        names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        yield from (name.split(".")[1] for name in names if name.startswith("graspdsl."))


def rooms() -> dict[str, Path]:
    """Each package, and each module that stands alone."""
    found = [*sorted((ROOT / "graspdsl").iterdir()), ROOT / "cli"]
    packages = {path.stem: path for path in found if (path / "__init__.py").exists() or path.suffix == ".py"}
    return {name: path for name, path in packages.items() if name != "__init__"}


def about(name: str, room: Path) -> str:
    """What a room knows: of a package as CONTRIBUTING.md has it, of a module the first line of what it says itself."""
    if room.is_dir():
        [line] = re.findall(rf"^\| `{name}/` \| (.*) \|$", CONTRIBUTING, flags=re.M)
    else:
        line = (ast.get_docstring(ast.parse(room.read_text("utf-8"))) or "").partition("\n")[0]
    return str(line).replace("`", "")


def direct(graph: Mapping[str, set[str]]) -> dict[str, set[str]]:
    """The imports that no longer way stands for."""

    def reached(name: str) -> set[str]:
        return {name}.union(*(reached(other) for other in graph[name]))

    return {
        name: {one for one in below if not any(one in reached(other) for other in below - {one})}
        for name, below in graph.items()
    }


def levels(graph: Mapping[str, set[str]]) -> dict[str, int]:
    """How many rooms stand beneath one, in the longest way down."""

    def level(name: str) -> int:
        return 1 + max(map(level, graph[name]), default=-1)

    return {name: level(name) for name in graph}


def picture() -> str:
    """The rooms, one above the other, each over all that it imports; an arc leads from a room down to one of these."""
    known = rooms()
    graph = {name: (imported(path) & {*known}) - {name} for name, path in known.items()}
    level = levels(graph)
    order = sorted(known, key=lambda name: (-level[name], name))
    places = {name: 24 + ROW * place for place, name in enumerate(order)}
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {20 + ROW * len(order)}" '
        'font-family="sans-serif" font-size="13">',
        '<marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        f'<path d="M0 0L8 4L0 8z" fill="{COLOURS["arrow"]}"/></marker>',
    ]
    for name, below in direct(graph).items():
        for other in sorted(below, key=order.index):
            far = LEFT - 16 - 9 * (order.index(other) - order.index(name))
            start, end = places[name] + 5, places[other] - 5
            path = f"M{LEFT} {start}C{far} {start} {far} {end} {LEFT} {end}"
            lines.append(f'<path d="{path}" fill="none" stroke="{COLOURS["arrow"]}" marker-end="url(#tip)"/>')
    for name, y in places.items():
        lines.append(
            f'<rect x="{LEFT}" y="{y - HEIGHT // 2}" width="{BOX}" height="{HEIGHT}" rx="5" '
            f'fill="{COLOURS["box"]}" stroke="{COLOURS["edge"]}"/>'
            f'<text x="{LEFT + BOX // 2}" y="{y + 5}" fill="{COLOURS["ink"]}" text-anchor="middle">{name}</text>'
            f'<text x="{LEFT + BOX + 12}" y="{y + 5}" fill="{COLOURS["edge"]}" font-size="12">'
            f"{html.escape(shortened(about(name, known[name])))}</text>"
        )
    return "\n".join([*lines, "</svg>", ""])


def shortened(line: str) -> str:
    """As much of a line as a row has room for."""
    return line if len(line) <= LETTERS else line[:LETTERS].rpartition(" ")[0] + " …"


if __name__ == "__main__":
    PICTURE.write_text(picture(), "utf-8")
