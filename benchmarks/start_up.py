"""How long it takes until one can begin: commands and ``import graspdsl``, each in a process of its own, against the
import of the light libraries that all of it rests on.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from measuring import Row, in_turn, ratio_of, told

SPECS = Path(__file__).resolve().parents[1] / "specs"
MAIN, FLOATING = SPECS / "towel_roll_two_contacts.yaml", SPECS / "chapter" / "4_30_grasp_cartesian.yaml"
ROUNDS = 12
LIBRARIES = "import pydantic, typer, yaml, numpy"
COMMAND = "from graspdsl.cli import main; main()"
MEASURED = {
    "graspdsl validate": ("≤ 2", COMMAND, "validate", str(MAIN)),
    "graspdsl --help": ("", COMMAND, "--help"),
    "graspdsl explain": ("", COMMAND, "explain", str(MAIN)),
    "graspdsl list": ("", COMMAND, "list"),
    "graspdsl list effectors": ("", COMMAND, "list", "effectors"),
    "import graspdsl": ("", "import graspdsl"),
    "g.parse of a formula": ("", "import graspdsl as g; g.parse('π_s|Γ Γ (π_gx|Γ Γ)')"),
    "g.load of a floating spec": ("", "import graspdsl as g, sys; g.load(sys.argv[1])", str(FLOATING)),
    "g.compile of a controller": ("", "import graspdsl as g; g.compile('π_s|Γ Γ (π_gx|Γ Γ)')"),
}


def rows() -> Iterator[Row]:
    """Each against the libraries."""
    actions = {LIBRARIES: started(LIBRARIES), **{name: started(*what) for name, (_, *what) in MEASURED.items()}}
    times = in_turn(actions, ROUNDS, within=90.0)
    by = times[LIBRARIES]
    for name, (bound, *_) in MEASURED.items():
        note = f"{told(float(np.median(times[name])))}, {told(float(np.median(by)))}"
        yield ratio_of(f"{name} / python -c '{LIBRARIES}'", times[name], by, bound, note)


def started(code: str, *arguments: str) -> Callable[[], object]:
    """A process that runs some code, from its start to its end, with bytecode as an installed package has it."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}

    def run() -> object:
        return subprocess.run(
            [sys.executable, "-c", code, *arguments], capture_output=True, check=True, env=environment
        )

    return run
