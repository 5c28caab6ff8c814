"""Fill in docs/experiments.md: the chapter's claims, how each could have failed, and what runs say of them.

A comment in the page says what stands below it: ``<!-- claims -->`` what the code has of all experiments,
``<!-- results -->`` the verdicts of runs, a column a seed, ``<!-- changed -->`` those of runs with other settings than
a spec's; all up to ``<!-- end -->``.
Run it with the package installed, and name the folders of runs, of whole ``graspdsl experiments`` or the
conformance.json in them: python docs/render_experiments.py FOLDER...
Without any it fills in only what needs no run.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from graspdsl.api.runs import Run, open_run
from graspdsl.report.claims import Claim, held_against
from graspdsl.report.experiments_page import verdict
from graspdsl.report.points import EXPERIMENTS
from graspdsl.report.questions import TRIALS
from graspdsl.trials.store import MANIFEST

PAGE = Path(__file__).resolve().parent / "experiments.md"
NOT_ASKED = ("trials.", "evaluate=")  # settings that no claim depends on
BLOCK = re.compile(r"(<!-- ((?!end )\w+) -->\n).*?(?=<!-- end -->)", flags=re.S)


@dataclass(frozen=True, slots=True)
class Held:
    """The claims of an experiment held against a run: its seed, how many trials it has, and its own settings."""

    experiment: str
    seed: int
    trials: int
    settings: tuple[str, ...]
    claims: tuple[Claim, ...]


def held(run: Run) -> Held:
    """The claims of a run."""
    spec, manifest = run.program.spec, run.folder.manifest
    settings = tuple(each for each in manifest.overrides if not each.startswith(NOT_ASKED))
    claims = tuple(held_against(spec.name, run.evidence))
    return Held(spec.name, manifest.seed, len(run.evidence.records), settings, claims)


def runs_in(place: Path) -> Iterable[Run]:
    """The run in a folder, or the runs in the folders in it."""
    folder = place if place.is_dir() else place.parent
    for manifest in sorted({*folder.glob(MANIFEST), *folder.glob(f"*/{MANIFEST}")}):
        yield open_run(manifest.parent)


def claims_table() -> str:
    """What the chapter says of each experiment, over what a run is asked, and how it could fail."""
    parts = []
    for experiment, points in EXPERIMENTS.items():
        rows = [(point.says, point.source, point.over, point.could_fail or "it could not") for point in points]
        heads = ("the chapter says", "where", "over", "how it could have failed")
        parts.append(f"### {experiment}: {TRIALS[experiment]} trials in the chapter\n\n{_table(heads, rows)}")
    return "\n".join(parts)


def results(runs: Sequence[Held]) -> str:
    """What runs say of each experiment, a column a run."""
    parts = []
    for experiment in EXPERIMENTS:
        own = sorted((run for run in runs if run.experiment == experiment), key=lambda run: (run.seed, run.settings))
        if own:
            heads = ("the chapter says", "agrees if", *map(_head, own))
            parts.append(f"### {experiment}\n\n{_table(heads, _rows(own))}")
    if not any(run.settings for run in runs):
        seeds = sorted({run.seed for run in runs})
        parts += [_sentence(seed, [run for run in runs if run.seed == seed]) for seed in seeds]
    return "\n".join(parts)


def _sentence(seed: int, runs: Sequence[Held]) -> str:
    return f"Seed {seed}: {verdict([claim for run in runs for claim in run.claims])}\n"


def _head(run: Held) -> str:
    settings = ", ".join(f"`{setting}`" for setting in run.settings)
    return f"seed {run.seed}, {run.trials} trials{', ' if settings else ''}{settings}"


def _rows(runs: Sequence[Held]) -> Iterable[tuple[str, ...]]:
    for claims in zip(*(run.claims for run in runs), strict=True):
        yield claims[0].says, claims[0].bound, *(f"{claim.verdict.mark}: {claim.measured}" for claim in claims)


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "".join(f"| {' | '.join(cell.replace('|', '∣') for cell in line)} |\n" for line in lines)


def filled(page: str, blocks: Mapping[str, str]) -> str:
    """The text of a page with these blocks filled in."""

    def fill(found: re.Match[str]) -> str:
        return f"{found[1]}\n{blocks[found[2]]}\n" if found[2] in blocks else found[0]

    return BLOCK.sub(fill, page)


def main(places: Sequence[str]) -> None:
    """Write the page."""
    runs = [held(run) for place in places for run in runs_in(Path(place))]
    blocks = {"claims": claims_table()}
    as_it_is, changed = ([run for run in runs if bool(run.settings) is other] for other in (False, True))
    blocks |= {"results": results(as_it_is)} if as_it_is else {}
    blocks |= {"changed": results(changed)} if changed else {}
    PAGE.write_text(filled(PAGE.read_text("utf-8"), blocks), "utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
