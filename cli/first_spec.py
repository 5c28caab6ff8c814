"""A spec to begin with: written for an object, a hand, a world and a controller, or one of those that ship."""

from __future__ import annotations

import os
import re
import shlex
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path, PurePosixPath
from typing import TypeVar

import typer

from graspdsl.basis.prelude import Definition, prelude
from graspdsl.cli.beginnings import refuse_spec
from graspdsl.cli.inputs import judged
from graspdsl.cli.messages import complain, result, say
from graspdsl.compiler.program import Examination, Program, examine
from graspdsl.compiler.surroundings import OBJECT
from graspdsl.diagnostics import (
    Diagnostic,
    DiagnosticError,
    Severity,
    known_names_hint,
    listed,
    on_one_line,
    reading,
)
from graspdsl.hands.description_files import DescriptionFileError
from graspdsl.hands.descriptions import Hand, hands
from graspdsl.hands.fingertip_motion import FingertipMotion
from graspdsl.hands.first_spec import GRASP, FirstSpec, Phases, scene_lines, yaml_text
from graspdsl.hands.hand_files import hand_in
from graspdsl.models.mesh_files import FORMATS
from graspdsl.notation.names import canonical
from graspdsl.objects.shapes import catalogue
from graspdsl.places.files import SpecFolder
from graspdsl.places.folders import names_a_file
from graspdsl.places.wording import slug
from graspdsl.plugins.adoption import adopted_all
from graspdsl.plugins.kinds import KINDS, OF_OTHERS
from graspdsl.report.writing import replace as write_files
from graspdsl.spec.formatting import formatted
from graspdsl.spec.scene import Scene
from graspdsl.spec.shipped import shipped, shipped_specs
from graspdsl.trials.setup import settings_of
from graspdsl.worlds.first_start import first_start, opposing_first
from graspdsl.worlds.kinds import WORLDS, rigid_bodies
from graspdsl.worlds.protocol import InfeasibleStartError, UnstableObjectError
from graspdsl.worlds.rigid.kind import RigidBodies

PLACE = Path("grasp.yaml")
BEARABLE = 1.0  # m: a mesh that is longer is in millimetres
NOTES = {
    "world": "see: graspdsl list worlds",
    "hand": "see: graspdsl list hands; or a hand file, as graspdsl init hand writes them",
    "object": "see: graspdsl list objects; or {cylinder: {diameter: 0.10, height: 0.20}, mass: 0.5}, {mesh: {file: …}}",
    "friction": "between fingertips and object",
    "sensing": "see: graspdsl list sensing",
}
CONDITIONS = (
    "force_residual: 0.1, moment_residual: 0.005, force_error: 0.1",
    "force_residual: 0.1, moment_residual: 0.005",
    "force_residual: 0.1, force_error: 0.1",
    "force_residual: 0.1",
    "moment_residual: 0.005",
    "contact: all, force_error: 0.1",
    "contact: all",
)


@dataclass(frozen=True, slots=True)
class Wishes:
    """What a spec is to be of; what is None is asked for at a terminal, else as usual."""

    object: str | None = None
    hand: str | None = None
    world: str | None = None
    sensing: str | None = None
    controller: str | None = None


def init_spec(file: Path | None, wishes: Wishes, *, shipped_as: str | None, force: bool) -> None:
    """Write a spec that validates and runs, and say what to do with it. Raises DiagnosticError where it cannot."""
    place = file or PLACE
    refuse_spec("my_grasp.yaml", place, force=force)
    text = shipped(shipped_as).text if shipped_as is not None else _made(place, wishes)
    with reading(str(place)):
        write_files(place.parent, {place.name: text.encode()})
    source, diagnostics = judged(place)
    complain(str(place), source, diagnostics)
    result(on_one_line(str(place)))
    name = shlex.quote(str(place))
    say(on_one_line(f"next: graspdsl explain {name}"))
    say(on_one_line(f"      graspdsl run {name}"))


def _made(place: Path, wishes: Wishes) -> str:
    complain("graspdsl", "", adopted_all(KINDS))
    asks = sys.stdin is not None and sys.stdin.isatty() and sys.stdout.isatty()
    return formatted(_Making(place, wishes, _asked if asks else _usual).spec.text())


Known = Callable[[], Mapping[str, str]]  # names, with a line on each
Choose = Callable[[str, "str | None", Known, str], str]


def _usual(what: str, wish: str | None, known: Known, usual: str) -> str:
    del what, known
    return usual if wish is None else wish


def _asked(what: str, wish: str | None, known: Known, usual: str) -> str:
    """What was wished for, or what is chosen at the terminal, where one is asked again after a slip."""
    if wish is not None:
        return wish
    names = known()
    for name, about in names.items():
        say(on_one_line(f"  {name}: {about}" if about else f"  {name}"))

    def one_of_these(said: str) -> str:
        if {said, canonical(said)} & {*names} or said.startswith("{") or PurePosixPath(said).suffix:
            return said
        raise typer.BadParameter(known_names_hint(said, names, f"{what}s"))

    return str(typer.prompt(what, default=usual, err=True, value_proc=one_of_these))


class _Making:
    """The spec that is wished for, and what is known of it on the way."""

    def __init__(self, place: Path, wishes: Wishes, choose: Choose) -> None:
        self._place = place
        worlds = {name: kind.about for name, kind in WORLDS.items() if not kind.missing}
        world = choose("world", wishes.world, lambda: worlds, rigid_bodies().name)
        self._kind = kind = _known(world, WORLDS, "world")
        suiting = {name: hand for name, hand in hands().items() if bool(hand.urdf) == kind.has("hand")}
        usual = str(Scene.model_fields["hand"].default)
        first = usual if usual in suiting else next(iter(suiting))
        hand = choose("hand", wishes.hand, lambda: {name: known.about for name, known in suiting.items()}, first)
        bodies = {name: body.about for name, body in catalogue().items() if kind.has("edges") or not body.shape.edged}
        thing = choose("object", wishes.object, lambda: bodies, OBJECT if OBJECT in bodies else next(iter(bodies)))
        sense = choose("sensing", wishes.sensing, lambda: dict.fromkeys(kind.senses, ""), kind.senses[0])
        self._scene = {"world": world, "hand": self._hand(hand), "object": self._object(thing)}
        self._scene |= {"friction": "0.4"} if kind.has("friction") else {}
        self._scene |= {"sensing": sense} if sense != kind.senses[0] else {}
        self._virtual, self._start = False, list[str]()
        self._contacts = list(self._described(hand).contacts)
        drafted = self._drafted()
        self._around(drafted)
        chosen = choose(
            "controller",
            wishes.controller,
            lambda: {name: known.about for name, known in _controllers().items()},
            self._usual_controller,
        )
        self.spec = self._with_controller(chosen)

    # The scene

    def _hand(self, choice: str) -> str:
        return yaml_text(self._named(choice)) if names_a_file(choice) else choice

    def _object(self, choice: str) -> str:
        if choice.lstrip().startswith("{") or choice in catalogue():
            return choice
        suffix = PurePosixPath(choice).suffix.lower()
        if suffix in FORMATS:
            return f"{{mesh: {{file: {yaml_text(self._named(choice))}}}}}"
        if suffix in (".urdf", ".xml"):
            return f"{{{'urdf' if suffix == '.urdf' else 'mjcf'}: {yaml_text(self._named(choice))}}}"
        _known(choice, catalogue(), "object")
        return choice

    def _named(self, file: str) -> str:
        """How the spec names a file: by where it is below the spec's folder, else by its absolute path."""
        whole, folder = Path(os.path.realpath(file)), Path(os.path.realpath(self._place.parent))
        return whole.relative_to(folder).as_posix() if whole.is_relative_to(folder) else str(whole)

    def _described(self, choice: str) -> Hand:
        if not names_a_file(choice):
            return _known(choice, hands(), "hand")
        files, name = SpecFolder(self._place.parent), self._named(choice)
        try:
            with reading(choice):
                return hand_in(files, name).hand
        except DescriptionFileError as error:
            raise DiagnosticError(error.diagnostics, choice, error.text) from None

    def _drafted(self) -> Program:
        """The program of a spec with this scene. Raises DiagnosticError where there can be none."""
        found = self._examined(self._usual)
        mesh = self._scene["object"].startswith("{mesh:")
        if mesh and found.program is not None and max(found.program.body.shape.extent) > BEARABLE:
            self._scene["object"] = self._scene["object"].replace("}}", ", scale: 0.001}}")
            found = self._examined(self._usual)
        if found.program is None:
            told = [replace(fault, span=None) for fault in found.diagnostics if fault.severity is Severity.ERROR]
            raise DiagnosticError(told, ", ".join(self._scene[key] for key in ("world", "hand", "object")))
        return found.program

    def _around(self, drafted: Program) -> None:
        """How the contacts are around the object when a trial begins."""
        if not drafted.robot.has_model:
            return
        self._contacts, aligned = opposing_first(FingertipMotion(drafted.robot), self._contacts)
        if not isinstance(self._kind, RigidBodies):
            return
        try:
            start = first_start(self._kind, settings_of(drafted), side=aligned)
        except (InfeasibleStartError, UnstableObjectError) as error:
            message = f"no start was found for this hand at this object: {error}"
            raise DiagnosticError([Diagnostic("no-start", message, hint="choose another object, or hand")]) from None
        self._virtual, self._start = aligned and start.approach == "side", start.lines()

    # The controller

    @property
    def _usual_controller(self) -> str:
        return "π_sgx" if self._kind.has("forces") else "π_gx"

    @property
    def _usual(self) -> Phases:
        if self._kind.has("forces"):
            return GRASP
        return self._phases(prelude()["π_gx"], CONDITIONS[1], probes=False)

    def _phases(self, known: Definition, until: str, *, probes: bool) -> Phases:
        forces = self._kind.has("forces")
        reference = " (π_gx|Γ Γ)" if known.head.reference else ""
        about = f"{known.head.name.text}, {known.about}" + (f" (Eq. {known.equation})" if known.equation else "")
        return Phases(
            f"{known.head.name.text}|Γ Γ{reference}",
            f"{{{until}, hold: {1.0 if forces else 0.4}}}",
            (120.0 if probes else 30.0) if forces else 20.0,
            about,
            forces,
            probes,
        )

    def _fits(self, known: Definition) -> Phases | None:
        """The program of a controller that is sound here and waits for what the controller brings about."""
        if len(known.head.effector) != 1 or len(known.head.sensor) != 1:
            return None
        before = {fault.code for fault in self._examined(self._usual).diagnostics}
        for probes, until in product((False, True), CONDITIONS):
            phases = self._phases(known, until, probes=probes)
            found = self._examined(phases)
            if found.program is not None and {fault.code for fault in found.diagnostics} <= before:
                return phases
        return None

    def _with_controller(self, chosen: str) -> FirstSpec:
        if canonical(chosen) == self._usual_controller:
            return self._spec(self._usual)
        known = _known(canonical(chosen), _controllers(), "controller")
        phases = self._fits(known)
        if phases is None:
            shows = next((name for name, spec in shipped_specs().items() if known.equation in spec.shows), None)
            message = f"{known.head.name.text} needs more than contacts in the {self._kind.name} world here"
            hint = f"begin with the chapter's spec: graspdsl init --from {known.equation}" if shows else None
            raise DiagnosticError([Diagnostic("controller-needs-more", message, hint=hint)])
        return self._spec(phases)

    # The spec

    def _examined(self, phases: Phases) -> Examination:
        return examine(self._spec(phases).text(), self._place.name, (), self._place.parent)

    def _spec(self, phases: Phases) -> FirstSpec:
        things = f"{listed(self._contacts)} on {_called(self._scene['object'])}"
        way = f", from {'the side' if self._start[0].endswith('side') else 'above'}" if self._start else ""
        return FirstSpec(
            slug(self._place.stem) or "grasp",
            f"{things}{way}.",
            scene_lines(self._scene, NOTES),
            self._contacts,
            self._virtual,
            phases,
            ("force-closure", "lift") if self._kind.has("lifting") else (),
            8 if self._kind.has("hand") else 20,
            self._start,
        )


def _controllers() -> dict[str, Definition]:
    return {**prelude(), **OF_OTHERS}


def _called(thing: str) -> str:
    return f"the {thing}" if re.fullmatch(r"[\w-]+", thing) else "an object"


T = TypeVar("T")


def _known(name: str, known: Mapping[str, T], what: str) -> T:
    if name not in known:
        message, hint = f"there is no {what} {name!r}", known_names_hint(name, known, f"{what}s")
        raise DiagnosticError([Diagnostic(f"unknown-{what}", message, hint=hint)])
    return known[name]
