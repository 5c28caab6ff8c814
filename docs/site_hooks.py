"""What the site has beyond its pages: the code that they link to, formulas as MathML, the names of files over blocks.

mkdocs calls the functions here by their names.
"""

from __future__ import annotations

import ast
import html
import posixpath
import re
from pathlib import Path, PurePosixPath
from typing import Any

from latex2mathml.converter import convert
from mkdocs.structure.files import File, Files

PAGES = Path(__file__).resolve().parent
# Where the folders of the repository are, beside the pages: in it, and in an installed package.
ROOTS = (PAGES.parent, PAGES.parent.parent)
# A link to a file: its label, and where it leads from the folder of the page.
LINK = re.compile(r"\[([^]\n]+)\]\(([^):#\s]+)\)")
OF_THE_SITE = (".md", ".png", ".svg")
FILE = re.compile(r"^<!-- (?:spec|code): (\S+) -->\n```(\w+)$", flags=re.M)
ROW = re.compile(r"^\|.*$", flags=re.M)
CODE = re.compile(r"`[^`]+`")
MATH = re.compile(r'<div class="arithmatex">\\\[(.*?)\\\]</div>', flags=re.S)
LANGUAGES = {".py": "python", ".yaml": "yaml", ".urdf": "xml", ".xml": "xml", ".md": "markdown", ".html": "html"}
SOURCE = """---
search: {{exclude: true}}
hide: [toc]
---

# `{name}`

~~~~~~~~{language} linenums="1"
{text}
~~~~~~~~
"""


def on_files(files: Files, config: Any) -> Files:
    """A page for each file of the code that some page links to."""
    pages = [(file.src_uri, file.content_string) for file in files.documentation_pages()]
    names = {_name(page, target) for page, text in pages for _, target in LINK.findall(text)}
    for name in sorted(names):
        place = _place(name)
        if place is not None and not _is_of_the_site(name):
            language = LANGUAGES.get(place.suffix, "text")
            text = SOURCE.format(name=name, language=language, text=place.read_text("utf-8").rstrip("\n"))
            files.append(File.generated(config, _page(name), content=text))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Files) -> str:
    """Links to code lead to its page, at what a label names; blocks have the names of their files."""
    del config, files
    own = page.file.src_uri

    def led(link: re.Match[str]) -> str:
        label, name = link[1], _name(own, link[2])
        if _is_of_the_site(name):
            return link[0]
        place = _place(name)
        if place is None:  # not installed with the package
            return label
        line = line_of(place, label.strip("`"))
        there = posixpath.relpath(_page(name), posixpath.dirname(own) or ".")
        return f"[{label}]({there}{f'#__codelineno-0-{line}' if line else ''})"

    if own.startswith("source/"):
        return markdown
    # Only where Markdown is drawn by others do bars in the code of a table need a backslash, which would be shown here.
    rows = ROW.sub(lambda row: CODE.sub(lambda code: code[0].replace(r"\|", "|"), row[0]), markdown)
    return FILE.sub(r'```\2 title="\1"', LINK.sub(led, rows))


def on_page_content(content: str, page: Any, config: Any, files: Files) -> str:
    """Formulas, which Markdown leaves as LaTeX, in MathML: browsers draw it without a script."""
    del page, config, files
    return MATH.sub(lambda formula: convert(html.unescape(formula[1].strip()), display="block"), content)


def line_of(place: Path, name: str) -> int:
    """The line on which a module defines a class, a function, a method or a table; 0 where it does not."""
    if place.suffix != ".py":
        return 0
    scope: ast.AST | None = ast.parse(place.read_text("utf-8"))
    for part in name.split("."):
        scope = next((node for node in ast.iter_child_nodes(scope) if part in _names(node)), None) if scope else None
    return getattr(scope, "lineno", 0)


def _names(node: ast.AST) -> list[str]:
    match node:
        case ast.ClassDef(name=name) | ast.FunctionDef(name=name):
            return [name]
        case ast.Assign(targets=targets):
            return [target.id for target in targets if isinstance(target, ast.Name)]
        case ast.AnnAssign(target=ast.Name(id=name)):
            return [name]
    return []


def _is_of_the_site(name: str) -> bool:
    return name.startswith("docs/") and name.endswith(OF_THE_SITE)


def _name(page: str, target: str) -> str:
    """The path from the root of the repository to what a page links to."""
    return posixpath.normpath(PurePosixPath("docs") / PurePosixPath(page).parent / target)


def _place(name: str) -> Path | None:
    """The file of that path, if it is there; those of the pages are where these are."""
    inside = name.removeprefix("docs/")
    places = [PAGES / inside] if inside != name else [root / name for root in ROOTS]
    return next((place for place in places if place.is_file()), None)


def _page(name: str) -> str:
    return f"source/{name}.md"
