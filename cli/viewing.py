"""Trials, objects and hands to look at: in a window, as pictures, as a film."""

from __future__ import annotations

import os
import shutil
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from graspdsl.api.progress import Progress
from graspdsl.cli.messages import complain, result, say
from graspdsl.cli.running import opened
from graspdsl.compiler.object_check import body_in
from graspdsl.diagnostics import Diagnostic, DiagnosticError, known_names_hint, on_one_line, reading
from graspdsl.hands.description_files import DescriptionFileError
from graspdsl.hands.descriptions import Robot, hands, mounts, robot
from graspdsl.hands.hand_files import hand_in
from graspdsl.hands.mount_check import taken_names
from graspdsl.objects.object_files import Mesh
from graspdsl.objects.shapes import Body, catalogue
from graspdsl.places.files import SpecFolder, read_text
from graspdsl.places.folders import names_a_file
from graspdsl.plugins.adoption import adopted_all
from graspdsl.report.writing import replace
from graspdsl.spec.scene import GRAVITY, InlineObject
from graspdsl.trials.interruption import interruption
from graspdsl.trials.replay import Replay, evenly
from graspdsl.worlds.annotations import Label, annotated, png
from graspdsl.worlds.kind import TABLE_FRICTION
from graspdsl.worlds.protocol import NoWindowError, UnstableObjectError

SIZE = (640, 480)
PICTURES = 6  # of a trial
FILM_RATE = 10  # pictures a second
FILM_OVERSAMPLING = 1  # of pictures that move, where rough edges are hardly seen
MOUNT = "gantry"


def view_trial(
    run: Path, number: int, images: Path | None, video: Path | None, count: int, *, allow_code: bool = False
) -> None:
    """Replay a trial of a run: so many pictures evenly over it, a film in its own time, or the window."""
    if video is not None:
        _needs_film_maker(video)
    folder = opened(run, allow_code=allow_code).folder
    in_window = images is None and video is None
    if in_window:
        _needs_display(str(run))
    with (
        reading(str(run)),
        _windows(str(run)),
        Replay(folder, number, width=SIZE[0], height=SIZE[1], window=in_window) as replay,
    ):
        if video is not None:
            _needs_place(video)
        if in_window:
            _play(replay)
        if images is not None:
            ticks = evenly(replay.ticks, count)
            _write(images, {f"trial-{number}-{tick:05d}.png": png(replay.picture(tick)) for tick in ticks})
        if video is not None:
            _film(video, replay)


def view_object(name: str, images: Path | None) -> None:
    """An object of the catalogue or of a file, as it stands on the table."""
    known = catalogue()
    if name not in known and not Path(name).suffix:
        complain(name, "", adopted_all(["objects"]))
    if name not in known and not Path(name).suffix:
        raise DiagnosticError([Diagnostic("unknown-object", "there is no such object", hint=_hint(name, known))], name)
    body = known[name] if name in known else _object_of_file(name)
    if images is None:
        _needs_display(name)
    from graspdsl.worlds.mujoco.studio import ObjectStudio

    try:
        with _windows(name):
            studio = ObjectStudio(body, TABLE_FRICTION, GRAVITY, window=images is None)
    except UnstableObjectError as error:
        hint = "turn it in its file; in a spec it can also be held or fixed"
        raise DiagnosticError([Diagnostic("unstable-object", str(error), hint=hint)], name) from None
    with studio:
        if images is None:
            _stay(lambda: studio.is_open)
        else:
            shown = body.name
            _write(images, {f"{shown}.png": png(annotated(studio.picture(studio.camera(*SIZE)), [], [shown]))})


def view_hand(name: str, images: Path | None) -> None:
    """A hand of the catalogue or of a file, open and closed."""
    from graspdsl.worlds.mujoco.studio import HandStudio

    shown = _hand_of_file(Path(name)) if names_a_file(name) else _hand_of_catalogue(name)
    if images is None:
        _needs_display(name)
    name = Path(name).stem if names_a_file(name) else name
    postures = {
        posture: np.array([shown.hand.postures[posture].get(joint, 0.0) for joint in shown.joints])
        for posture in ("open", "closed")
    }
    with _windows(name), HandStudio(shown, window=images is None) as studio:
        if images is None:
            studio.show(postures["open"])
            _stay(lambda: studio.is_open)
            return
        camera = studio.camera(list(postures.values()), *SIZE)
        pictures = {}
        for posture, joints in postures.items():
            studio.show(joints)
            tips = camera.pixels(studio.robot.tips())
            labels = [Label(tip, contact) for tip, contact in zip(tips, shown.contacts, strict=True)]
            drawn = annotated(studio.picture(camera), [], [f"{name}, {posture}"], labels)
            pictures[f"{name}-{posture}.png"] = png(drawn)
        _write(images, pictures)


def _object_of_file(name: str) -> Body:
    """The object in a mesh or URDF file, as of a spec that names it by its absolute path."""
    if not os.path.exists(name):
        raise DiagnosticError([Diagnostic("file-not-found", "there is no such file")], name)
    place = os.path.realpath(name)
    key = {".urdf": "urdf", ".xml": "mjcf"}.get(Path(name).suffix.lower())
    fields = {key: place} if key else {"mesh": Mesh.model_construct(file=place)}
    odd: list[Diagnostic] = []
    with reading(name):
        # Not validated: what is there may have a longer path than a spec can write.
        chosen = InlineObject.model_construct(name=Path(name).stem, **fields)
        body = body_in(SpecFolder(Path(place).parent), chosen, odd.append)
    complain(name, "", odd)
    return body


def _hand_of_catalogue(name: str) -> Robot:
    if name not in hands():
        complain(name, "", adopted_all(["hands"]))
    known = {hand: found for hand, found in hands().items() if found.urdf}
    if name not in known:
        raise DiagnosticError([Diagnostic("unknown-hand", "there is no such hand", hint=_hint(name, known))], name)
    return robot(name, MOUNT)


def _hand_of_file(path: Path) -> Robot:
    with reading(str(path)):
        try:
            found = hand_in(SpecFolder(path.parent), path.name)
        except DescriptionFileError as error:
            raise DiagnosticError(error.diagnostics, str(path), error.text) from None
        complain(str(path), read_text(path), found.warnings)
        shown = Robot(hand=found.hand, mount=mounts()[MOUNT])
        if taken := [*taken_names(shown)]:
            raise DiagnosticError(taken)
    return shown


def _play(replay: Replay) -> None:
    """A trial in the window, in its own time; then it stays until the window is closed."""
    times = replay.rows["time"]
    for tick in range(replay.ticks):
        if not replay.studio.is_open:
            return
        replay.show(tick)
        time.sleep(float(times[tick] - times[max(0, tick - 1)]))
    _stay(lambda: replay.studio.is_open)


def _stay(is_open: Callable[[], bool]) -> None:
    say("close the window to end")
    while is_open():
        time.sleep(0.1)


def _film(place: Path, replay: Replay) -> None:
    """A film of a trial in its own time."""
    from imageio_ffmpeg import write_frames

    ends = np.arange(0.0, float(replay.rows["time"][-1]), 1.0 / FILM_RATE)
    ticks = [*np.searchsorted(replay.rows["time"], ends), replay.ticks - 1]
    draft = _draft(place)
    say(f"a film of {len(ticks)} pictures → {on_one_line(str(place))}")
    with interruption.at_the_end(lambda: draft.unlink(missing_ok=True)):
        try:
            film = write_frames(str(draft), SIZE, fps=FILM_RATE, macro_block_size=1, ffmpeg_log_level="quiet")
            film.send(None)
            with Progress(len(ticks), to=say) as progress:
                for tick in ticks:
                    film.send(np.asarray(replay.picture(int(tick), FILM_OVERSAMPLING)).tobytes())
                    progress.step()
            film.close()
            draft.replace(place)
        except OSError as error:  # what ffmpeg itself has to say goes on for pages
            raise _not_writable(place, error.strerror or "the film maker gave up") from None
    result(on_one_line(str(place)))


def _draft(place: Path) -> Path:
    """Where a film is while it is being made; ffmpeg knows a film by its suffix."""
    return place.with_name(f"{place.stem}.{os.getpid()}.new{place.suffix}")


def _needs_place(place: Path) -> None:
    """A film can be written there: its folder is made, and a file in it."""
    draft = _draft(place)
    try:
        if place.is_dir():
            raise _not_writable(place, "is a directory")
        place.parent.mkdir(parents=True, exist_ok=True)
        draft.touch()
        draft.unlink()
    except OSError as error:
        raise _not_writable(place, error.strerror or "unknown reason") from None


def _not_writable(place: Path, reason: str) -> DiagnosticError:
    return DiagnosticError([Diagnostic("file-not-writable", f"cannot write this file: {reason.lower()}")], str(place))


def _write(folder: Path, pictures: Mapping[str, bytes]) -> None:
    with reading(str(folder)):
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            reason = (error.strerror or "unknown reason").lower()
            fault = Diagnostic("folder-not-writable", f"cannot write to this folder: {reason}")
            raise DiagnosticError([fault], str(folder)) from None
        replace(folder, pictures)
    for name in pictures:
        result(on_one_line(str(folder / name)))


def _needs_display(name: str) -> None:
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        raise _no_display(name, "there is no display for a window")


@contextmanager
def _windows(name: str) -> Iterator[None]:
    """Where windows are opened, for something of this name."""
    try:
        yield
    except NoWindowError as error:
        raise _no_display(name, f"a window cannot be opened: {on_one_line(str(error))}") from None


def _no_display(name: str, what: str) -> DiagnosticError:
    hint = "write pictures with --images DIR, or a film of a trial with --video FILE"
    return DiagnosticError([Diagnostic("no-display", what, hint=hint)], name)


def _needs_film_maker(place: Path) -> None:
    if place.suffix != ".mp4":
        raise DiagnosticError(
            [Diagnostic("unknown-suffix", "a film's name ends in .mp4", hint="rename it")], str(place)
        )
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        maker = get_ffmpeg_exe()
    except ImportError:
        hint = "install it: pip install 'graspdsl[video]'"
        fault = Diagnostic("not-installed", "films need imageio-ffmpeg", hint=hint)
        raise DiagnosticError([fault], str(place)) from None
    except RuntimeError:  # its package brings none for some machines
        maker = ""
    if shutil.which(maker) is None:
        what = f"there is no program {maker}" if maker else "the program ffmpeg is not found"
        hint = "install ffmpeg, or say where it is in IMAGEIO_FFMPEG_EXE"
        raise DiagnosticError([Diagnostic("not-installed", f"films need ffmpeg: {what}", hint=hint)], str(place))


def _hint(name: str, known: Iterable[str]) -> str:
    return known_names_hint(name, known, "names")
