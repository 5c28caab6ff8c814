"""The pages of the documentation: as a site, where mkdocs is installed, else where they lie."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
import webbrowser
from pathlib import Path

import yaml

import graspdsl
from graspdsl.cli.messages import result, say
from graspdsl.diagnostics import Diagnostic, DiagnosticError

NEEDED = ("mkdocs", "material", "latex2mathml")


def show_documentation(out: Path | None, *, path: bool) -> None:
    """Make a site of the pages, in a folder or else in a temporary one, say its address, and open it if there is a
    display. ``path``: only say where the pages lie."""
    pages = _pages()
    if out is not None and out.is_dir() and any(out.iterdir()):
        hint = "name another, which may be a new one"
        raise DiagnosticError([Diagnostic("folder-not-empty", "this folder is not empty", hint=hint)], str(out))
    if path:
        result(str(pages))
    elif not all(importlib.util.find_spec(name) for name in NEEDED):
        say("the pages are Markdown, in the folder below; pip install 'graspdsl[docs]' and this makes a site of them")
        result(str(pages))
    else:
        page = _site(pages, out or Path(tempfile.mkdtemp(prefix="graspdsl-docs-"))) / "index.html"
        result(page.as_uri())
        if not sys.platform.startswith("linux") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
            webbrowser.open(page.as_uri())


def _pages() -> Path:
    """Where they are installed: in the package, or beside it in the repository that is installed in place."""
    package = Path(graspdsl.__file__).parent
    return next(place for place in (package / "docs", package.parent / "docs") if (place / "site.yml").is_file())


def _site(pages: Path, out: Path) -> Path:
    site = out.resolve()
    with tempfile.TemporaryDirectory() as place:
        settings = Path(place) / "mkdocs.yml"
        made = {"docs_dir": str(pages), "site_dir": str(site), "hooks": [str(pages / "site_hooks.py")]}
        settings.write_text(yaml.safe_dump({"INHERIT": str(pages / "site.yml"), **made}), "utf-8")
        done = subprocess.run(
            [sys.executable, "-P", "-m", "mkdocs", "build", "--quiet", "--config-file", str(settings)],
            env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
            capture_output=True,
            encoding="utf-8",
            check=False,
        )
    if done.returncode:
        last = (done.stderr.strip() or done.stdout.strip()).splitlines()[-1:]
        message = f"mkdocs cannot make the site: {''.join(last)}"
        raise DiagnosticError(
            [Diagnostic("site-not-made", message, hint="graspdsl docs --path says where its pages lie")]
        )
    return site
