"""Fill in docs/engines.md: what two engines, time steps and efforts of solvers make of the same specs.

Run it with the package installed, and name a folder that the runs go into: python docs/render_engines.py FOLDER. Runs
that are there go on or are not run again; all of them take a quarter of an hour on two cores.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from graspdsl.api.programs import load
from graspdsl.api.runs import Run, resume, run
from graspdsl.report.agreement import QUANTITIES, against
from graspdsl.report.judgements import Verdict
from graspdsl.report.summary import plain
from graspdsl.report.wording import NOTHING, percent, percents
from graspdsl.trials.store import MANIFEST

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "engines.md"
MAIN = ROOT / "specs" / "towel_roll_two_contacts.yaml"
TRIALS, SEED = 10, 11
BLOCK = re.compile(r"(<!-- ((?!end )\w+) -->\n).*?(?=<!-- end -->)", flags=re.S)
HEADS = ("", "pairs", "same outcome", "modes", *(quantity.label for quantity in QUANTITIES.values()))
BROKEN = {
    "friction 0.1 for 0.4": "scene.friction=0.1",
    "forces of 1 N for 0.5 N": "parameters.κ_f=1.0",
    "time step 20 ms for 2 ms": "scene.physics.time_step=0.02",
    "1 iteration of the solver": "scene.physics.solver_iterations=1",
}

Found = Mapping[str, Any]  # one run against another, as JSON has it


def ways(place: Path, spec: Path) -> Found:
    """What ``graspdsl engines`` says of a spec."""
    words = ["engines", str(spec), "--trials", str(TRIALS), "--seed", str(SEED), "--set", "evaluate=[]"]
    program = Path(sys.executable).with_name("graspdsl")
    subprocess.run([program, *words, "--out", str(place)], check=True, stdout=subprocess.DEVNULL)
    return dict(json.loads((place / "engines.json").read_text("utf-8")))


def row(title: str, found: Found) -> str:
    """What a run has in common with its measure, a cell for each quantity."""
    outcome, modes = found["outcome"], found["modes"]
    share = f"{percent(outcome['share'])} ({percents(outcome['interval'])})" if outcome["interval"] else NOTHING
    seen = ["/".join(f"{1e2 * side:.0f}" for side in mode["shares"]) + " %" for mode in modes["modes"]]
    cells = [title, str(outcome["pairs"]), marked(share, outcome), marked(", ".join(seen), modes)]
    for name, quantity in QUANTITIES.items():
        one, written = found["quantities"][name], quantity.written
        typical = written.written(one["typical"], with_unit=True)
        ends = f" ({' to '.join(map(written.text, one['interval']))})" if one["interval"] else ""
        cells.append(marked(f"{typical}{ends}", one))
    return f"| {' | '.join(cells)} |"


def marked(text: str, judged: Found) -> str:
    """A cell with the sign of its verdict before it."""
    return f"{Verdict(judged['judgement']['verdict']).mark.split()[0]} {text}"


def table(rows: Iterator[str] | Sequence[str]) -> str:
    """A table of rows."""
    return "\n".join([f"| {' | '.join(HEADS)} |", "|---|" + "---|" * (len(HEADS) - 1), *rows]) + "\n"


def rows_of(whole: Found) -> Iterator[str]:
    """A row for each run that is held against another."""
    for pair in whole["against"]:
        one, other = whole["runs"][pair["run"]]["label"], whole["runs"][pair["measure"]]["label"]
        yield row(f"{one} against {other}", pair)


def once(place: Path, *settings: str) -> Run:
    """A run of the main spec in MuJoCo."""
    if (place / MANIFEST).exists():
        return resume(place)
    program = load(MAIN, set=["scene.world=mujoco", f"trials.count={TRIALS}", f"trials.seed={SEED}", *settings])
    return run(program, out=place, workers=2)


def broken(place: Path) -> Iterator[str]:
    """Runs that differ from the spec's in what must be seen."""
    first = once(place / "as-it-is")
    for number, (title, setting) in enumerate(BROKEN.items()):
        other = once(place / str(number), setting)
        yield row(title, plain(against([(one.evidence, one.summary) for one in (first, other)], 1, 0)))


def filled(page: str, blocks: Mapping[str, str]) -> str:
    """The page with other texts below its marks."""
    return BLOCK.sub(
        lambda block: block[1] + (blocks[block[2]] if block[2] in blocks else block[0][len(block[1]) :]), page
    )


def main() -> None:
    """Run what is not there yet, and write the page."""
    place = Path(sys.argv[1])
    blocks = {
        "finer": table(rows_of(ways(place / MAIN.stem, MAIN))),
        "broken": table(broken(place / "broken")),
    }
    PAGE.write_text(filled(PAGE.read_text("utf-8"), blocks), "utf-8")


if __name__ == "__main__":
    main()
