"""What a formula outside a spec is compiled for: the part of a spec that would stand around it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt
import yaml

from graspdsl.compiler.declarations import DEFAULT_WORLD, default_scene

OBJECT = "towel-roll"


def _usual_resources() -> Mapping[str, str]:
    return {entry.key.text: entry.value.text for entry in default_scene().resources}


def _usual_parameters() -> Mapping[str, npt.ArrayLike]:
    return {name: values or () for name, values in default_scene().parameters.items()}


@dataclass(frozen=True)
class Surroundings:
    """A hand on a mount, and what formulas may name.

    resources: by default those of the default scene; None for all contacts of any hand, γ1, γ2 … in their order, and Γ
    all of them. control: keys of a spec's ``control``. held: whether the object
    is fixed to the hand, by default where the formula turns contacts or senses gravity.
    """

    hand: str = "barrett"
    mount: str = "gantry"
    resources: Mapping[str, str] | None = field(default_factory=_usual_resources)
    parameters: Mapping[str, npt.ArrayLike] = field(default_factory=_usual_parameters)
    control: Mapping[str, Any] = field(default_factory=dict)
    held: bool | None = None

    def written(self, formula: str, *, held: bool, displacement: str) -> str:
        """The spec of one phase, the formula, in YAML."""
        return yaml.safe_dump(
            {
                "graspdsl": 1,
                "name": "formula",
                "scene": {
                    "world": DEFAULT_WORLD,
                    "hand": self.hand,
                    "mount": self.mount,
                    "object": {"like": OBJECT, "held": held},
                },
                "resources": dict(self.resources or {}),
                "parameters": {name: _plain(value) for name, value in self.parameters.items()},
                "control": {
                    "displacement": displacement,
                    **{key: _plain(value) for key, value in self.control.items()},
                },
                "program": [{"run": formula, "until": {"contact": "all"}}],
            },
            allow_unicode=True,
            sort_keys=False,
        )

    def of_all(self, contacts: Sequence[str]) -> Surroundings:
        """The same with a resource for each contact, and Γ all of them."""
        named = {f"γ{place}": contact for place, contact in enumerate(contacts, 1)}
        return replace(self, resources={**named, "Γ": f"{{{', '.join(named)}}}"})


USUAL = Surroundings()


def _plain(value: Any) -> object:
    """A number or a vector, if of numpy's, as YAML writes it."""
    return np.asarray(value).tolist()
