"""What the engine tells tactile sensors of a hand's fingertips on an object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from graspdsl.arrays import Array
from graspdsl.worlds.bullet.hand import BulletHand, Tip
from graspdsl.worlds.bullet.scene import Scene


@dataclass(frozen=True, slots=True)
class BulletFingertips:
    """The fingertips of a hand before the object of a scene; see :class:`~graspdsl.worlds.touch.FingertipPhysics`."""

    hand: BulletHand
    scene: Scene

    @property
    def tips(self) -> Sequence[Tip]:
        """The fingertips."""
        return self.hand.tips

    def frames(self) -> list[tuple[Array, Array]]:
        """The frames of the tips' links."""
        return self.hand.tip_frames()

    def wrenches(self) -> Array:
        """What the load cells' joints hold up, (k, 6)."""
        return self.hand.cell_readings()

    def contacts(self) -> tuple[Array, Array, Array]:
        """True points, normals and forces, (k, 3) each."""
        return self.scene.tip_contacts(self.hand)

    def presses(self) -> list[tuple[Array, Array]]:
        """Points and normal forces of all contacts of each tip."""
        return self.scene.tip_presses(self.hand)

    def nearest(self, within: float) -> list[tuple[float, Array] | None]:
        """Distances and nearest points of the tips."""
        return self.scene.nearest_to_tips(self.hand, within)

    def jacobian(self, tip: int, place: Array) -> Array:
        """The linear Jacobian (3, n) of a point of a tip."""
        return self.hand.jacobians(self.hand.tips[tip], place, self.hand.all_joints())[0]
