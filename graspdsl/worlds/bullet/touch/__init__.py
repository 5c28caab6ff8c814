"""What the fingertips feel: one tactile sensor in each, and whether each of them touches."""

from graspdsl.worlds.bullet.touch.fingertips import Fingertips, Reading
from graspdsl.worlds.bullet.touch.sensor import Clock

__all__ = ["Clock", "Fingertips", "Reading"]
