"""The pages of the contracts: what they show of files is what the files have, and what else they show runs."""

from __future__ import annotations

import re
import runpy
import shlex
import tomllib
from pathlib import Path

import pytest
from cli.program import TIMEOUT

from cli import warm
from graspdsl.contracts.kinds import CONTRACTS

ROOT = Path(__file__).resolve().parents[2]
PAGES = {path.stem: path.read_text("utf-8") for path in sorted((ROOT / "docs" / "contracts").glob("*.md"))}
STRANGER = ROOT / "tests" / "plugin"
# Of a block: what a comment says of it, its language, its text.
BLOCK = re.compile(r"(?:<!-- (\w+): (\S+) -->\n)?^```(\w+)\n(.*?)^```$", flags=re.S | re.M)
EACH_PAGE = pytest.mark.parametrize("page", PAGES)
OF_KINDS = [page for page in PAGES if page != "README"]
EACH_KIND = pytest.mark.parametrize("page", OF_KINDS)


def kind_of(page: str) -> str:
    """The kind that a page is about."""
    [kind] = [kind for kind in CONTRACTS if kind in (page, f"{page}s")]
    return kind


def test_each_kind_has_a_page() -> None:
    assert sorted(map(kind_of, OF_KINDS)) == sorted(CONTRACTS)


def test_the_index_leads_to_each() -> None:
    rows = re.findall(r"^\| \[[^]]*\]\((\w+)\.md\) \| `graspdsl\.(\w+)` \|", PAGES["README"], flags=re.M)
    assert [(page, kind_of(page)) for page in OF_KINDS] == sorted(rows)
    assert [kind for _, kind in rows] == [*CONTRACTS]


@EACH_PAGE
def test_links_lead_somewhere(page: str) -> None:
    links = re.findall(r"\]\(([^)#]+)[^)]*\)", PAGES[page])
    assert [link for link in links if not (ROOT / "docs" / "contracts" / link).exists()] == []


@EACH_PAGE
def test_what_is_of_files_is_what_they_have(page: str) -> None:
    """Run docs/render_contracts.py where it is not."""
    rendered = runpy.run_path(str(ROOT / "docs" / "render_contracts.py"))["rendered"]
    assert rendered(PAGES[page]) == PAGES[page]


@EACH_KIND
def test_a_page_has_an_example_its_entry_points_and_its_rules(page: str) -> None:
    kind, text = kind_of(page), PAGES[page]
    assert re.search(r"^<!-- file: \S+ -->$", text, flags=re.M)
    assert f"<!-- offers: {kind} -->\n" in text
    assert f"<!-- rules: {kind} -->\n" in text
    assert all(f"| `{code}` |" in text for code in CONTRACTS[kind])


@EACH_PAGE
def test_every_block_is_checked(page: str) -> None:
    """A block is of a file, or a spec or its code, or commands that run."""
    blocks = BLOCK.findall(PAGES[page])
    assert PAGES[page].count("```") == 2 * len(blocks)
    assert {mark or language for mark, _, language, _ in blocks} <= {"file", "project", "offers", "spec", "code", "sh"}


@pytest.fixture(scope="module")
def sites(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Where the stranger's package is installed, as an installer notes it, and where it is."""
    project = tomllib.loads((STRANGER / "pyproject.toml").read_text("utf-8"))["project"]
    name, version = project["name"], project["version"]
    site = tmp_path_factory.mktemp("site")
    noted = site / f"{name.replace('-', '_')}-{version}.dist-info"
    noted.mkdir()
    (noted / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n", "utf-8")
    lines = [
        line
        for group, entries in project["entry-points"].items()
        for line in (f"[{group}]", *(f"{entry} = {value}" for entry, value in entries.items()))
    ]
    (noted / "entry_points.txt").write_text("\n".join(lines), "utf-8")
    return [site, STRANGER / "src"]


@pytest.mark.slow
@EACH_PAGE
def test_commands_run(page: str, sites: list[Path], tmp_path: Path) -> None:
    """In their order, in a folder with the specs of the page; they have something to say and nothing to complain of."""
    blocks = BLOCK.findall(PAGES[page])
    for mark, name, _, text in blocks:
        if mark in ("spec", "code"):
            (tmp_path / name).write_text(text, "utf-8")
    commands = [line for _, _, language, text in blocks if language == "sh" for line in text.splitlines()]
    assert commands
    for command in commands:
        words = shlex.split(command)
        assert words[0] == "graspdsl"
        done = warm.run(words[1:], tmp_path, TIMEOUT, *sites)
        assert done.returncode == 0, done.stdout + done.stderr
        assert done.stdout
        assert not re.search(r"^\S+: (error|warning)\[", done.stdout + done.stderr, flags=re.M), done.stderr
