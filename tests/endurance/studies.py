"""What is run again and again: short studies, what is kept of them, and whether that is what it has to be."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from cli.program import ROOT, graspdsl

from graspdsl.report.evidence import evidence_of
from graspdsl.report.summary import plain, summarised
from graspdsl.trials.health import Verdict, examined
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.store import RunFolder

CHAPTER = ROOT / "specs" / "chapter"
RUN = "run"  # the name of a folder

Kept = dict[int, tuple[str, str]]  # of each trial its record but for its wall time, and a digest of its trajectory


class DifferenceError(Exception):
    """A run is not what it has to be; says how."""


def demand(holds: bool, otherwise: str) -> None:
    """Raises DifferenceError where something does not hold."""
    if not holds:
        raise DifferenceError(otherwise)


@dataclass(frozen=True)
class Study:
    """A spec with so many trials, and settings that make them short."""

    name: str
    spec: Path
    trials: int
    settings: tuple[str, ...] = ()

    def words(self) -> Sequence[str | Path]:
        """The command that begins it in the working directory."""
        settings = [word for setting in self.settings for word in ("--set", setting)]
        return ["run", self.spec, "--trials", str(self.trials), *settings, "--out", RUN]


GO_ON = ("run", "--resume", RUN)


STUDIES = (
    # The longer its trials might last, the fewer go side by side, and the more often some end.
    Study("floating", CHAPTER / "4_30_grasp_cartesian.yaml", 200, ("program.0.limit=200",)),
    Study("mujoco", CHAPTER / "close.yaml", 12, ("scene.world=mujoco", "control.displacement=probing")),
    Study("bullet", CHAPTER / "close.yaml", 8),
)


def kept(folder: Path) -> Kept:
    """What a run has kept, read as a report reads it."""
    run = RunFolder.open(folder)
    pieces = {piece.number: piece for piece in run.pieces()}
    found: Kept = {}
    for record in run.records():
        digest = hashlib.sha256()
        for name, values in run.unpacked(pieces[record.number]).items():
            digest.update(f"{name} {values.shape} {values.dtype}".encode() + values.tobytes())
        found[record.number] = repr(dataclasses.replace(record, wall_s=0.0)), digest.hexdigest()
    return found


def _listed(trials: Sequence[int]) -> str:
    return ", ".join(map(str, trials[:8])) + (f" and {len(trials) - 8} more" if len(trials) > 8 else "")


def check_opens(folder: Path, told: int, whole: Kept) -> int:
    """That a run which was stopped is sound, can be reported, and has all trials that were told; how many it has."""
    run = RunFolder.open(folder)
    count = len(run.records())
    demand(len(run.finished()) == count, f"of {count} trials in the table only {len(run.finished())} are whole")
    demand(count >= told, f"{told} trials were committed, {count} are left")
    faults = [f"{found.part}: {found.says}" for found in examined(run).findings if found.verdict is Verdict.FAULT]
    demand(not faults, f"the doctor says {faults}")
    report = plain(summarised(evidence_of(RunFolder.open(folder))))
    demand(report["trials"]["finished"] == count, f"the report tells of {report['trials']['finished']} of {count}")
    check_same(kept(folder), whole, all_of_them=False)
    return count


def check_same(found: Kept, whole: Kept, *, all_of_them: bool = True, but: Sequence[int] = ()) -> None:
    """That trials are those of a run that nothing stopped, to the last bit, ``but`` some."""
    demand(found.keys() <= whole.keys(), "there are trials that nobody asked for")
    if all_of_them:
        demand(found.keys() == whole.keys(), f"trials {_listed(sorted(whole.keys() - found.keys()))} are missing")
    for what, part in (("record", 0), ("trajectory", 1)):
        others = [number for number in found if found[number][part] != whole[number][part] and number not in but]
        demand(not others, f"the {what} of trials {_listed(others)} is another")


def check_complete(folder: Path, whole: Kept, *, crashed: int = 0) -> list[int]:
    """That a run is finished, sound and as one that nothing stopped, but for so many trials at most that are named as
    crashed; their numbers."""
    found = kept(folder)
    run = RunFolder.open(folder)
    named = [record.number for record in run.records() if record.outcome is Outcome.CRASHED]
    demand(len(named) <= crashed, f"trials {_listed(named)} have crashed, for at most {crashed} there is a reason")
    check_same(found, whole, but=named)
    others = [f"{said.part}: {said.says}" for said in examined(run).findings if said.verdict is not Verdict.WHOLE]
    demand(not others, f"the doctor says {others}")
    return named


def resume(place: Path, *engine: str) -> None:
    """Finish the run in a place."""
    answer = graspdsl(*GO_ON, *engine, "--no-report", cwd=place)
    demand(answer.returncode == 0, f"it could not be resumed: {answer.stderr}")
