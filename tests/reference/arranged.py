"""What an example says in words, done: the wrong and the right of it, and what is said of each."""

from __future__ import annotations

import json
import os
import sqlite3
import sys
import warnings
from collections.abc import Callable, Iterable, Mapping
from contextlib import closing
from functools import partial
from pathlib import Path
from unittest.mock import patch

from compiler.specs import floating, spec
from hands.models import HAND, URDF, changed, with_links
from hands.test_guess import GRIPPER
from plugins.packages import HUBER, PHI, installed
from pydantic import Field

import graspdsl as g
from graspdsl.cli.documentation import show_documentation
from graspdsl.cli.viewing import view_object, view_trial
from graspdsl.compiler.program import examine, examine_expression, missing_engine
from graspdsl.compiler.program import program_of as checked
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity
from graspdsl.hands.description_files import DescriptionFileError
from graspdsl.hands.guess import guessed_hand
from graspdsl.hands.hand_files import hand_in
from graspdsl.hands.mount_files import mounts_in
from graspdsl.models.reading import model_in
from graspdsl.places.document import parse_document
from graspdsl.places.fields import Model
from graspdsl.places.files import SpecFolder
from graspdsl.places.validation import validate_document
from graspdsl.trials.dask_tasks import check
from graspdsl.trials.replay import Replay
from graspdsl.trials.runner import execute, new_run
from graspdsl.trials.store import RunFolder
from graspdsl.trials.workers import Dask, Workers
from graspdsl.worlds.kinds import WORLDS, absence

Said = Iterable[Diagnostic]
Act = Callable[[Path], Said]
NOWHERE = SpecFolder(Path("/nowhere"))
NAMING = floating("φ_h|τ_frx({γ1, γ2, γ3}) σ_fr({γ1, γ2, γ3})", until="force_residual: 0.05")
ORDINARY = NAMING.replace("φ_h", "φ_fr")
NINES = spec().replace("name: test", "name: nines")
THUMB = '<axis xyz="0 -1 0"/>'
COUPLED = HAND.replace("  thumb-bend: {weight: 10.0, closes: 1}\n", "").replace("[bend, thumb-bend]", "[bend]")
FOLLOWS = "couplings:\n  thumb-bend: {{follows: bend, ratio: {}}}\n"
SOLID = "<collision><geometry><sphere radius='0.04'/></geometry></collision>"
BAR = '<geom type="capsule" fromto="0 0 0 {}" size=".002" contype="0" conaffinity="0"/>'
LINKAGE = (
    '<mujoco><worldbody><body name="p"><geom size=".01"/>'
    f'<body name="a"><joint name="j" axis="0 1 0" range="0 60"/>{BAR.format("0 0 .05")}'
    f'<body name="c" pos="0 0 .05"><joint name="k" axis="0 1 0" range="-60 60"/>{BAR.format(".04 0 0")}</body></body>'
    f'<body name="r" pos=".04 0 0"><joint name="l" axis="0 1 0" range="-60 60"/>{BAR.format("0 0 .05")}</body>'
    '</body></worldbody>{}<actuator><motor joint="j" ctrlrange="-1 1"/></actuator></mujoco>'
)
LOOP = '<equality><connect body1="c" body2="r" anchor=".04 0 0"/></equality>'


def refused(act: Callable[[], object]) -> Said:
    """What an act says, or is refused with."""
    try:
        said = act()
    except (DiagnosticError, DescriptionFileError) as error:
        return error.diagnostics
    return [each for each in said if isinstance(each, Diagnostic)] if isinstance(said, tuple | list) else ()


def _formula(text: str) -> Act:
    return lambda _: refused(lambda: examine_expression(text))


def _spec(text: str) -> Act:
    return lambda folder: examine(text, "spec.yaml", (), folder).diagnostics


def _hand(model: str, hand: str) -> Act:
    def act(folder: Path) -> Said:
        (folder / "two.urdf").write_text(model, "utf-8")
        (folder / "hand.yaml").write_text(hand, "utf-8")
        try:
            return hand_in(SpecFolder(folder), "hand.yaml").warnings
        except DescriptionFileError as error:
            return error.diagnostics

    return act


def _mjcf(text: str) -> Act:
    return lambda _: model_in(text.encode(), NOWHERE, "hand.xml").warnings


def _guess(text: str) -> Act:
    return lambda _: refused(lambda: guessed_hand(model_in(text.encode(), NOWHERE, "hand.xml")))


def _parts(count: int) -> Act:
    def act(folder: Path) -> Said:
        (folder / "part.urdf").write_text(f"<robot name='part'><link name='a'>{SOLID * count}</link></robot>", "utf-8")
        return examine(spec(scene="world: bullet, object: {urdf: part.urdf}"), "spec.yaml", (), folder).diagnostics

    return act


def _plugin(text: str, **packages: object) -> Act:
    """A spec where a package is installed: a module, and what it offers."""

    def act(folder: Path) -> Said:
        for name, (module, offers) in packages.items():
            installed(folder / "site", module, offers, name=name)
        return examine(text, "spec.yaml", (), folder).diagnostics

    return act


def _compiled(gradient: str) -> Act:
    """A spec with a backend that compiles, where a potential of a package has such a gradient."""
    imports = "import numpy as np\nfrom graspdsl.arrays import namespace\n"
    module = f"{imports}{HUBER}\n    def gradient(self, error):\n        return {gradient}\n"

    def act(folder: Path) -> Said:
        installed(folder / "site", module, PHI, name="kit")
        program = examine(NAMING.replace("control: {}", "control: {backend: jax}"), "spec.yaml", (), folder).program
        found = missing_engine(program) if program else None
        return [found] if found else []

    return act


def _mounts(file: str) -> Act:
    def act(folder: Path) -> Said:
        place = folder / "mounts"
        place.mkdir()
        (place / "arm.urdf").write_text((folder / "arm.urdf").read_text("utf-8"), "utf-8")
        (place / file).write_text("mount: arm\nurdf: arm.urdf\nface: tool\n", "utf-8")
        return refused(lambda: mounts_in(place))

    return act


def _while_it_runs(then: Callable[[Path], object]) -> Act:
    """Do something to a run's folder while its trials are run."""

    def act(folder: Path) -> Said:
        place = folder / "new"
        return refused(
            lambda: g.run(folder / "floating.yaml", trials=2, out=place, workers=1, progress=lambda _: then(place))
        )

    return act


def _held(place: Path) -> Said:
    at_once = partial(sqlite3.connect, timeout=0.0)
    with patch("sqlite3.connect", at_once), closing(sqlite3.connect(place / "run" / "trials.sqlite")) as table:
        table.execute("BEGIN EXCLUSIVE")
        return refused(lambda: RunFolder.open(place / "run").records())


def _versions(version: str) -> Act:
    def act(folder: Path) -> Said:
        manifest = folder / "run" / "run.json"
        now = g.__version__
        manifest.write_text(
            manifest.read_text("utf-8").replace(f'"graspdsl": "{now}"', f'"graspdsl": "{version or now}"'), "utf-8"
        )
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            g.open_run(folder / "run")
        return [
            Diagnostic("run-unchecked", str(each.message), severity=Severity.WARNING)
            for each in told
            if "run-unchecked" in str(each.message)
        ]

    return act


def _engine(missing: str) -> Act:
    def act(_: Path) -> Said:
        with patch.dict(sys.modules, {missing: None} if missing else {}):
            found = absence(WORLDS["mujoco"])
        return [found] if found else []

    return act


def _seen(film: str, images: str, missing: str = "") -> Act:
    """A trial, as a film or as pictures; ``missing``: what is not installed."""

    def act(folder: Path) -> Said:
        pictures, place = (folder / name if name else None for name in (images, film))
        with patch.dict(sys.modules, {missing: None} if missing else {}):
            return refused(lambda: view_trial(folder / "run", 0, pictures, place, 1))

    return act


def _site(mkdocs: str) -> Act:
    """The documentation's site where mkdocs is a module of one's own."""

    def act(folder: Path) -> Said:
        package = folder / "site" / "mkdocs"
        package.mkdir(parents=True)
        (package / "__main__.py").write_text(mkdocs, "utf-8")
        (package / "__init__.py").touch()
        with patch.dict(os.environ, PYTHONPATH=str(package.parent)):
            os.environ.pop("DISPLAY", None)
            return refused(lambda: show_documentation(folder / "pages", path=False))

    return act


def _shown(images: str) -> Act:
    def act(folder: Path) -> Said:
        with patch.dict(os.environ):
            os.environ.pop("DISPLAY", None)
            return refused(lambda: view_object(str(folder / "part.obj"), folder / images if images else None))

    return act


def _real(sensing: str) -> Act:
    robot, sensor = (
        checked(spec(scene="world: bullet, object: towel-roll, mount: wam"), "").robot,
        WORLDS["bullet"].sensor,
    )
    return lambda _: refused(lambda: g.RealHand(robot, sensor(sensing)))


def _trial(number: int) -> Act:
    def act(folder: Path) -> Said:
        with Replay(RunFolder.open(folder / "run"), number) as replay:
            assert replay.ticks
        return ()

    return lambda folder: refused(lambda: act(folder))


def _begins(height: float) -> Act:
    text = spec("π_close|Γ Γ", scene="world: mujoco, object: towel-roll", start=f"height: {height}")
    return lambda _: refused(lambda: g.run(g.loads(text), trials=1, workers=1, progress=False))


def _shared_by(workers: Workers) -> Act:
    program = checked(floating() + "trials: {count: 1}\n", "spec.yaml")
    return lambda folder: refused(lambda: execute(new_run(folder / "shared", program), workers))


def _has_numpy(version: str) -> Act:
    return lambda _: refused(lambda: check({"the Dask worker": {"numpy": version}}, {"numpy": "2.3"}))


def _made_with(package: str) -> Act:
    """A spec in the folder of a run that had a potential of a package."""
    held = {"kind": "potentials", "name": "φ_h", "distribution": package, "version": "1.0", "digest": "0"}

    def act(folder: Path) -> Said:
        (folder / "run" / "run.json").write_text(json.dumps({"plugins": [held] if package else []}), "utf-8")
        return examine(NAMING if package else ORDINARY, "spec.yaml", (), folder / "run").diagnostics

    return act


class _Odd(Model):
    letter: str = Field(pattern="^[a-z]$")


def _odd(value: str) -> Act:
    return lambda _: refused(lambda: validate_document(parse_document(f"letter: {value}", "x.yaml"), _Odd))


FAILING = HUBER + "\n    def gradient(self, *_):\n        1 / 0\n"
FR = {"potentials": {**PHI["potentials"], "phi_fr": "kit:Huber"}}
BOTH = floating("φ_h|τ_frx(Γ) σ_fr(Γ) ◁ φ_fr|τ_frx(Γ) σ_fr(Γ)", until="force_residual: 0.05")
ARRANGED: Mapping[str, tuple[Act, Act]] = {
    "too-long": (_formula(" then ".join(["π_close|Γ Γ"] * 1000)), _formula("π_close|Γ Γ then π_close|Γ Γ")),
    "number-too-long": (_spec(NINES.replace("nines", "9" * 5000)), _spec(NINES)),
    "not-a-model": (_guess("<html/>"), _guess(GRIPPER)),
    "loop-coupled": (_mjcf(LINKAGE.replace("{}", LOOP)), _mjcf(LINKAGE.replace("{}", ""))),
    "mimic-beyond-limits": (
        _hand(changed(URDF, (THUMB, f'{THUMB}<mimic joint="bend" multiplier="-1"/>')), COUPLED),
        _hand(changed(URDF, (THUMB, f'{THUMB}<mimic joint="bend"/>')), COUPLED),
    ),
    "clipped-range": (_hand(URDF, COUPLED + FOLLOWS.format(1.02)), _hand(URDF, COUPLED + FOLLOWS.format(1.0))),
    "hidden-fingertip": (
        _hand(
            changed(URDF, ('<collision><geometry><sphere radius="0.01"/></geometry></collision>', "")),
            changed(HAND, ("sphere: {radius: 0.01}", "sphere: {centre: [0, 0, -0.02], radius: 0.004}")),
        ),
        _hand(URDF, HAND),
    ),
    "no-fingers": (_guess('<robot name="post"><link name="post"/></robot>'), _guess(GRIPPER)),
    "nothing-described": (_mounts("README.md"), _mounts("arm.yaml")),
    "too-many-parts": (_parts(201), _parts(1)),
    "too-many-links": (_hand(with_links(101), HAND), _hand(with_links(20), HAND)),
    "folder-in-use": (_while_it_runs(lambda run: g.resume(run, progress=False)), _while_it_runs(Path.exists)),
    "folder-gone": (
        _while_it_runs(lambda run: run.rename(run.with_name("elsewhere"))),
        _while_it_runs(Path.exists),
    ),
    "run-in-use": (_held, lambda folder: refused(lambda: RunFolder.open(folder / "run").records())),
    "run-unchecked": (_versions("0.0.1"), _versions("")),
    "unknown-trial": (_trial(99), _trial(0)),
    "no-trial-begins": (_begins(-0.05), _begins(0.1)),
    "no-display": (_shown(""), _shown("seen")),
    "no-scheduler": (_shared_by(Dask("cluster.json")), _shared_by(1)),
    "workers-differ": (_has_numpy("2.2"), _has_numpy("2.3")),
    "engine-missing": (_engine("mujoco"), _engine("")),
    "not-installed": (_seen("film.mp4", "", "imageio_ffmpeg"), _seen("", "seen", "imageio_ffmpeg")),
    "site-not-made": (_site("raise SystemExit('no')"), _site("")),
    "file-not-writable": (_seen("/proc/film.mp4", ""), _seen("", "seen")),
    "no-load-cells": (_real("exact"), _real("load-cell")),
    "wrong-value": (_odd("'1'"), _odd("a")),
    "plugin-clash": (
        _plugin(NAMING, kit=(HUBER, PHI), kit2=(HUBER, {"potentials": {"phi_h": "kit2:Huber"}})),
        _plugin(NAMING, kit=(HUBER, PHI)),
    ),
    "plugin-passed-over": (_plugin(BOTH, kit=(HUBER, FR)), _plugin(NAMING, kit=(HUBER, PHI))),
    "plugin-broken": (_plugin(NAMING, kit=("import kit_of_nobody", PHI)), _plugin(NAMING, kit=(HUBER, PHI))),
    "plugin-unfit": (_plugin(NAMING, kit=("def Huber(): ...", PHI)), _plugin(NAMING, kit=(HUBER, PHI))),
    "plugin-prints": (_plugin(NAMING, kit=(f"print('hello')\n{HUBER}", PHI)), _plugin(NAMING, kit=(HUBER, PHI))),
    "numpy-alone": (_compiled("np.tanh(error)"), _compiled("namespace(error).sin(error)")),
    "plugin-failed": (_plugin(NAMING, kit=(FAILING, PHI)), _plugin(NAMING, kit=(HUBER, PHI))),
    "plugin-missing": (_made_with("kit_of_nobody"), _made_with("")),
}
