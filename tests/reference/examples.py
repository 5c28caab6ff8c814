"""What is said of the examples of diagnostics: each text put to use as a user would put it."""

from __future__ import annotations

import atexit
import io
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from contextlib import ExitStack, redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path

from compiler.specs import floating, spec
from hands.arms import FILE as MOUNT
from hands.arms import arm, urdf
from hands.models import HAND, URDF
from plugins.packages import HUBER
from stored_runs import stored_run
from typer import Exit

import graspdsl
from graspdsl.cli.app import app
from graspdsl.compiler.program import examine, examine_expression
from graspdsl.diagnostics import Diagnostic, Severity
from graspdsl.hands.hand_files import hand_in
from graspdsl.hands.mount_files import mount_in
from graspdsl.models.reading import read_model
from graspdsl.places.files import SpecFolder
from graspdsl.reference.diagnostics import Example
from reference.arranged import ARRANGED, refused

Said = Iterable[Diagnostic]
SPEC = spec("π_close|Γ Γ")
SPECS = Path(__file__).parents[2] / "specs"
FLOATING = SPECS / "compare" / "cstar.yaml"
EXPERIMENT = SPECS / "experiments" / "4_detergent_bottle.yaml"
# Commands that begin runs, which are not waited for: they are given what is no folder, and refuse that last of all.
BEGINNING = ("engines", "experiments", "map")
NOWHERE, REFUSED = ("--out", "spec.yaml"), "folder-not-writable"
TOLD = re.compile(r"(error|warning)\[(\S+)\]: ")
BALL = """\
<robot name="part">
  <link name="a"><collision><geometry><sphere radius="0.04"/></geometry></collision></link>
</robot>
"""
TETRAHEDRON = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
CONE = "v 0 0 0\nv 0.1 0 0.1\nv -0.05 0.08 0.1\nv -0.05 -0.08 0.1\nf 1 2 4\nf 1 4 3\nf 1 3 2\nf 2 3 4\n"
ARM = """\
<robot name="arm"><link name="foot"/><link name="slide"/><link name="tool"/>
<joint name="out" type="prismatic"><parent link="foot"/><child link="slide"/><axis xyz="1 0 0"/>
<limit lower="-0.5" upper="0.5" effort="99" velocity="1"/></joint>
<joint name="tool-at" type="fixed"><parent link="slide"/><child link="tool"/></joint></robot>
"""
KEY = re.compile(r"\S[^:\n]*", re.M)
MJCF = """\
<mujoco>
  <worldbody>
    <body name="palm"><geom type="box" size="0.03 0.03 0.01"/><site name="here"/>
      <body name="finger" pos="0.03 0 0"><joint name="bend" axis="0 1 0" range="-30 60"/><geom size="0.01"/>
        <body name="tip" pos="0 0 0.05"><joint name="curl" axis="0 1 0" range="-30 60"/><geom size="0.01"/>
          <site name="there"/></body></body>
    </body>
  </worldbody>
  <actuator><motor joint="bend" ctrlrange="-2 2"/><motor joint="curl" ctrlrange="-2 2"/></actuator>
</mujoco>
"""


def changed(base: str, right: str, wrong: str) -> str:
    """A sound text, its right place made wrong."""
    assert base.count(right) == 1, f"{base.count(right)} times in the file: {right}"
    return base.replace(right, wrong)


def _sections(text: str) -> dict[str, str]:
    """The top-level parts of a YAML text by their keys; a line that is no key belongs to the part before."""
    found: dict[str, str] = {}
    key = ""
    for line in text.splitlines(keepends=True):
        if (match := KEY.match(line)) and not line.startswith(("}", "]", "- ")):
            key = match[0] if match[0] not in found else key
        found[key] = found.get(key, "") + line
    return found


def whole(part: str) -> str:
    """A sound spec with a part of it as an example has it."""
    own = _sections(part + "\n")
    rest = [text for key, text in _sections(SPEC).items() if key not in own]
    return "".join([*rest, *own.values()])


def _formula(text: str) -> Said:
    examine_expression(text)
    return ()


def _hand(folder: Path, hand: str = HAND, model: str = URDF) -> Said:
    (folder / "two.urdf").write_text(model, "utf-8")
    (folder / "hand.yaml").write_text(hand, "utf-8")
    return hand_in(SpecFolder(folder), "hand.yaml").warnings


def _mount(folder: Path, mount: str) -> Said:
    (folder / "arm.urdf").write_text(urdf(arm()), "utf-8")
    (folder / "arm.yaml").write_text(mount, "utf-8")
    return mount_in(SpecFolder(folder), "arm.yaml").warnings


def _mjcf(folder: Path, text: str) -> Said:
    (folder / "hand.xml").write_text(text, "utf-8")
    return read_model(SpecFolder(folder), "hand.xml").warnings


def _object(folder: Path, name: str, thing: str, text: str) -> Said:
    (folder / name).write_text(text, "utf-8")
    return examine(whole(f"scene: {{world: bullet, object: {thing}}}"), "spec.yaml", (), folder).diagnostics


def _command(folder: Path, text: str) -> Said:
    """Line by line; what are no commands of graspdsl are the shell's."""
    told, ignored = "", set[str]()
    for line in text.split("\n"):
        first, *words = shlex.split(line)
        if first != "graspdsl":
            subprocess.run(["bash", "-c", line], cwd=folder, check=True)
            continue
        if words[0] in BEGINNING and not {"--resume", "--out"} & {*words}:
            words += NOWHERE
            ignored.add(REFUSED)
        told += _told(words)
    found = [Diagnostic(code, "", severity=Severity(kind)) for kind, code in TOLD.findall(told)]
    return [said for said in found if said.code not in ignored]


def _told(words: list[str]) -> str:
    """What a command says, its results where ">" sends them."""
    said = io.StringIO()
    words, place = (words[:-2], words[-1]) if ">" in words else (words, "")
    with ExitStack() as stack:
        out = stack.enter_context(open(place, "w", encoding="utf-8")) if place else said
        stack.enter_context(redirect_stderr(said))
        stack.enter_context(redirect_stdout(out))
        ended = _ended(words)
    assert ended in (0, 1), said.getvalue()
    return said.getvalue()


def _ended(words: list[str]) -> int:
    """The exit code of a command."""
    try:
        app(words, standalone_mode=False)
    except Exit as end:
        return end.exit_code
    return 0


def _python(text: str) -> Said:
    with redirect_stderr(io.StringIO()):  # where progress is shown
        exec(text, {"graspdsl": graspdsl, "pathlib": pathlib})
    return ()


@cache
def _run() -> Path:
    """A run that is kept for as long as the tests last."""
    kept = tempfile.mkdtemp(prefix="graspdsl-tests-")
    atexit.register(shutil.rmtree, kept)
    return stored_run(Path(kept) / "run", FLOATING, "trials.count=1").path


def furnish(folder: Path) -> None:
    """Put into a folder what the examples name: specs, models, meshes and a run."""
    texts = {
        "spec.yaml": SPEC,
        "floating.yaml": floating(until="force_residual: 0.1"),
        "coded.yaml": floating(until="force_residual: 0.1") + "code: [mine.py]\n",
        "meshes.yaml": whole("scene: {world: bullet, object: {mesh: {file: part.obj}}}"),
        "4.yaml": EXPERIMENT.read_text("utf-8"),
        "mine.py": HUBER,
        "two.urdf": URDF,
        "arm.urdf": ARM,
        "post.urdf": '<robot name="post"><link name="post"/></robot>',
        "part.urdf": BALL,
        "part.obj": TETRAHEDRON,
        "cone.obj": CONE,
        "part.step": "ISO-10303-21;",
        "part.sdf": "<sdf/>",
    }
    for name, text in texts.items():
        (folder / name).write_text(text, "utf-8")
    shutil.copytree(_run(), folder / "run")


def _said(folder: Path, form: str, right: str, text: str) -> Said:
    """What is said of a text of one of the forms; ``right``: the place of a sound file that it is put in."""
    match form:
        case "formula":
            return _formula(text)
        case "spec":
            return examine(whole(text), "spec.yaml", (), folder).diagnostics
        case "spec file":
            return examine(text, "spec.yaml", (), folder).diagnostics
        case "setting":
            return examine(SPEC, "spec.yaml", (text,), folder).diagnostics
        case "hand file":
            return _hand(folder, changed(HAND, right, text))
        case "hand URDF":
            return _hand(folder, model=changed(URDF, right, text))
        case "hand MJCF":
            return _mjcf(folder, changed(MJCF, right, text))
        case "mount file":
            return _mount(folder, changed(MOUNT, right, text))
        case "object URDF":
            return _object(folder, "part.urdf", "{urdf: part.urdf}", text)
        case "object OBJ":
            return _object(folder, "part.obj", "{mesh: {file: part.obj}}", text)
        case "command":
            return _command(folder, text)
        case _:
            return _python(text)


def said(folder: Path, example: Example, *, wrong: bool) -> tuple[Diagnostic, ...]:
    """All that is said of one of an example's texts, in a folder that is furnished for it."""
    if example.form == "words":
        return tuple(ARRANGED[example.code][not wrong](folder))
    text = example.wrong if wrong else example.right
    return tuple(refused(lambda: _said(folder, example.form, example.right, text)))
