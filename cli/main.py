"""The entry point: runs a command and turns whatever happens into an exit code."""

from __future__ import annotations

import os
import sys
import tempfile
import traceback
from datetime import datetime
from pathlib import Path

from graspdsl.diagnostics import DiagnosticError

DONE, WRONG_INPUT, WRONG_USE, BUG, INTERRUPTED = 0, 1, 2, 3, 130


def main() -> None:
    """Run the command line and exit: 0 done, 1 wrong input, 2 wrong use, 3 a bug, 130 interrupted."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    sys.exit(_exit_code())


def _exit_code() -> int:
    from graspdsl.cli.app import app
    from graspdsl.cli.messages import complain, say

    try:
        code = app(standalone_mode=False)
        sys.stdout.flush()
    except DiagnosticError as error:
        complain("graspdsl", "", error.diagnostics)
        return WRONG_INPUT
    except KeyboardInterrupt:
        say("interrupted")
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read our output has seen enough; nothing more can be written to it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except Exception as error:
        return _other(error)
    return code if isinstance(code, int) else DONE


def _other(error: Exception) -> int:
    import click
    from graspdsl.cli.messages import say

    if isinstance(error, click.exceptions.Abort):
        say("interrupted")
        return INTERRUPTED
    if isinstance(error, click.exceptions.Exit):
        return error.exit_code
    if isinstance(error, click.ClickException):
        error.show(sys.stderr)
        return error.exit_code
    log = _crash_log(error)
    say(f"graspdsl: a bug: {type(error).__name__}: {error}")
    say(f"  the crash log is {log}; please send it with the command you ran")
    return BUG


def _crash_log(error: Exception) -> Path:
    stamp = datetime.now().astimezone().isoformat(timespec="seconds")
    descriptor, name = tempfile.mkstemp(prefix="graspdsl-crash-", suffix=".log")
    with os.fdopen(descriptor, "w", encoding="utf-8") as file:
        file.write(f"{stamp}\n{sys.version}\n{sys.argv}\n\n")
        file.writelines(traceback.format_exception(error))
    return Path(name)
