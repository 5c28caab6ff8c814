"""Pictures and films of trials, objects and hands."""

from __future__ import annotations

import io
import os
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
import trimesh
from hands.models import URDF, changed, write
from objects import parts
from PIL import Image
from stored_runs import lose_trajectory, stored_run

from graspdsl.hands.descriptions import robot
from graspdsl.hands.fingertip_motion import FingertipMotion
from graspdsl.trials.replay import Replay, frame
from graspdsl.trials.store import RunFolder
from graspdsl.worlds.annotations import INK
from graspdsl.worlds.mujoco.studio import GraspStudio, HandStudio, SurfaceStudio

from .program import ROOT, SPEC, graspdsl, interrupt, stopped

pytestmark = pytest.mark.slow

RADIUS = robot("barrett", "gantry").hand.contacts["finger-1"].shape.radius
QUICK = ("trials.count=2", "program.1.limit=1.0", "trials.start.roll=0.3")
HANDS = ROOT / "graspdsl" / "hands"
FLOATING = ROOT / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """Two short trials of the main experiment."""
    return stored_run(tmp_path_factory.mktemp("runs") / "run", SPEC, *QUICK)


def test_fingertips_are_where_they_touched(folder: RunFolder) -> None:
    """Replayed without physics, the middle of a fingertip is a radius from where it touched, soft as it is."""
    with Replay(folder, 0) as replay:
        assert isinstance(replay.studio, GraspStudio)
        checked = 0
        for tick in range(0, replay.ticks, 7):
            replay.show(tick)
            touching = replay.rows["touching"][tick].astype(bool)
            away = np.linalg.norm(replay.studio.robot.tips() - replay.rows["points"][tick], axis=1)
            assert np.abs(away[touching] - RADIUS).max(initial=0.0) < 2e-3
            checked += int(touching.sum())
        assert checked > 10


def test_arrows_begin_at_the_contacts(folder: RunFolder) -> None:
    with Replay(folder, 0) as replay:
        last = replay.ticks - 1
        touching = np.flatnonzero(replay.rows["touching"][last])
        arrows = replay.arrows(last)
        starts = replay.camera.pixels(replay.rows["points"][last][touching].astype(float))
        assert len(arrows) == 2 * len(touching)
        assert all(np.allclose(arrow.start, place) for arrow, place in zip(arrows[::2], starts, strict=True))
        assert ((starts > 0) & (starts < [replay.camera.width, replay.camera.height])).all()


def test_a_frame_is_a_picture_or_nothing(folder: RunFolder, tmp_path: Path) -> None:
    drawn = frame(folder, 1)
    assert drawn is not None
    picture = Image.open(io.BytesIO(drawn))
    assert picture.format == "PNG"
    assert len(np.unique(np.asarray(picture.convert("L")))) > 20
    assert frame(folder, 7) is None
    lost = stored_run(tmp_path / "lost", SPEC, *QUICK[1:], "trials.count=1")
    lose_trajectory(lost, 0)
    assert frame(lost, 0) is None


def test_floating_contacts_have_a_frame_too(tmp_path: Path) -> None:
    assert frame(stored_run(tmp_path / "floating", FLOATING, "trials.count=1"), 0) is not None


def test_of_floating_contacts_those_of_the_grasp_are_drawn(tmp_path: Path) -> None:
    """Three of the eight that there are, though all of them lie on the object."""
    with Replay(stored_run(tmp_path / "floating", FLOATING, "trials.count=1"), 0) as replay:
        last = replay.ticks - 1
        assert replay.rows["touching"][last].sum() == 8
        assert isinstance(replay.studio, SurfaceStudio)
        np.testing.assert_allclose(replay.studio.data.mocap_pos, replay.rows["points"][last, :3], atol=1e-6)
        starts = [arrow.start for arrow in replay.arrows(last)]
        used = replay.camera.pixels(replay.rows["points"][last, :3].astype(float))
        assert len(starts) == 6
        np.testing.assert_allclose(starts, np.repeat(used, 2, axis=0))


def test_pictures_of_a_trial(folder: RunFolder, tmp_path: Path) -> None:
    done = graspdsl("view", folder.path, "--trial", 1, "--images", tmp_path / "seen", "--frames", 3, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    files = sorted((tmp_path / "seen").iterdir())
    assert [str(file) for file in files] == done.stdout.split()
    assert len(files) == 3
    assert files[0].name.endswith("-00000.png")


def test_a_film_of_a_trial(folder: RunFolder, tmp_path: Path) -> None:
    film = tmp_path / "trial.mp4"
    done = graspdsl("view", folder.path, "--video", film, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    told = [line for line in done.stderr.splitlines() if "█" in line]
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(film))
    assert frames == pytest.approx(10 * float(folder.trajectory(0)["time"][-1]), abs=2)
    assert seconds == pytest.approx(frames / 10, abs=0.2)
    assert 1 < len(told) <= 20
    assert f" {frames}/{frames}  " in told[-1]
    assert [file.name for file in tmp_path.iterdir()] == ["trial.mp4"]


def test_an_interrupted_film_leaves_no_draft(folder: RunFolder, tmp_path: Path) -> None:
    words = ("view", folder.path, "--video", tmp_path / "trial.mp4")
    assert stopped(*words, cwd=tmp_path, after="█", stop=interrupt).returncode == 130
    assert list(tmp_path.iterdir()) == []


def test_without_a_film_maker_that_is_said(folder: RunFolder, tmp_path: Path) -> None:
    """One that is named and not there, and a machine that has none: neither in its package nor on its path."""
    (tmp_path / "imageio_ffmpeg").mkdir()
    package = Path(imageio_ffmpeg.__file__).parent
    for source in package.glob("*.py"):
        (tmp_path / "imageio_ffmpeg" / source.name).write_bytes(source.read_bytes())
    (tmp_path / "imageio_ffmpeg" / "binaries").mkdir()
    (tmp_path / "imageio_ffmpeg" / "binaries" / "__init__.py").touch()
    for surroundings in (
        {"IMAGEIO_FFMPEG_EXE": "/nowhere/ffmpeg"},
        {"PYTHONPATH": str(tmp_path), "PATH": str(tmp_path), "IMAGEIO_FFMPEG_EXE": ""},
    ):
        done = graspdsl("view", folder.path, "--video", "film.mp4", cwd=tmp_path, env=surroundings, anew=True)
        assert done.returncode == 1, done.stderr
        assert done.stderr.count("error[not-installed]") == 1
        assert "IMAGEIO_FFMPEG_EXE" in done.stderr
        assert "Traceback" not in done.stderr
        assert not list(tmp_path.glob("*.mp4"))


def test_what_is_doubtful_about_a_hand_is_said(tmp_path: Path) -> None:
    drawn = changed(URDF, ('<sphere radius="0.011"/>', '<mesh filename="part.dae"/>'))
    write(tmp_path, drawn)
    done = graspdsl("view", "--hand", "hand.yaml", "--images", "seen", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("warning[undrawn]") == 1
    assert "hand.yaml:2" in done.stderr


@pytest.mark.parametrize(
    ("words", "names"),
    [
        (("--object", "squirt-bottle"), ["squirt-bottle.png"]),
        (("--hand", "trio"), ["trio-closed.png", "trio-open.png"]),
        (("--hand", HANDS / "trio.yaml"), ["trio-closed.png", "trio-open.png"]),
    ],
)
def test_objects_and_hands(words: tuple[str, ...], names: list[str], tmp_path: Path) -> None:
    done = graspdsl("view", *words, "--images", tmp_path / "seen", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert sorted(file.name for file in (tmp_path / "seen").iterdir()) == names


@pytest.mark.parametrize("name", ["barrett", "trio"])
def test_the_contacts_of_a_hand_are_marked_at_its_fingertips(name: str, tmp_path: Path) -> None:
    done = graspdsl("view", "--hand", name, "--images", "seen", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    shown = robot(name, "gantry")
    postures = {
        posture: np.array([shown.hand.postures[posture].get(joint, 0.0) for joint in shown.joints])
        for posture in ("open", "closed")
    }
    with HandStudio(shown) as studio:
        camera = studio.camera(list(postures.values()), 640, 480)
        for posture, joints in postures.items():
            studio.show(joints)
            tips = studio.robot.tips()
            np.testing.assert_allclose(tips, FingertipMotion(shown).centres(joints), atol=1e-9)
            picture = np.asarray(Image.open(tmp_path / "seen" / f"{name}-{posture}.png").convert("RGB"))
            marks = [picture[round(y), round(x)] for x, y in camera.pixels(tips)]
            assert (np.array(marks) == INK).all()


def test_objects_of_files(tmp_path: Path) -> None:
    """A mesh, and a URDF whose mesh is in another folder, each seen in full and called after its file."""
    for folder in ("meshes", "urdf"):
        (tmp_path / folder).mkdir()
    parts.write(trimesh.creation.box((0.05, 0.05, 0.05)), tmp_path / "meshes" / "shade.stl")
    parts.write(parts.cylinder(), tmp_path / "part.OBJ")
    (tmp_path / "urdf" / "lamp.urdf").write_text(
        '<robot name="lamp"><link name="foot"><collision><geometry><mesh filename="../meshes/shade.stl"/></geometry>'
        "</collision></link></robot>"
    )
    for file, name in (("part.OBJ", "part"), ("meshes/shade.stl", "shade"), ("urdf/lamp.urdf", "lamp")):
        done = graspdsl("view", "--object", file, "--images", "seen", cwd=tmp_path)
        assert (done.returncode, done.stdout, done.stderr) == (0, f"seen/{name}.png\n", "")
        assert len(np.unique(np.asarray(Image.open(tmp_path / "seen" / f"{name}.png").convert("L")))) > 20
    shade, lamp = (Image.open(tmp_path / "seen" / f"{name}.png").crop((0, 0, 640, 400)) for name in ("shade", "lamp"))
    assert np.abs(np.asarray(shade, dtype=float) - np.asarray(lamp, dtype=float)).mean() < 1.0


def test_what_is_odd_about_the_file_of_an_object_is_said(tmp_path: Path) -> None:
    parts.write(parts.without(parts.cylinder(), 5), tmp_path / "part.stl")
    done = graspdsl("view", "--object", "part.stl", "--images", "seen", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stderr.startswith("part.stl: warning[mesh-not-watertight]: ")


def test_files_that_hold_no_object_are_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.stl").mkdir()
    (tmp_path / "empty.stl").touch()
    (tmp_path / "part.step").write_text("ISO-10303-21;")
    (tmp_path / "part.urdf").write_text("<robot><link/></robot>")
    parts.write(trimesh.creation.cone(0.04, 0.1).apply_transform(np.diag([1.0, -1.0, -1.0, 1.0])), tmp_path / "tip.stl")
    for name, code in (
        ("missing.stl", "file-not-found"),
        (f"{'x' * 300}.stl", "file-not-found"),
        ("missing/part.urdf", "file-not-found"),
        ("folder.stl", "is-a-directory"),
        ("empty.stl", "empty-mesh"),
        ("part.step", "unknown-mesh-format"),
        ("part.urdf", "bad-name"),
        ("tip.stl", "unstable-object"),
    ):
        done = graspdsl("view", "--object", name, "--images", "seen", cwd=tmp_path)
        assert (done.returncode, done.stdout, done.stderr.count("error[")) == (1, "", 1)
        assert done.stderr.startswith(f"{name}: error[{code}]: ")
        assert "spec" not in done.stderr or code == "unstable-object"
        assert not (tmp_path / "seen").exists()


def test_what_cannot_be_seen_is_said(folder: RunFolder, tmp_path: Path) -> None:
    (tmp_path / "folder.mp4").mkdir()
    for words, code in (
        ((folder.path, "--trial", 9, "--images", "x"), "unknown-trial"),
        ((tmp_path, "--images", "x"), "not-a-run"),
        ((folder.path, "--video", "film.avi"), "unknown-suffix"),
        ((folder.path, "--video", "film"), "unknown-suffix"),
        ((folder.path, "--video", SPEC / "film.mp4", "--images", "x"), "file-not-writable"),
        ((folder.path, "--video", "folder.mp4", "--images", "x"), "file-not-writable"),
        ((folder.path, "--video", f"{'x' * 300}.mp4", "--images", "x"), "file-not-writable"),
        (("--hand", "hand.yaml", "--images", "x"), "file-not-found"),
        (("--hand", SPEC, "--images", "x"), "missing-key"),
        (("--object", "bottel", "--images", "x"), "unknown-object"),
        (("--hand", "points", "--images", "x"), "unknown-hand"),
        ((folder.path, "--images", SPEC), "folder-not-writable"),
    ):
        done = graspdsl("view", *words, cwd=tmp_path)
        assert done.returncode == 1
        assert f"error[{code}]" in done.stderr
        assert "ffmpeg" not in done.stderr.lower()
        assert done.stderr.count("error[") == 1 or code == "missing-key"
        assert done.stdout == ""
        assert [file.name for file in tmp_path.iterdir()] == ["folder.mp4"]


@pytest.mark.parametrize(
    "words",
    [
        (),
        ("--object", "ball", "--hand", "trio"),
        ("--object", "ball", "--trial", "0", "--images", "x"),
        ("--hand", "trio", "--trial", "1", "--images", "x"),
        ("--object", "ball", "--frames", "6", "--images", "x"),
        ("--hand", "trio", "--frames", "2", "--images", "x"),
        ("--hand", "trio", "--video", "x.mp4"),
        ("run", "--frames", "2", "--video", "x.mp4"),
        ("run", "--images", ""),
        ("run", "--video", ""),
        ("",),
    ],
)
def test_what_would_be_ignored_is_wrong_use(words: tuple[str, ...], tmp_path: Path) -> None:
    done = graspdsl("view", *words, cwd=tmp_path)
    assert (done.returncode, done.stdout, list(tmp_path.iterdir())) == (2, "", [])


@pytest.mark.skipif("DISPLAY" in os.environ, reason="there is a display, and a window would open")
def test_without_a_display_there_is_no_window(folder: RunFolder, tmp_path: Path) -> None:
    done = graspdsl("view", folder.path, cwd=tmp_path)
    assert done.returncode == 1
    assert "error[no-display]" in done.stderr
    assert "--images" in done.stderr


def test_a_display_that_there_is_not_is_said(tmp_path: Path) -> None:
    done = graspdsl("view", "--object", "ball", cwd=tmp_path, env={"DISPLAY": ":9999"}, anew=True)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("ball: error[no-display]: a window cannot be opened: ")
    assert done.stderr.count("\n") == 2
