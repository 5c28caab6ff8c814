"""The entry point: runs a command and turns whatever happens into an exit code."""

from __future__ import annotations

import os
import signal
import sys
import traceback
from datetime import datetime
from types import FrameType

from graspdsl.cli.messages import INTERRUPTED, WRONG_INPUT, complain, prepare_streams, say
from graspdsl.diagnostics import DiagnosticError

BUG = 3


def main() -> None:
    """Run the command line and exit: 0 done, 1 wrong input, 2 wrong use, 3 a bug, 130 interrupted."""
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _interrupt)
    prepare_streams()
    sys.exit(_exit_code())


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    """Asked to end, or left by its terminal, a run keeps what it has, as after Ctrl-C."""
    raise KeyboardInterrupt


def _exit_code() -> int | str | None:
    try:
        from graspdsl.cli.app import app

        app()
    except SystemExit as end:  # how typer ends, well or with a complaint about the usage
        return end.code
    except KeyboardInterrupt:
        say("interrupted")
        return INTERRUPTED
    except DiagnosticError as error:
        complain("graspdsl", "", error.diagnostics)
        return WRONG_INPUT
    except Exception as error:
        say(f"graspdsl: a bug: {type(error).__name__}: {error}")
        _keep_crash_log(error)
        return BUG
    return 0


def _keep_crash_log(error: Exception) -> None:
    import tempfile

    stamp = datetime.now().astimezone().isoformat(timespec="seconds")
    text = f"{stamp}\n{sys.version}\n{sys.argv}\n\n{''.join(traceback.format_exception(error))}"
    try:
        descriptor, name = tempfile.mkstemp(prefix="graspdsl-crash-", suffix=".log")
        with os.fdopen(descriptor, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write(text)
    except OSError as refusal:
        say(f"  no crash log could be written ({refusal.strerror}); please send this with the command you ran:\n{text}")
    else:
        say(f"  the crash log is {name}; please send it with the command you ran")
