"""Draw the picture of the tutorial: the funnel of the run that its page makes.

Run it with the developers' tools installed: python docs/render_tutorial.py
"""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib as mpl

import graspdsl as g

DOCS = Path(__file__).resolve().parent


def main() -> None:
    """Run the last version of the spec, as a reader has mended it."""
    page = (DOCS / "tutorial.md").read_text("utf-8")
    *_, spec = re.findall(r"<!-- spec: my_grasp.yaml -->\n```yaml\n(.*?)```", page, flags=re.S)
    mpl.rcParams.update({"svg.hashsalt": "graspdsl", "svg.fonttype": "none", "font.family": "sans-serif"})
    figure = g.run(g.loads(spec), progress=False).figure("funnel")
    figure.savefig(DOCS / "images" / "tutorial_funnel.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
