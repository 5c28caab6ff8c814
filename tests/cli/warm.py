"""The installed program in processes that begin with everything imported: forked from one that has imported it.

A command costs a tenth of a second this way instead of one to two. What a command imports for itself, and when, is not
tested by it; nor what depends on the surroundings in which an interpreter begins.

``python warm.py SOCKET`` is that process: it has one thread, and does nothing but wait and fork.
"""

from __future__ import annotations

import gc
import importlib
import importlib.util
import json
import os
import pkgutil
import signal
import socket
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

MOST = 1 << 17  # bytes, of a request
ENGINES = ("pybullet", "mujoco")
SPEC = Path(__file__).with_name("towel_roll_two_contacts.yaml")
PROGRAM = Path(sys.executable).with_name("graspdsl")


def run(
    words: list[str], cwd: Path, timeout: float, *sites: Path, env: dict[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """What the program answers, and its exit code.

    sites: where packages are besides, as PYTHONPATH says; env: what its surroundings have besides those of the tests.
    """
    with open(os.devnull, "rb") as nothing, tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        child = begin(words, cwd, (nothing.fileno(), out.fileno(), err.fileno()), {**os.environ, **(env or {})}, *sites)
        code = ended(child, words, timeout)
        texts = []
        for file in (out, err):
            file.seek(0)
            # Line ends as a pipe that is read as text gives them.
            texts.append(file.read().decode("utf-8").replace("\r\n", "\n").replace("\r", "\n"))
    return subprocess.CompletedProcess([str(PROGRAM), *words], code, *texts)


def begin(
    words: list[str], cwd: Path, streams: tuple[int, int, int], surroundings: dict[str, str], *sites: Path
) -> int:
    """Have a command begin with these for its standard streams; its process. The next begins when it has ended."""
    places = [str(site) for site in sites]
    whole = {**surroundings, **({"PYTHONPATH": os.pathsep.join(places)} if places else {})}
    request = json.dumps({"words": words, "cwd": str(cwd), "env": whole, "sites": places}).encode()
    socket.send_fds(_channel(), [request], streams)
    child: int = json.loads(_channel().recv(MOST))
    return child


def ended(child: int, words: list[str], timeout: float) -> int:
    """The exit code of the command that has begun."""
    channel = _channel()
    channel.settimeout(timeout)
    try:
        code: int = json.loads(channel.recv(MOST))
    except TimeoutError:
        os.kill(child, signal.SIGKILL)
        channel.settimeout(None)
        channel.recv(MOST)  # that it was killed
        raise subprocess.TimeoutExpired(words, timeout) from None
    finally:
        channel.settimeout(None)
    return code


@cache
def _channel() -> socket.socket:
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    command = [sys.executable, __file__, str(theirs.fileno())]
    surroundings = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    subprocess.Popen(
        command,
        env=surroundings,
        pass_fds=[theirs.fileno()],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )
    theirs.close()
    return ours


def _warm_up() -> None:
    """Import everything, and validate a spec, by which the grammar and the catalogues are read."""
    import graspdsl

    for found in pkgutil.walk_packages(graspdsl.__path__, "graspdsl."):
        if not found.name.endswith("__main__"):
            importlib.import_module(found.name)
    for engine in ENGINES:
        if importlib.util.find_spec(engine) is not None:
            importlib.import_module(engine)
    graspdsl.load(SPEC)
    gc.collect()
    gc.freeze()  # what a child's collector went through, it would have to copy


def _serve(channel: socket.socket) -> dict[str, Any] | None:
    """In the process that waits: None when nobody asks any more; in a child: what it was asked, its streams open."""
    while True:
        request, files, _, _ = socket.recv_fds(channel, MOST, 3)
        if not request:
            return None
        child = os.fork()
        if child == 0:
            channel.close()
            for number, file in enumerate(files):
                os.dup2(file, number)
                os.close(file)
            asked: dict[str, Any] = json.loads(request)
            return asked
        for file in files:
            os.close(file)
        channel.send(json.dumps(child).encode())
        _, status = os.waitpid(child, 0)
        channel.send(json.dumps(os.waitstatus_to_exitcode(status)).encode())


if __name__ == "__main__":
    _warm_up()
    asked = _serve(socket.socket(fileno=int(sys.argv[1])))
    if asked is not None:
        os.environ.clear()
        os.environ.update(asked["env"])
        os.chdir(asked["cwd"])
        coding = os.environ.get("PYTHONIOENCODING", "utf-8")
        shown = 1 if os.isatty(1) else -1  # a line at a time
        sys.stdout = os.fdopen(1, "w", encoding=coding, errors="strict", closefd=False, buffering=shown)
        sys.stderr = os.fdopen(2, "w", encoding=coding, errors="backslashreplace", closefd=False, buffering=1)
        sys.argv = [str(PROGRAM), *asked["words"]]
        sys.path[:1] = [str(PROGRAM.parent), *asked["sites"]]
        from graspdsl.cli import main

        try:
            main()
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)  # to take apart all that was imported would take longer than most commands
