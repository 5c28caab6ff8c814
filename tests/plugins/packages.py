"""Packages of strangers, as an installer leaves them on disk."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

HUBER = '''
from graspdsl.basis.potentials import ForceResidual


class Huber(ForceResidual):
    """φ_h: another force residual."""

    symbol = "φ_h"
    about = "another force residual"
    normal_to = ()
'''
PHI = {"potentials": {"phi_h": "kit:Huber"}}


def installed(
    site: Path,
    module: str | None = HUBER,
    offers: Mapping[str, Mapping[str, str]] = PHI,
    *,
    name: str = "kit",
    version: str = "1.0",
    data: Mapping[str, str] | None = None,
) -> None:
    """A distribution: its module of this text and its data, beside it what the installer notes."""
    noted = site / f"{name}-{version}.dist-info"
    noted.mkdir(parents=True)
    (noted / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n", "utf-8")
    lines = [
        line
        for group, entries in offers.items()
        for line in (f"[graspdsl.{group}]", *(f"{entry} = {value}" for entry, value in entries.items()))
    ]
    (noted / "entry_points.txt").write_text("\n".join(lines), "utf-8")
    package = site / name
    package.mkdir()
    if module is not None:
        (package / "__init__.py").write_text(module, "utf-8")
    for file, text in (data or {}).items():
        (package / file).parent.mkdir(exist_ok=True)
        (package / file).write_text(text, "utf-8")
