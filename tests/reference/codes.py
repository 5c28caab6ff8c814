"""The codes of all diagnostics that the source can raise, found where it gives them.

A code is given to a function or a class that has a parameter or a field ``code``, stands in a variable of that name, or
is what a function ``_code`` returns.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
CODE = "code"
A_CODE = re.compile(r"[a-z0-9]+(-[a-z0-9]+)+")
OF_ONE_WORD = {"tab", "tendon", "undrawn", "weighed"}
NO_CODES = {"utf-8"}
ANY_WORD = "[a-z-]+"  # what stands in the gap of an f-string


@cache
def _nodes() -> tuple[ast.AST, ...]:
    """The nodes of every module of the program that can say anything of codes."""
    kinds = ast.Call | ast.Assign | ast.FunctionDef | ast.ClassDef
    files = sorted([*(ROOT / "graspdsl").rglob("*.py"), *(ROOT / "cli").rglob("*.py")])
    trees = (ast.parse(file.read_text(encoding="utf-8")) for file in files)
    return tuple(node for tree in trees for node in ast.walk(tree) if isinstance(node, kinds))


def _takers() -> Iterator[str]:
    """The names of what takes a code."""
    for node in _nodes():
        if isinstance(node, ast.FunctionDef) and CODE in {argument.arg for argument in node.args.args}:
            yield node.name
        if isinstance(node, ast.ClassDef) and any(_name(getattr(field, "target", node)) == CODE for field in node.body):
            yield node.name


def _name(node: ast.AST) -> str:
    return str(getattr(node, "attr", getattr(node, "id", "")))


def _given() -> Iterator[ast.expr]:
    """The expressions among which the codes are."""
    takers = {*_takers()}
    for node in _nodes():
        if isinstance(node, ast.Call):
            yield from node.args if _name(node.func) in takers else ()
            yield from (word.value for word in node.keywords if word.arg in (CODE, "custom_error_type"))
        elif isinstance(node, ast.Assign):
            targets = [each for target in node.targets for each in getattr(target, "elts", [target])]
            if CODE in map(_name, targets):
                yield from node.value.elts if isinstance(node.value, ast.Tuple) else (node.value,)
        elif isinstance(node, ast.FunctionDef) and node.name == f"_{CODE}":
            yield from (each.value for each in ast.walk(node) if isinstance(each, ast.Return) and each.value)


def _constants() -> dict[str, ast.expr]:
    """The texts that have a name, by it."""
    return {
        _name(target): node.value
        for node in _nodes()
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
        for target in node.targets
        if _name(target).isupper()
    }


@cache
def patterns() -> frozenset[str]:
    """The codes that the source can raise; where it puts one together, a pattern."""
    constants = _constants()

    def codes(given: ast.expr) -> Iterator[str]:
        match given:
            case ast.Constant(str(text)) if (A_CODE.fullmatch(text) or text in OF_ONE_WORD) and text not in NO_CODES:
                yield text
            case ast.JoinedStr(values):
                texts = [str(v.value) if isinstance(v, ast.Constant) else "a" for v in values]
                if A_CODE.fullmatch("".join(texts)):
                    yield "".join(str(v.value) if isinstance(v, ast.Constant) else ANY_WORD for v in values)
            case ast.IfExp(_, body, otherwise):
                yield from (*codes(body), *codes(otherwise))
            case ast.Name(name) if name in constants:
                yield from codes(constants[name])

    return frozenset(code for given in _given() for code in codes(given))
