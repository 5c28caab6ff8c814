"""The entry point: runs a command and turns whatever happens into an exit code."""

from __future__ import annotations

import gc
import os
import signal
import sys

from graspdsl.trials.interruption import INTERRUPTED, SIGNALS, interruption

BUG = 3
MADE_BETWEEN_LOOKS = 200_000  # objects; to read a spec and check it takes fewer


def main() -> None:
    """Run the command line and exit: 0 done, 1 wrong input, 2 wrong use, 3 a bug, 130 interrupted."""
    # What is made while modules are imported stays: to look through it for garbage again and again takes a fifth of
    # what a short command takes.
    gc.set_threshold(MADE_BETWEEN_LOOKS)
    # pydantic would look through all that is installed for plug-ins of its own, whose concern none of these models is.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # Before anything else is imported, which takes its time.
    interruption.heed(INTERRUPTED, b"interrupted; there was nothing to keep: give the command again\n")
    code = _exit_code()
    for number in SIGNALS:  # all is done and said
        signal.signal(number, signal.SIG_IGN)
    gc.freeze()  # nor at the end
    sys.exit(code)


def _exit_code() -> int | str | None:
    from graspdsl.cli.messages import WRONG_INPUT, complain, prepare_streams, say
    from graspdsl.diagnostics import DiagnosticError

    prepare_streams()
    try:
        from graspdsl.cli.app import app, only

        only(sys.argv[1:2])
        app()
    except SystemExit as end:  # how typer ends, well or with a complaint about the usage
        return end.code
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
    import traceback
    from datetime import datetime

    from graspdsl.cli.messages import say

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
