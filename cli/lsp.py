"""The language server: what an editor asks, over the Language Server Protocol on stdin and stdout.

What is answered is worked out by graspdsl.editor; here are the protocol, its positions and its threads.
"""

from __future__ import annotations

import asyncio
import logging
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import BinaryIO, ParamSpec, TypeVar

from lsprotocol import types
from pygls.exceptions import JsonRpcException
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path
from pygls.workspace import PositionCodec

import graspdsl
from graspdsl.cli.messages import say
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Fix, Severity, Span
from graspdsl.editor.completing import Proposal, proposals
from graspdsl.editor.finding import Symbol, outline, target_of
from graspdsl.editor.hovering import hover
from graspdsl.editor.judging import is_ours, judged
from graspdsl.editor.renaming import RenamingError, renamable, renamed
from graspdsl.places.files import folder_of_files, read_text, with_plain_line_ends
from graspdsl.spec.formatting import formatted

PAUSE = 0.05  # s without another change, before a text is judged
TRIGGERS = ["\\", "|", "(", "{", "<", ",", "_", " ", ":"]
_SEVERITIES = {
    Severity.ERROR: types.DiagnosticSeverity.Error,
    Severity.WARNING: types.DiagnosticSeverity.Warning,
}
_KINDS = {
    "key": types.CompletionItemKind.Property,
    "value": types.CompletionItemKind.Value,
    "name": types.CompletionItemKind.Function,
    "character": types.CompletionItemKind.Text,
}
_SYMBOLS = {
    "section": types.SymbolKind.Namespace,
    "resource": types.SymbolKind.Variable,
    "parameter": types.SymbolKind.Number,
    "controller": types.SymbolKind.Function,
    "phase": types.SymbolKind.Event,
}
P = ParamSpec("P")
T = TypeVar("T")
_START = Span(1, 1, 1, 1)  # of a complaint about the whole text


@dataclass(frozen=True)
class Page:
    """A text whose places are told in the units of the protocol: code units of UTF-16, or what the editor asked for."""

    text: str
    path: Path
    codec: PositionCodec

    @cached_property
    def rows(self) -> list[str]:
        """Its lines."""
        return self.text.split("\n")

    @property
    def folder(self) -> Path:
        """Where the files are that the text names."""
        return folder_of_files(self.path)

    def place(self, position: types.Position) -> tuple[int, int]:
        """The line and column, in characters from 1, of a position; the nearest of one outside of the text."""
        line = min(position.line, len(self.rows) - 1)
        row, units, column = self.rows[line], 0, 0
        while column < len(row) and units < position.character:
            units += self.codec.client_num_units(row[column])
            column += 1
        return line + 1, column + 1

    def range(self, span: Span) -> types.Range:
        """A span in the units of the protocol."""
        return types.Range(self._position(span.line, span.column), self._position(span.end_line, span.end_column))

    def _position(self, line: int, column: int) -> types.Position:
        row = self.rows[line - 1] if line <= len(self.rows) else ""
        return types.Position(line - 1, self.codec.client_num_units(row[: column - 1]))

    @property
    def whole(self) -> types.Range:
        """All of it."""
        end = types.Position(len(self.rows) - 1, self.codec.client_num_units(self.rows[-1]))
        return types.Range(types.Position(0, 0), end)

    def edit(self, fix: Fix) -> types.TextEdit:
        """An edit of the protocol."""
        return types.TextEdit(self.range(fix.span), fix.text)


@dataclass(frozen=True, slots=True)
class _Judgement:
    """The complaints about one state of a text."""

    page: Page
    found: tuple[Diagnostic, ...]


class Server(LanguageServer):
    """A language server for specs, hand and mount files; ``allow_code``: whether a spec's Python files are run."""

    def __init__(self, *, allow_code: bool = False) -> None:
        super().__init__("graspdsl", graspdsl.__version__, types.TextDocumentSyncKind.Full)
        self._allow_code = allow_code
        self._judges = ThreadPoolExecutor(1)  # one question after the other: the tables are shared
        self.open: set[str] = set()  # addresses as the editor writes them, which the workspace does not
        self._waiting: dict[str, asyncio.Task[None]] = {}
        self._wanted: dict[str, Page] = {}  # what of each text is to be judged, or has been
        self._judgements: dict[str, asyncio.Future[_Judgement]] = {}

    def page(self, uri: str) -> Page | None:
        """The text that is open under an address, if it is one for graspdsl; None for any other."""
        if uri not in self.open:
            return None
        text, place = with_plain_line_ends(self.workspace.get_text_document(uri).source), to_fs_path(uri)
        if text.strip() and not is_ours(text):
            return None
        return Page(text, Path(place) if place else Path("spec.yaml"), self.workspace.position_codec)

    async def answer(self, question: Callable[P, T], *about: P.args, **rest: P.kwargs) -> T:
        """The answer to a question about a text, when what was asked before has been answered."""
        return await asyncio.get_running_loop().run_in_executor(self._judges, partial(question, *about, **rest))

    def changed(self, uri: str, pause: float = PAUSE) -> None:
        """Judge the text under an address after a pause in which it does not change again."""
        before = self._waiting.pop(uri, None)
        if before is not None:
            before.cancel()
        self._waiting[uri] = asyncio.ensure_future(self._judge_after(uri, pause))

    def forget(self) -> None:
        """Judge all texts anew when they are judged next."""
        self._wanted.clear()

    def closed(self, uri: str) -> None:
        """Forget a text, and what was said of it."""
        self.open.discard(uri)
        waiting = self._waiting.pop(uri, None)
        if waiting is not None:
            waiting.cancel()
        self._wanted.pop(uri, None)
        self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, []))

    async def _judge_after(self, uri: str, pause: float) -> None:
        await asyncio.sleep(pause)
        judgement = await self.judgement(uri)
        if uri not in self.open:
            return
        found = [] if judgement is None else [_diagnostic(judgement.page, each) for each in judgement.found]
        self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, found))

    async def judgement(self, uri: str) -> _Judgement | None:
        """The complaints about the text under an address as it is now; what it was before is not judged any more."""
        page = self.page(uri)
        if page is None or not page.text.strip():
            self._wanted.pop(uri, None)
            return None
        if self._wanted.get(uri) != page:
            self._wanted[uri] = page
            self._judgements[uri] = asyncio.get_running_loop().run_in_executor(self._judges, self._judged, uri, page)
        return await asyncio.shield(self._judgements[uri])

    def _judged(self, uri: str, page: Page) -> _Judgement:
        if self._wanted.get(uri) is not page:
            return _Judgement(page, ())
        try:
            return _Judgement(page, judged(page.text, page.path, allow_code=self._allow_code))
        except Exception:  # a bug must not end the server: the editor keeps it in its log
            message = f"a bug:\n{traceback.format_exc()}"
            self.window_log_message(types.LogMessageParams(types.MessageType.Error, message))
            return _Judgement(page, ())


def _diagnostic(page: Page, complaint: Diagnostic) -> types.Diagnostic:
    return types.Diagnostic(
        page.range(complaint.span or _START),
        complaint.message + (f"\n{complaint.hint}" if complaint.hint else ""),
        severity=_SEVERITIES[complaint.severity],
        code=complaint.code,
        source="graspdsl",
    )


def _overlap(one: types.Range, other: types.Range) -> bool:
    def key(position: types.Position) -> tuple[int, int]:
        return position.line, position.character

    return key(one.start) <= key(other.end) and key(other.start) <= key(one.end)


def _actions(uri: str, judgement: _Judgement, asked: types.Range) -> Iterator[types.CodeAction]:
    page = judgement.page
    for complaint in judgement.found:
        shown = _diagnostic(page, complaint)
        if not _overlap(shown.range, asked):
            continue
        for fix in complaint.fixes:
            empty = fix.span == Span(fix.span.line, fix.span.column, fix.span.line, fix.span.column)
            title = f"add {fix.text.strip()}" if empty else f"write {fix.text}" if fix.text else "delete it"
            yield types.CodeAction(
                title,
                types.CodeActionKind.QuickFix,
                [shown],
                is_preferred=len(complaint.fixes) == 1,
                edit=types.WorkspaceEdit({uri: [page.edit(fix)]}),
            )


def _item(page: Page, rank: int, found: Proposal) -> types.CompletionItem:
    spelt = found.kind in ("name", "character")
    return types.CompletionItem(
        found.text,
        kind=_KINDS[found.kind],
        detail=found.detail or None,
        documentation=found.about or None,
        sort_text=f"{rank:04}",
        # What is written in ASCII or LaTeX is not what stands in the list: it is chosen here and not in the editor.
        filter_text=found.begun if spelt and found.begun else None,
        text_edit=types.TextEdit(page.range(found.span), found.text),
    )


def _symbol(page: Page, symbol: Symbol) -> types.DocumentSymbol:
    inside = [_symbol(page, inner) for inner in symbol.inside]
    return types.DocumentSymbol(
        symbol.name,
        _SYMBOLS[symbol.kind],
        page.range(symbol.span),
        page.range(symbol.key),
        detail=symbol.about or None,
        children=inside,
    )


def server(*, allow_code: bool = False) -> Server:
    """A server that answers what editors ask."""
    serving = Server(allow_code=allow_code)

    @serving.feature(types.TEXT_DOCUMENT_DID_OPEN)
    async def opened(params: types.DidOpenTextDocumentParams) -> None:
        serving.open.add(params.text_document.uri)
        serving.changed(params.text_document.uri, 0.0)

    @serving.feature(types.TEXT_DOCUMENT_DID_CHANGE)
    async def changed(params: types.DidChangeTextDocumentParams) -> None:
        serving.changed(params.text_document.uri)

    @serving.feature(types.TEXT_DOCUMENT_DID_SAVE)
    async def saved(_: types.DidSaveTextDocumentParams) -> None:
        serving.forget()  # files that other texts name may be others now
        for uri in serving.open:
            serving.changed(uri, 0.0)

    @serving.feature(types.TEXT_DOCUMENT_DID_CLOSE)
    async def closed(params: types.DidCloseTextDocumentParams) -> None:
        serving.closed(params.text_document.uri)

    @serving.feature(types.TEXT_DOCUMENT_HOVER)
    async def hovered(params: types.HoverParams) -> types.Hover | None:
        page = serving.page(params.text_document.uri)
        if page is None:
            return None
        found = await serving.answer(hover, page.text, page.place(params.position), page.folder)
        if found is None:
            return None
        said, span = found
        return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, said), page.range(span))

    @serving.feature(
        types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=TRIGGERS, resolve_provider=False)
    )
    async def completed(params: types.CompletionParams) -> types.CompletionList | None:
        page = serving.page(params.text_document.uri)
        if page is None:
            return None
        found = await serving.answer(proposals, page.text, page.place(params.position), page.folder)
        items = [_item(page, rank, each) for rank, each in enumerate(found)]
        return types.CompletionList(is_incomplete=True, items=items)

    @serving.feature(types.TEXT_DOCUMENT_DEFINITION)
    async def defined(params: types.DefinitionParams) -> types.Location | None:
        uri = params.text_document.uri
        page = serving.page(uri)
        if page is None:
            return None
        found = await serving.answer(target_of, page.text, page.place(params.position), page.folder)
        if found is None:
            return None
        if found.file is None:
            return types.Location(uri, page.range(found.span))
        there = Page(read_text(found.file), found.file, page.codec)
        return types.Location(from_fs_path(str(found.file)) or "", there.range(found.span))

    @serving.feature(types.TEXT_DOCUMENT_PREPARE_RENAME)
    async def renaming(params: types.PrepareRenameParams) -> types.PrepareRenamePlaceholder | None:
        page = serving.page(params.text_document.uri)
        if page is None:
            return None
        with _refused():
            written, span = await serving.answer(renamable, page.text, page.place(params.position))
        return types.PrepareRenamePlaceholder(page.range(span), written)

    @serving.feature(types.TEXT_DOCUMENT_RENAME, types.RenameOptions(prepare_provider=True))
    async def rename(params: types.RenameParams) -> types.WorkspaceEdit | None:
        uri = params.text_document.uri
        page = serving.page(uri)
        if page is None:
            return None
        with _refused():
            edits = await serving.answer(renamed, page.text, page.place(params.position), params.new_name)
        return types.WorkspaceEdit({uri: [page.edit(edit) for edit in edits]})

    @serving.feature(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    async def listed(params: types.DocumentSymbolParams) -> list[types.DocumentSymbol] | None:
        page = serving.page(params.text_document.uri)
        return None if page is None else [_symbol(page, each) for each in await serving.answer(outline, page.text)]

    @serving.feature(
        types.TEXT_DOCUMENT_CODE_ACTION, types.CodeActionOptions(code_action_kinds=[types.CodeActionKind.QuickFix])
    )
    async def mended(params: types.CodeActionParams) -> list[types.CodeAction] | None:
        uri = params.text_document.uri
        judgement = await serving.judgement(uri)
        return None if judgement is None else list(_actions(uri, judgement, params.range))

    @serving.feature(types.TEXT_DOCUMENT_FORMATTING)
    async def tidied(params: types.DocumentFormattingParams) -> list[types.TextEdit] | None:
        page = serving.page(params.text_document.uri)
        if page is None:
            return None
        with _refused():
            text = await serving.answer(formatted, page.text)
        return [types.TextEdit(page.whole, text)] if text != page.text else []

    return serving


@contextmanager
def _refused() -> Iterator[None]:
    """A refusal to rename or to format, as the protocol tells it."""
    try:
        yield
    except (RenamingError, DiagnosticError) as error:
        raise JsonRpcException(str(error), int(types.LSPErrorCodes.RequestFailed)) from None


def _is_a_bug(record: logging.LogRecord) -> bool:
    """Whether what the protocol's library logs is more than a request that was refused with a reason."""
    return record.exc_info is None or not isinstance(record.exc_info[1], JsonRpcException)


def serve(*, allow_code: bool = False) -> None:
    """Answer an editor until it is done. What else would be written to stdout, by any library, goes to stderr."""
    if sys.stdin.isatty():
        say("an editor starts this and asks over stdin: docs/editors.md says how; Ctrl-C ends it")
    logging.getLogger("pygls.protocol.json_rpc").addFilter(_is_a_bug)
    answers: BinaryIO = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    server(allow_code=allow_code).start_io(sys.stdin.buffer, answers)
