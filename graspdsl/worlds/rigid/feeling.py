"""What hands on stages feel."""

from __future__ import annotations

from collections.abc import Sequence

from graspdsl.worlds.rigid.engine import Stages
from graspdsl.worlds.touch.fingertip_sensor import TipFrames
from graspdsl.worlds.touch.fingertips import Fingertips, TipReading, read


def felt(stages: Stages, frames: TipFrames, hands: Sequence[Fingertips]) -> TipReading:
    """What hands on stages side by side feel now, with their tips in these frames."""
    return read(hands, frames, lambda places: stages.tip_jacobians(frames, places)[0])
