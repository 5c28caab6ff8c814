"""Files to begin with: a hand or mount file guessed from a model, and a spec that goes with a hand."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path

from graspdsl.cli.beginnings import found_model, refuse_place
from graspdsl.cli.inputs import judged
from graspdsl.cli.messages import WRONG_INPUT, complain, result, say
from graspdsl.cli.viewing import view_hand
from graspdsl.diagnostics import Diagnostic, DiagnosticError, has_errors, known_names_hint, on_one_line, reading
from graspdsl.hands.guess import guessed_hand
from graspdsl.hands.guess_file import hand_text, spec_text
from graspdsl.hands.mount_guess import guessed_mount, mount_text
from graspdsl.models.joint_kinds import HINGES
from graspdsl.places.wording import slug
from graspdsl.report.writing import replace
from graspdsl.worlds.kinds import rigid_bodies


def init_hand(model: Path, out: Path | None, root: str) -> int:
    """Write a hand file guessed from a URDF or MJCF, a spec beside it, and pictures of the hand open and closed.

    Returns the exit code: that of a hand file which still asks for something is the one of wrong input.
    """
    place = out or Path(f"{slug(model.stem) or 'hand'}.yaml")
    name = slug(place.stem) or "hand"
    spec = place.with_name(f"{place.stem}_grasp.yaml")
    pictures = [place.with_name(f"{place.stem}-{posture}.png") for posture in ("open", "closed")]
    refuse_place("my_hand.yaml", place, spec, *pictures)
    with reading(str(model)):
        named, found = found_model(model, place, root)
        guess = guessed_hand(found)
        if not root and any(found.joints[joint].kind in HINGES for joint in found.movers(guess.palm)):
            root = guess.palm
            guess = guessed_hand(found_model(model, place, root)[1])
    grasp = spec_text(guess, f"{name}-grasp", place.name, rigid_bodies().name)
    _write({place: hand_text(guess, name, _key(model), named, root), spec: grasp})
    if _asks(place, warn=False):
        return WRONG_INPUT
    view_hand(str(place), place.parent)
    say(on_one_line(f"next: graspdsl run {shlex.quote(str(spec))}"))
    return 0


def init_mount(model: Path, out: Path | None, face: str) -> int:
    """Write a mount file guessed from a URDF or MJCF; ``face``: the link that the hand is fixed to, empty for a guess.

    Returns the exit code: that of a file which still asks for something is the one of wrong input.
    """
    name = slug((out or model).stem) or "arm"
    place = out or Path(f"{name}.yaml")
    refuse_place("my_arm.yaml", place)
    with reading(str(model)):
        named, found = found_model(model, place, "")
        if face and face not in found.links:
            message, hint = f"there is no link {face!r} in the model", known_names_hint(face, found.links, "links")
            raise DiagnosticError([Diagnostic("unknown-link", message, hint=hint)])
        guess = guessed_mount(found, face)
    _write({place: mount_text(guess, name, _key(model), named)})
    if _asks(place, warn=True):
        return WRONG_INPUT
    say(on_one_line(f"next, in a spec: mount: {place.name}"))
    return 0


def _key(model: Path) -> str:
    return "mjcf" if model.suffix == ".xml" else "urdf"


def _write(texts: Mapping[Path, str]) -> None:
    for place, text in texts.items():
        with reading(str(place)):
            replace(place.parent, {place.name: text.encode()})
        result(on_one_line(str(place)))


def _asks(place: Path, *, warn: bool) -> bool:
    """Whether a file that was written still asks for something, which is told then; ``warn``: doubts are, too."""
    source, diagnostics = judged(place)
    asks = has_errors(diagnostics)
    if asks or warn:
        complain(str(place), source, diagnostics)
    if asks:
        say(on_one_line(f"mend {place}, then: graspdsl validate {shlex.quote(str(place))}"))
    return asks
