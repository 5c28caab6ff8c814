"""The words of a command line: text, or refused before anything is done with them."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup

from graspdsl.cli.inputs import answering
from graspdsl.diagnostics import Diagnostic, DiagnosticError


class Commands(TyperGroup):
    """The commands, of which every word is UTF-8: names of files go into manifests, pages and JSON."""

    def make_context(self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any) -> Any:
        """As any group's; ends with a complaint about the first word that is no text."""
        with answering(as_json="--json" in args):
            for word in args:
                if not _is_text(word):
                    fault = Diagnostic("not-utf8", "this name is not UTF-8 text", hint="give it another name")
                    raise DiagnosticError([fault], word)
        return super().make_context(info_name, args, parent, **extra)


class Beginnings(Commands):
    """Commands of which the ``usual`` one need not be named."""

    usual = "spec"

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """As any group's; the usual command's name comes before what is no command and no call for help."""
        known = args and (args[0] in self.commands or args[0] in ctx.help_option_names)
        return super().parse_args(ctx, args if known else [self.usual, *args])


def _is_text(word: str) -> bool:
    try:
        word.encode("utf-8")
    except UnicodeEncodeError:  # a byte of the name of a file, kept as half of a character
        return False
    return True
