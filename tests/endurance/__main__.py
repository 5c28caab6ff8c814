"""Runs that are killed, again and again, and have to come to the same end. ``make endurance``, or some of it:

    cd tests && python -m endurance [--seed N] [--moments N] [--plant MISTAKE] [WORD …]

WORDs choose among what there is, as ``local``, ``dask bullet workers``, ``floating disk``: whatever has them all. Ends
at the first difference with exit code 1 and the seed that led there.
"""

from __future__ import annotations

import argparse
import os
import random
import sys

from endurance.full_disk import disk_full
from endurance.kills import ENGINES, Torture, main_killed, undisturbed, workers_killed
from endurance.scheduler import scheduler_killed
from endurance.studies import STUDIES, DifferenceError, check_same

ATTEMPTS = {"main": main_killed, "workers": workers_killed, "scheduler": scheduler_killed, "disk": disk_full}


def _asked() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m endurance")
    parser.add_argument("words", nargs="*", metavar="WORD")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--moments", type=int, default=20)
    parser.add_argument("--plant", default="", help="a mistake of endurance/planted.py, which has to be found")
    return parser.parse_args()


def _say(text: str) -> None:
    print(text, flush=True)


def main() -> int:
    """What has been asked for. Returns the exit code."""
    asked = _asked()
    words = set(asked.words)
    for study in STUDIES:
        whole = None
        for engine, with_engine in ENGINES.items():
            for what, attempt in ATTEMPTS.items():
                if not words <= {study.name, engine, what} or (what == "scheduler" and engine != "dask"):
                    continue
                name = f"{study.name}, {engine}, {what}"
                if what == "disk" and os.geteuid() != 0:
                    _say(f"{name}: left out, for only root may mount a small disk")
                    continue
                try:
                    if whole is None:
                        whole, _ = undisturbed(study, ("--workers", "1"))
                    again, span = undisturbed(study, with_engine)
                    check_same(again, whole)
                    _say(f"{name}: seed {asked.seed}, {study.trials} trials, {span:.1f} s from first to last")
                    chance = random.Random(f"{asked.seed}, {name}")
                    torture = Torture(study, with_engine, whole, span, chance, asked.plant)
                    for told in torture.killed(asked.moments, attempt):
                        _say(f"  {told}")
                except DifferenceError as difference:
                    _say(f"{name}: FAILED: {difference}\n  again with --seed {asked.seed} {study.name} {engine} {what}")
                    return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
