"""What the fingertips feel: one tactile sensor in each, and whether each of them touches."""

from graspdsl.worlds.bullet.touch.fingertips import Fingertips, Reading

__all__ = ["Fingertips", "Reading"]
