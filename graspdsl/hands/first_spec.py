"""The text of a spec to begin with: a grasp by a hand's contacts, and where its trials start."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from textwrap import wrap

PRESS = 0.5  # N, of each contact
_PLAIN = re.compile(r"[A-Za-z_](?:[\w.-]*[\w])?")
_WORDS = {"true", "false", "yes", "no", "on", "off", "null", "y", "n"}
_WIDEST = 110  # characters


@dataclass(frozen=True, slots=True)
class Phases:
    """What the contacts do: a formula over Γ, the conditions of its end and its time limit [s].

    closes: whether they close first, pressing; probes: whether they are displaced by probing.
    """

    formula: str
    until: str
    limit: float
    about: str
    closes: bool = True
    probes: bool = False


GRASP = Phases(
    "π_s|Γ Γ (π_gx|Γ Γ)",
    "{force_residual: 0.1, moment_residual: 0.005, force_error: 0.1, hold: 1.0}",
    30.0,
    "they slide to where forces and moments balance (Eq. 4.31)",
)


@dataclass(frozen=True, slots=True)
class FirstSpec:
    """A spec to begin with.

    scene, start: the lines of these sections. contacts: of the hand, the one that opposes the others first; virtual:
    the others are one virtual contact. evaluate: grades.
    """

    name: str
    about: str
    scene: Sequence[str]
    contacts: Sequence[str]
    virtual: bool
    phases: Phases
    evaluate: Sequence[str]
    count: int
    start: Sequence[str]

    def text(self) -> str:
        """The spec in YAML."""
        return "\n".join(
            [
                "# To check it: graspdsl validate; what its formulas mean: graspdsl explain; to run it: graspdsl run.",
                "graspdsl: 1",
                f"name: {yaml_name(self.name)}",
                f"about: {yaml_text(self.about)}",
                "",
                "scene:",
                *(f"  {line}" for line in self.scene),
                "",
                *self._resources(),
                *(["", "parameters:", f"  κ_f: {PRESS} # N, what each contact presses with"] if self._presses else []),
                *(["", "control: {displacement: probing}"] if self.phases.probes else []),
                "",
                *self._program(),
                *(["", f"evaluate: [{', '.join(self.evaluate)}]"] if self.evaluate else []),
                "",
                "trials:",
                f"  count: {self.count}",
                "  seed: 1",
                *(
                    ["  start: # drawn anew for each trial", *(f"    {line}" for line in self.start)]
                    if self.start
                    else []
                ),
                "",
            ]
        )

    @property
    def _presses(self) -> bool:
        return self.phases.closes

    def _resources(self) -> Sequence[str]:
        greek = [f"γ{number + 1}" for number in range(len(self.contacts))]
        others = ", ".join(greek[1:])
        virtual = self.virtual and len(greek) > 2
        return [
            "# Names for contacts and for sets of them"
            + (f"; <{others}> is one virtual contact, their mean." if virtual else "."),
            "resources:",
            *(f"  {each}: {yaml_name(contact)}" for each, contact in zip(greek, self.contacts, strict=True)),
            f'  Γ: "{{{", ".join([greek[0], f"<{others}>" if virtual else others])}}}"',
        ]

    def _program(self) -> Sequence[str]:
        phases = self.phases
        close = ["  - run: π_close|Γ Γ", "    until: {contact: all, hold: 0.2}", "    limit: 8.0 # s"]
        again = phases.formula == close[0].removeprefix("  - run: ")
        about = "The contacts close until all touch" if phases.closes else phases.about
        about += f"; then {phases.about}" if phases.closes and not again else ""
        return [
            *(f"# {line}" for line in wrap(f"{about}.", _WIDEST)),
            "program:",
            *(close if phases.closes else []),
            *(
                []
                if again
                else [
                    f"  - run: {phases.formula}",
                    f"    until: {phases.until}",
                    f"    limit: {phases.limit:.1f}{'' if phases.closes else ' # s'}",
                ]
            ),
        ]


def scene_lines(choices: Mapping[str, str], notes: Mapping[str, str]) -> list[str]:
    """The lines of a scene: its keys with their values in YAML, and a note on some of them, behind it or above."""
    lines = []
    for key, value in choices.items():
        line, note = f"{key}: {value}", notes.get(key, "")
        above = len(line) + len(note) > _WIDEST - 5
        lines += [f"# {note}"] if note and above else []
        lines.append(f"{line} # {note}" if note and not above else line)
    return lines


def yaml_name(text: str) -> str:
    """A name of a model or a file as YAML reads it back."""
    return text if _PLAIN.fullmatch(text) and text.lower() not in _WORDS else yaml_text(text)


def yaml_text(text: str) -> str:
    """A text in quotes, as YAML reads it back."""
    return json.dumps(text, ensure_ascii=False)
