"""What the code of others does wrong when it is called: a complaint about it."""

from __future__ import annotations

import contextlib
import traceback
from collections.abc import Iterable, Iterator
from pathlib import Path as FilePath

from graspdsl.diagnostics import DiagnosticError, listed
from graspdsl.places.files import refusal
from graspdsl.plugins.kinds import BROUGHT, KINDS, Plugin
from graspdsl.plugins.loading import raised


@contextlib.contextmanager
def answered_for(plugins: Iterable[Plugin] = ()) -> Iterator[None]:
    """An exception of what is done within is a complaint about the thing of others in whose code it arose. Where it
    arose in none, as with an array of a wrong shape that one gave back, it is one about all that are at work."""
    try:
        yield
    except (DiagnosticError, KeyboardInterrupt, GeneratorExit):
        raise
    except BaseException as error:
        found = _culprit(error)
        others = [plugin for plugin in plugins if KINDS[plugin.kind].base is not None]
        if found is None and (not others or isinstance(error, SystemExit)):
            raise
        what = raised(error)
        if found is not None:
            message, first = f"{found[0]} fails in {found[1]}: {what}", found[2]
        else:
            each = listed(f"the {KINDS[plugin.kind].what} {plugin.name} of {plugin.by}" for plugin in others)
            message, first = f"{what}; at work {'is' if len(others) == 1 else 'are'} {each}", others[0]
        hint = f"hold it against its contract: graspdsl check-plugin {first.distribution}"
        raise refusal("plugin-failed", message, hint) from error


def _culprit(error: BaseException) -> tuple[str, str, Plugin] | None:
    """Of whose code an exception is, in words, with the place in it: that of the innermost frame of any."""
    classes = {
        plugin: thing if isinstance(thing := KINDS[kind].table()[name], type) else type(thing)
        for (kind, name), plugin in BROUGHT.items()
        if KINDS[kind].base is not None and name in KINDS[kind].table()
    }
    for frame, line in reversed([*traceback.walk_tb(error.__traceback__)]):
        module, own = str(frame.f_globals.get("__name__")), frame.f_locals.get("self")
        package = module.partition(".")[0]
        of_self = [plugin for plugin, of in classes.items() if isinstance(own, of)]
        of_module = [plugin for plugin, of in classes.items() if of.__module__ == module]
        of_package = [plugin for plugin, of in classes.items() if of.__module__.partition(".")[0] == package]
        if found := of_self or of_module or of_package:
            first, place = found[0], f"{FilePath(frame.f_code.co_filename).name}:{line}"
            what = f"the {KINDS[first.kind].what} {first.name} of {first.by}" if len(found) == 1 else first.by
            return what, place, first
    return None
