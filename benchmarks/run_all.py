"""All benchmarks in one run, each row printed as it comes, and the table of them written to RESULTS.md.

``python benchmarks/run_all.py tick batch`` measures these alone and writes nothing.
"""

from __future__ import annotations

import importlib
import os
import platform
import sys
from collections.abc import Iterable, Iterator, Sequence
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path

from measuring import Row

HERE = Path(__file__).resolve().parent
SECTIONS = {
    "tick": "A tick of the controller",
    "batch": "Floating contacts side by side",
    "physics": "A trial against its physics",
    "workers": "Workers",
    "scaling": "How the cost grows",
    "start_up": "Start-up",
    "bullet_effort": "Bullet: effort against what comes out",
}
LIBRARIES = ("numpy", "scipy", "mujoco", "pybullet", "jax", "casadi", "mink", "pin-pink", "daqp", "pydantic", "typer")


def main(chosen: Sequence[str]) -> None:
    """Measure the sections that are named, or all of them."""
    tables = {}
    for name in chosen or SECTIONS:
        print(f"\n{SECTIONS[name]}", flush=True)
        tables[name] = list(printed(importlib.import_module(name).rows()))
        if not chosen:  # what has been measured is kept, whatever becomes of the rest
            (HERE / "RESULTS.md").write_text(page(tables), encoding="utf-8")


def printed(rows: Iterable[Row]) -> Iterator[Row]:
    """The same rows, each printed."""
    for row in rows:
        print("  " + "  ".join(filter(None, cells(row))), flush=True)
        yield row


def cells(row: Row) -> tuple[str, ...]:
    """A row of the table: what, ratio, bound, whether it holds, spread, note."""
    ratio = "not measured" if row.ratio is None else f"{row.ratio:.3g}"
    holds = {None: "", True: "yes", False: "no"}[row.holds]
    spread = "" if row.spread is None else f"{row.spread[0]:.3g} to {row.spread[1]:.3g}"
    return row.what, ratio, row.bound, holds, spread, row.note


def page(tables: dict[str, list[Row]]) -> str:
    """The text of RESULTS.md."""
    lines = [
        "# Results",
        "",
        "Written by `make bench`; [README.md](README.md) says what each row is. A ratio is the median over rounds in",
        "which both sides had their turn, a spread its quartiles.",
        "",
        *(f"- {line}" for line in machine()),
    ]
    for name, rows in tables.items():
        lines += ["", f"## {SECTIONS[name]}", "", "| what | ratio | bound | holds | spread | medians, notes |"]
        lines += ["|---|---|---|---|---|---|"]
        lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in cells(row)) + " |" for row in rows]
    left = [title for name, title in SECTIONS.items() if name not in tables]
    lines += ["", f"Not measured in this run: {'; '.join(left)}."] if left else []
    return "\n".join(lines) + "\n"


def machine() -> list[str]:
    """What it was measured on, and with."""
    model = platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        names = [
            line.partition(":")[2].strip() for line in information.read_text().splitlines() if "model name" in line
        ]
        model = names[0] if names else model
    busy = f", load {os.getloadavg()[0]:.1f} at the end" if hasattr(os, "getloadavg") else ""
    versions = []
    for library in LIBRARIES:
        try:
            versions.append(f"{library} {metadata.version(library)}")
        except metadata.PackageNotFoundError:
            versions.append(f"{library} not installed")
    return [
        f"{datetime.now(UTC):%Y-%m-%d}: {os.cpu_count()} cores of {model}{busy}",
        f"Python {platform.python_version()}, {', '.join(versions)}",
    ]


if __name__ == "__main__":
    main(sys.argv[1:])
