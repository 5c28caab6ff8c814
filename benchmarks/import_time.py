"""How long it takes until one can begin: ``import graspdsl``, a formula, a floating spec, against importing the light
libraries that it depends on (numpy, pydantic, PyYAML).

Each in fresh processes, in turn, so that what the machine does besides is shared. Prints medians over them, and ratios.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
from pathlib import Path

SPEC = Path(__file__).resolve().parents[1] / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
ROUNDS = 15
MEASURED = {
    "numpy, pydantic, yaml": "import numpy, pydantic, yaml",
    "import graspdsl": "import graspdsl",
    "g.parse of a formula": "import graspdsl as g; g.parse('π_s|Γ Γ (π_gx|Γ Γ)')",
    "g.load of a floating spec": f"import graspdsl as g; g.load({str(SPEC)!r})",
    "g.compile of a controller": "import graspdsl as g; g.compile('π_s|Γ Γ (π_gx|Γ Γ)')",
}


def seconds(code: str) -> float:
    """What a piece of code takes in a process of its own [s], without the start of Python."""
    timed = f"import time; began = time.perf_counter()\n{code}\nprint(time.perf_counter() - began)"
    done = subprocess.run([sys.executable, "-c", timed], capture_output=True, text=True, check=True)
    return float(done.stdout)


def main() -> None:
    """Measure and print."""
    for code in MEASURED.values():  # so that all is compiled and in memory
        seconds(code)
    rounds = [{name: seconds(code) for name, code in MEASURED.items()} for _ in range(ROUNDS)]
    libraries, *others = (statistics.median(found[name] for found in rounds) for name in MEASURED)
    first, *names = MEASURED
    print(f"{first}: {1000 * libraries:.0f} ms, median of {ROUNDS}")
    for name, taken in zip(names, others, strict=True):
        print(f"{name}: {1000 * taken:.0f} ms, ratio {taken / libraries:.2g}")


if __name__ == "__main__":
    main()
