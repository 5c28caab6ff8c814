"""Draw where the grasps of the main example begin and end: docs/images/funnel.png.

Run it with the developers' tools installed: python docs/render_funnel.py
"""

from __future__ import annotations

import io
import tempfile
from pathlib import Path

from PIL import Image

from graspdsl.compiler.program import program_of
from graspdsl.report.evidence import evidence_of
from graspdsl.report.page import write_report
from graspdsl.report.summary import summarised
from graspdsl.trials.runner import execute, new_run

ROOT = Path(__file__).resolve().parent.parent
SPEC = ROOT / "specs/towel_roll_two_contacts.yaml"
WIDTH = 720  # pixels


def main() -> None:
    """Run the example as its spec says and keep the figure of its report, smaller."""
    with tempfile.TemporaryDirectory() as place:
        folder = new_run(Path(place, "run"), program_of(SPEC.read_text("utf-8"), SPEC.name))
        execute(folder)
        evidence = evidence_of(folder)
        write_report(evidence, summarised(evidence))
        figure = (folder.path / "figures/funnel.png").read_bytes()
    picture = Image.open(io.BytesIO(figure)).convert("RGB")
    size = (WIDTH, round(WIDTH * picture.height / picture.width))
    smaller = picture.resize(size, Image.Resampling.LANCZOS)
    smaller.quantize(256).save(ROOT / "docs/images/funnel.png", optimize=True)


if __name__ == "__main__":
    main()
