"""The pages of the contracts: what they show of files is what the files have, and what else they show runs."""

from __future__ import annotations

import re
import runpy
import tomllib
from pathlib import Path

import pytest

from graspdsl.contracts.kinds import CONTRACTS

from .pages import PAGES as ALL_PAGES
from .pages import ROOT, run_page

PAGES = {Path(page).stem: text for page, text in ALL_PAGES.items() if page.startswith("contracts/")}
STRANGER = ROOT / "tests" / "plugin"
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


@pytest.fixture(scope="module")
def sites(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Where the stranger's package is installed, as an installer notes it."""
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
    run_page(PAGES[page], tmp_path, sites)
