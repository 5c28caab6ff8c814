"""An editor without a window: it speaks the Language Server Protocol to the server that users run."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

from cli.warm import PROGRAM
from lsprotocol import types
from pygls.exceptions import JsonRpcException
from pygls.lsp.client import LanguageClient
from pygls.uris import from_fs_path

T = TypeVar("T")
WAIT = 120.0  # s, for an answer, as long as for a command


def units(text: str) -> int:
    """How many code units of UTF-16 a text takes, which is what the protocol counts."""
    return len(text.encode("utf-16-le")) // 2


def position(text: str, found: str, after: int = 0, which: int = 0) -> types.Position:
    """Where a piece of a text stands, or the place so many characters further."""
    at = -1
    for _ in range(which + 1):
        at = text.index(found, at + 1)
    before = text[: at + after]
    return types.Position(before.count("\n"), units(before.rpartition("\n")[2]))


def offset(text: str, place: types.Position) -> int:
    """The index of the character at a position."""
    rows = text.split("\n")
    row = rows[place.line]
    within = next((n for n in range(len(row) + 1) if units(row[:n]) >= place.character), None)
    assert within is not None, f"{place} is outside of {row!r}"
    return sum(len(before) + 1 for before in rows[: place.line]) + within


def applied(text: str, edits: list[types.TextEdit]) -> str:
    """The text after edits."""
    for edit in sorted(edits, key=lambda edit: offset(text, edit.range.start), reverse=True):
        text = text[: offset(text, edit.range.start)] + edit.new_text + text[offset(text, edit.range.end) :]
    return text


class Editor:
    """An editor with a server; every file that is open has its text and the diagnostics that came last."""

    def __init__(self, *words: str) -> None:
        self._loop = asyncio.new_event_loop()
        self._client = LanguageClient("tests", "1")
        self.texts: dict[str, str] = {}
        self.shown: dict[str, list[types.Diagnostic]] = {}
        self.log: list[str] = []
        self._told: dict[str, int] = {}
        self._versions: dict[str, int] = {}

        @self._client.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def told(params: types.PublishDiagnosticsParams) -> None:
            self.shown[params.uri] = list(params.diagnostics)
            self._told[params.uri] = self._told.get(params.uri, 0) + 1

        @self._client.feature(types.WINDOW_LOG_MESSAGE)
        def logged(params: types.LogMessageParams) -> None:
            self.log.append(params.message)

        self._run(self._client.start_io(str(PROGRAM), "lsp", *words))
        asked = types.InitializeParams(types.ClientCapabilities(), process_id=None, root_uri=None)
        self.capabilities = self._run(self._client.initialize_async(asked)).capabilities
        self._client.initialized(types.InitializedParams())

    def _run(self, awaited: Awaitable[T]) -> T:
        return self._loop.run_until_complete(asyncio.wait_for(awaited, WAIT))

    def ask(self, method: str, params: Any) -> Any:
        """The answer to a request, by the name of the client's method for it."""
        return self._run(getattr(self._client, f"{method}_async")(params))

    def refusal(self, method: str, params: Any) -> int | None:
        """The code of the error that answers a request; None where it is granted."""
        try:
            self.ask(method, params)
        except JsonRpcException as error:
            return error.code
        return None

    def open(self, path: Path, text: str) -> str:
        """Open a file with a text, whatever is on the disk; its address."""
        uri = from_fs_path(str(path))
        assert uri is not None
        self.texts[uri], self._versions[uri] = text, 1
        document = types.TextDocumentItem(uri, "yaml", 1, text)
        self._client.text_document_did_open(types.DidOpenTextDocumentParams(document))
        return uri

    def write(self, uri: str, text: str) -> None:
        """Put another text in place of the one that is open."""
        self.texts[uri] = text
        self._versions[uri] += 1
        version = types.VersionedTextDocumentIdentifier(self._versions[uri], uri)
        change = types.TextDocumentContentChangeWholeDocument(text)
        self._client.text_document_did_change(types.DidChangeTextDocumentParams(version, [change]))

    def close(self, uri: str) -> None:
        """Close a file."""
        del self.texts[uri]
        self._client.text_document_did_close(types.DidCloseTextDocumentParams(types.TextDocumentIdentifier(uri)))

    def diagnostics(self, uri: str) -> list[types.Diagnostic]:
        """The diagnostics of a file, when they have come after all that was asked or told before."""
        return self.timed(uri)[0]

    def timed(self, uri: str) -> tuple[list[types.Diagnostic], float]:
        """The next diagnostics of a file, and how long [s] they took to come."""
        begun, before = time.perf_counter(), self._told.get(uri, 0)
        self._run(self._until(lambda: self._told.get(uri, 0) > before))
        return self.shown[uri], time.perf_counter() - begun

    async def _until(self, holds: Callable[[], bool]) -> None:
        while not holds():
            await asyncio.sleep(0.001)

    def at(self, uri: str, found: str, after: int = 0, which: int = 0) -> dict[str, Any]:
        """A place in a file, as requests about places have it."""
        place = position(self.texts[uri], found, after, which)
        return {"text_document": types.TextDocumentIdentifier(uri), "position": place}

    def hover(self, uri: str, found: str, after: int = 0, which: int = 0) -> str:
        """What is said of the place where something stands; empty where nothing is."""
        answer = self.ask("text_document_hover", types.HoverParams(**self.at(uri, found, after, which)))
        return "" if answer is None else answer.contents.value

    def complete(self, uri: str, found: str) -> list[types.CompletionItem]:
        """What may be written behind something."""
        answer = self.ask("text_document_completion", types.CompletionParams(**self.at(uri, found, len(found))))
        return [] if answer is None else list(answer.items)

    def actions(self, uri: str, range_: types.Range) -> list[types.CodeAction]:
        """The code actions for a range."""
        context = types.CodeActionContext(self.shown.get(uri, []))
        params = types.CodeActionParams(types.TextDocumentIdentifier(uri), range_, context)
        return list(self.ask("text_document_code_action", params) or [])

    def rename(self, uri: str, found: str, name: str, which: int = 0) -> str:
        """The text with another name for the thing that stands somewhere."""
        edit = self.ask("text_document_rename", types.RenameParams(new_name=name, **self.at(uri, found, which=which)))
        return applied(self.texts[uri], list(edit.changes[uri]))

    def end(self) -> int | None:
        """Shut the server down as editors do; its exit code."""
        self._run(self._client.shutdown_async(None))
        self._client.exit(None)
        process = self._client._server
        assert process is not None
        code = self._run(process.wait())
        self._run(self._client.stop())
        self._loop.close()
        return code


def each_action(editor: Editor, uri: str) -> Iterator[tuple[types.Diagnostic, list[types.CodeAction]]]:
    """The diagnostics of a file with the code actions for each."""
    for shown in editor.shown[uri]:
        yield shown, [each for each in editor.actions(uri, shown.range) if shown in (each.diagnostics or [])]
