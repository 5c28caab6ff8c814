"""Every page: its blocks do what they say, its links lead somewhere, and all of them make a site."""

from __future__ import annotations

import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

from .pages import DOCS, PAGES, ROOT, blocks_of, run_page

HOOKS = runpy.run_path(str(DOCS / "site_hooks.py"))
OF_FILES = {"file", "project", "offers", "table"}  # of contracts, held against the files by a test of their own
WITH_TESTS_OF_THEIR_OWN = {*(page for page in PAGES if page.startswith("contracts/")), "reference/diagnostics.md"}
EACH_PAGE = pytest.mark.parametrize("page", PAGES)


@pytest.mark.slow
@pytest.mark.parametrize("page", sorted({*PAGES} - WITH_TESTS_OF_THEIR_OWN))
def test_blocks_do_what_they_say(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "specs").symlink_to(ROOT / "specs")
    monkeypatch.chdir(tmp_path)
    run_page(PAGES[page], tmp_path)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("```python\n1 + 1  # → 3\n```\n", "1 . 1"),
        ("```python\nprint(2)\n```\n\n```text\n3\n```\n", "3"),
        ("```sh\ngraspdsl validate no.yaml\n```\n", "no.yaml"),
        ("```sh\ngraspdsl list hands\n```\n\n```text\na hand that nobody has\n```\n", "a hand that nobody has"),
        ("<!-- fails -->\n```sh\ngraspdsl list hands\n```\n", "barrett"),
        ("<!-- shown: it takes long -->\n```sh\ngraspdsl run --no-such-option\n```\n", "No such option"),
        ("```sh\nmake tea\n```\n", "nothing here is run"),
        ("```sh\ngraspdsl list hands\n", "not read"),
    ],
)
def test_a_block_that_does_not_is_found(text: str, what: str, tmp_path: Path) -> None:
    with pytest.raises(Exception, match=what):
        run_page(text, tmp_path)


@EACH_PAGE
def test_every_block_is_read(page: str) -> None:
    marks = {block.mark for block in blocks_of(PAGES[page])}
    assert marks <= {"", "spec", "code", "fails", "shown", *OF_FILES}


@EACH_PAGE
def test_links_lead_somewhere(page: str) -> None:
    """To files; a label that names a class or function, to the module that defines it; to headings of pages."""
    for label, link in re.findall(r"\[([^]\n]+)\]\(([^):\s]+)\)", re.sub(r"```.*?```", "", PAGES[page], flags=re.S)):
        target, _, heading = link.partition("#")
        place = (DOCS / page).parent / target if target else DOCS / page
        assert place.is_file(), link
        name = re.fullmatch(r"`([A-Za-z_][\w.]*)`", label)
        if place.suffix == ".py" and name is not None and name[1] not in (place.name, target):
            assert HOOKS["line_of"](place, name[1]), f"{name[1]} is not in {target}"
        headings = re.findall(r"^#+ (.*)$", place.read_text("utf-8"), flags=re.M) if heading else []
        assert not heading or heading in [
            re.sub(r"[^\w\s-]", "", said).strip().lower().replace(" ", "-") for said in headings
        ]


@pytest.mark.slow
def test_they_make_a_site(tmp_path: Path) -> None:
    """Of which nothing is fetched from elsewhere, in which all formulas are MathML, and code is a link away."""
    surroundings = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, env=surroundings, capture_output=True, encoding="utf-8", check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    pages = {path: path.read_text("utf-8") for path in tmp_path.rglob("*.html")}
    assert {path.relative_to(tmp_path).as_posix() for path in pages} >= {
        page.replace("README.md", "index.md").replace(".md", ".html") for page in PAGES
    }
    fetched = re.compile(r'(?:<script[^>]* src|<img[^>]* src|<link[^>]* href|@import url)[=(]"?(https?:|//)')
    assert [path for path, text in pages.items() if fetched.search(text)] == []
    chapter = pages[tmp_path / "chapter.html"]
    assert chapter.count("<math") == PAGES["chapter.md"].count("$$") // 2
    assert "arithmatex" not in chapter
    assert [path for path, text in pages.items() if re.search(r"<td><code>[^<]*\\\|", text)] == []
    assert "<code>π_close|Γ Γ</code>" in pages[tmp_path / "reference" / "grammar.html"]
    for link, line in re.findall(r'href="(source/[^"#]*)#(__codelineno-0-\d+)"', chapter):
        assert f'"{line}"' in pages[tmp_path / link]


def test_the_picture_of_the_rooms_is_of_the_imports_that_there_are() -> None:
    """Run docs/render_design.py where it is not."""
    made = runpy.run_path(str(DOCS / "render_design.py"))
    assert made["PICTURE"].read_text("utf-8") == made["picture"]()
