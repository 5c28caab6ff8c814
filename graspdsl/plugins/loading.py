"""From a distribution, or a Python file, to a thing that fits its table; or one complaint."""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import inspect
import io
import sys
import traceback
import types
from abc import ABCMeta
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path as FilePath
from typing import Any

from graspdsl.declared import misdeclared
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity, listed, on_one_line
from graspdsl.places.files import refusal
from graspdsl.places.folders import told_of
from graspdsl.places.wording import shortened
from graspdsl.plugins.kinds import BROUGHT, KINDS, Key, Offer, Plugin, spelt

OF_CODE: dict[str, dict[Key, Any]] = {}  # things of Python files, by the hashes of these


def loaded(offer: Offer) -> tuple[Any, tuple[Diagnostic, ...]]:
    """The thing that is offered, as its table has it, and warnings. Raises DiagnosticError where it is none."""
    kind = KINDS[offer.kind]
    if kind.read is not None:
        return _read(offer, kind.read), ()
    printed = io.StringIO()
    module, _, attribute = offer.value.partition(":")
    with attempted(f"{offer.said} cannot be imported"), contextlib.redirect_stdout(printed):
        value: Any = importlib.import_module(module.strip())
        for part in attribute.split(".") if attribute else ():
            value = getattr(value, part.strip())
    thing = fitting(offer.kind, value, offer.name, offer.said)
    return thing, prints(offer.said, printed.getvalue())


def prints(said: str, text: str) -> tuple[Diagnostic, ...]:
    """The warning of what is printed at import; none of nothing."""
    if not text:
        return ()
    message = f"{said} prints as it is imported: {shortened(text.strip())}"
    return (Diagnostic("plugin-prints", message, hint="what it prints is left out", severity=Severity.WARNING),)


@contextlib.contextmanager
def attempted(failed: str, file: str = "") -> Iterator[None]:
    """What the code of others does within, of whatever kind, is one complaint, with the line of the file, if there is
    one."""
    try:
        yield
    except (DiagnosticError, KeyboardInterrupt):
        raise
    except BaseException as error:
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == file]
        place = f" ({file}:{lines[-1]})" if lines else ""
        raise refusal("plugin-broken", f"{failed}: {raised(error)}{place}", None) from None


def fitting(group: str, value: Any, name: str, said: str) -> Any:
    """What a table holds of a class. Raises DiagnosticError where it is not what the kind asks for."""
    kind = KINDS[group]
    assert kind.base is not None
    base = kind.base()
    wanted = f"write a class from {base.__module__}.{base.__qualname__}"
    if not (isinstance(value, type) and issubclass(value, base)):
        raise refusal("plugin-unfit", f"{said} is no {base.__qualname__}: {shortened(repr(value))}", wanted)
    if isinstance(value, ABCMeta) and value.__abstractmethods__:
        left = listed(sorted(value.__abstractmethods__))
        raise refusal("plugin-unfit", f"{said} does not define {left}", f"define {left} in {value.__qualname__}")
    if wrong := list(misdeclared(value, base)):
        raise refusal("plugin-unfit", f"{said}: {'; '.join(message for message, _ in wrong)}", wrong[0][1])
    own = spelt(group, getattr(value, kind.named_by))
    if own != name:
        message = f"{said} calls itself {own}"
        raise refusal("plugin-unfit", message, f"let {kind.named_by} and the name of the entry point be one")
    with attempted(f"{said} cannot be made"):
        return value() if kind.makes else value


def _read(offer: Offer, read: Callable[[FilePath, str], Mapping[str, Any]]) -> Any:
    """The thing in a distribution's file or folder."""
    place = place_of(offer)
    try:
        found = read(place, offer.by)
    except DiagnosticError as error:
        # Those of one file name it already, but for a file that is read as a whole.
        faults = error.diagnostics if offer.kind != "controllers" else told_of(place.name, error.diagnostics)
        raise DiagnosticError(
            [Diagnostic("plugin-broken", f"{offer.said}: {fault.message}", hint=fault.hint) for fault in faults]
        ) from None
    if offer.name not in found:
        what = KINDS[offer.kind].what
        message = f"{offer.said} is not in {place.name}, which has {listed(sorted(found)) or f'no {what}'}"
        raise refusal("plugin-unfit", message, f"let the {what} and the entry point have one name")
    return found[offer.name]


def place_of(offer: Offer) -> FilePath:
    """The file or the folder that an offer names: ``package.folder:file.yaml`` or ``package.folder``."""
    module, _, file = (part.strip() for part in offer.value.partition(":"))
    top, *folders = module.split(".")
    with attempted(f"{offer.said} cannot be found"):
        spec = importlib.util.find_spec(top)
    for root in (spec.submodule_search_locations or ()) if spec is not None else ():
        place = FilePath(root, *folders, file)
        if place.exists():
            return place
    raise refusal("plugin-broken", f"{offer.said} cannot be found: there is no {offer.value}", None)


def digest_of(offer: Offer, thing: Any) -> str:
    """A hash of the file of a class, or of a file or all files of a folder."""
    import hashlib  # which loads OpenSSL

    if KINDS[offer.kind].read is not None:
        place = place_of(offer)
        inside = sorted(path for path in place.rglob("*") if path.is_file() and "__pycache__" not in path.parts)
        files = [place] if place.is_file() else inside
    else:
        module = sys.modules[(thing if isinstance(thing, type) else type(thing)).__module__]
        files = [FilePath(module.__file__)] if module.__file__ else []
    return hashlib.sha256(b"".join(hashlib.sha256(file.read_bytes()).digest() for file in files)).hexdigest()[:16]


def enter(key: Key, thing: Any, plugin: Plugin) -> None:
    """Put a thing into its table, and note what brought it. Raises DiagnosticError where it cannot be used."""
    kind, name = key
    with attempted(f"the {KINDS[kind].what} {name} of {plugin.by} cannot be used"):
        KINDS[kind].enter(name, thing)
    BROUGHT[key] = plugin


def things_in(name: str, content: bytes) -> tuple[str, dict[Key, Any], tuple[Diagnostic, ...]]:
    """The hash of a Python file, what it defines, and warnings. Raises DiagnosticError for what cannot be used."""
    import hashlib

    digest = hashlib.sha256(content).hexdigest()[:16]
    if digest in OF_CODE:
        return digest, OF_CODE[digest], ()
    module = types.ModuleType(f"graspdsl_code_{digest}")
    module.__file__ = name
    sys.modules[module.__name__] = module  # where pydantic and dataclasses look for the types that it names
    printed = io.StringIO()
    try:
        with attempted(f"{name} cannot be run", name), contextlib.redirect_stdout(printed):
            exec(compile(content, name, "exec"), module.__dict__)
        things = dict(_defined_in(module, name))
        if not things:
            message = f"{name} defines none of {listed((kind.what for kind in KINDS.values() if kind.base), 'or')}"
            raise refusal("nothing-defined", message, "leave it out")
    except DiagnosticError:
        del sys.modules[module.__name__]
        raise
    OF_CODE[digest] = things
    return digest, things, prints(name, printed.getvalue())


def _defined_in(module: types.ModuleType, file: str) -> Iterator[tuple[Key, Any]]:
    """The things of a module, those of its public classes that are whole or have a name."""
    for value in [*vars(module).values()]:
        if not (isinstance(value, type) and value.__module__ == module.__name__ and value.__name__[:1] != "_"):
            continue
        for kind, known in KINDS.items():
            whole = not inspect.isabstract(value) or hasattr(value, known.named_by)
            if known.base is not None and issubclass(value, known.base()) and whole:
                name = spelt(kind, str(getattr(value, known.named_by, "")))
                yield (kind, name), fitting(kind, value, name, f"{value.__name__} in {file}")


def raised(error: BaseException) -> str:
    """An exception in a line."""
    return on_one_line(f"{type(error).__name__}: {error}".partition("\n")[0].rstrip(": "))
