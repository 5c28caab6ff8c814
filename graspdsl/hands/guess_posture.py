"""A model in postures: where its links are, how joints move points of them, and which points they are made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross
from graspdsl.basis.rotations import exponential
from graspdsl.models.joint_kinds import HINGES, ROTATING
from graspdsl.models.model import HERE, Frame, Joint, Model, Solid

SAMPLES = 1500  # points of each solid
ROUNDING = 1e-9  # rad or m


class PosedModel:
    """The joints of a model that move of themselves, those that follow them, and what is below each link.

    A posture is a vector (n,) [rad or m] of the ``drivers``, in the order of the model.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        moving = [name for name, joint in model.joints.items() if joint.kind in HINGES and not _held(joint.limits)]
        origins = {name: model.origin_of_motion(name) for name in moving}
        # One that mimics a joint which does not move stays where that leaves it.
        self.drivers = tuple(
            name for name in moving if origins[name].joint not in moving or origins[name].joint == name
        )
        self.followed = {
            name: (self.drivers.index(origins[name].joint), origins[name].multiplier, origins[name].offset)
            if origins[name].joint in self.drivers
            else (self.drivers.index(name), 1.0, 0.0)
            for name in moving
        }
        self.before = {joint.child: name for name, joint in model.joints.items()}

    @cached_property
    def limits(self) -> Array:
        """The lower and upper limits (2, n) of the drivers, narrowed by those of what follows them; a whole turn for
        one that has none."""
        ends = []
        for index, name in enumerate(self.drivers):
            low, high = self.model.joints[name].limits or (-np.pi, np.pi)
            for follower, (leader, ratio, offset) in self.followed.items():
                own = self.model.joints[follower].limits
                if leader == index and own is not None and ratio and follower != name:
                    first, last = sorted(((own[0] - offset) / ratio, (own[1] - offset) / ratio))
                    if first < high and last > low:
                        low, high = max(low, first), min(high, last)
            ends.append((low, high))
        return np.array(ends).reshape(-1, 2).T

    def places(self, posture: Array) -> Array:
        """Where all joints of the model are [rad or m] in a posture: 0 for one that is fixed."""
        return self._ratios @ posture + self._offsets

    @cached_property
    def _ratios(self) -> Array:
        ratios = np.zeros((len(self.model.joints), len(self.drivers)))
        for row, name in enumerate(self.model.joints):
            if name in self.followed:
                leader, ratio, _ = self.followed[name]
                ratios[row, leader] = ratio
        return ratios

    @cached_property
    def _offsets(self) -> Array:
        def offset(name: str, joint: Joint) -> float:
            if name in self.followed:
                return self.followed[name][2]
            return joint.limits[0] if joint.limits is not None and joint.kind in HINGES else 0.0

        return np.array([offset(name, joint) for name, joint in self.model.joints.items()])

    def frames(self, posture: Array) -> dict[str, Frame]:
        """The frames of all links in that of the root."""
        found, joints = {self.model.root: HERE}, self.model.joints.values()
        moves = self.places(posture)[:, None] * np.array([joint.axis for joint in joints]).reshape(-1, 3)
        turns = exponential(moves)
        for joint, move, turn in zip(joints, moves, turns, strict=True):
            frame = found[joint.parent].then(joint.frame)
            if joint.kind in ROTATING:
                found[joint.child] = Frame(frame.place, frame.rotation @ turn)
            else:
                found[joint.child] = Frame(frame.place + frame.rotation @ move, frame.rotation)
        return found

    def chain(self, link: str) -> tuple[str, ...]:
        """The joints that move a link, the first one first."""
        if link not in self._chains:
            self._chains[link] = tuple(name for name in self.model.movers(link) if name in self.followed)
        return self._chains[link]

    @cached_property
    def _chains(self) -> dict[str, tuple[str, ...]]:
        return {}

    def columns(self, link: str, point: Array, frames: Mapping[str, Frame]) -> tuple[Array, Array]:
        """How each driver moves a point (3,) of a link (3, n) [m/rad or 1] and turns it (3, n), in the frame of the
        root."""
        moved, turned = np.zeros((2, 3, len(self.drivers)))
        at = frames[link].place + frames[link].rotation @ point
        for name in self.chain(link):
            joint, (leader, ratio, _) = self.model.joints[name], self.followed[name]
            frame = frames[joint.child]
            axis = ratio * (frame.rotation @ joint.axis)
            moved[:, leader] += cross(axis, at - frame.place) if joint.kind in ROTATING else axis
            turned[:, leader] += axis if joint.kind in ROTATING else 0.0
        return moved, turned

    def group(self, link: str) -> str:
        """The first of the links that a link is fixed to: all with the same one move as one."""
        while link in self.before and self.before[link] not in self.followed:
            link = self.model.joints[self.before[link]].parent
        return link

    @cached_property
    def groups(self) -> Mapping[str, tuple[str, ...]]:
        """The links that move as one, by the first of them."""
        found: dict[str, tuple[str, ...]] = {}
        for link in self.model.links:
            found[self.group(link)] = (*found.get(self.group(link), ()), link)
        return found

    def points(self, links: Sequence[str], frames: Mapping[str, Frame], most: int = 0) -> Array:
        """Points (p, 3) [m] of the surfaces of some links, in the frame that ``frames`` are given in; ``most``: about
        so many of each, 0 for all."""
        chosen = {link: self.own_points(link) for link in links}
        if most:
            chosen = {link: own[:: max(1, len(own) // most)] for link, own in chosen.items()}
        parts = [own @ frames[link].rotation.T + frames[link].place for link, own in chosen.items()]
        return np.concatenate([np.zeros((0, 3)), *parts])

    def own_points(self, link: str) -> Array:
        """Points (p, 3) [m] of what of a link touches, or where nothing does is drawn, in its frame."""
        if link not in self._own:
            solids = touching(self.model.links[link].solids)
            parts = [surface_points(solid) @ solid.frame.rotation.T + solid.frame.place for solid in solids]
            self._own[link] = np.concatenate([np.zeros((0, 3)), *parts])
        return self._own[link]

    @cached_property
    def _own(self) -> dict[str, Array]:
        return {}


def touching(solids: Sequence[Solid]) -> list[Solid]:
    """The solids that touch, or, where none does, those that are drawn."""
    known = [solid for solid in solids if solid.kind != "mesh" or (solid.mesh is not None and len(solid.mesh.faces))]
    return [solid for solid in known if solid.touches] or known


def surface_points(solid: Solid) -> Array:
    """Points (p, 3) [m] spread over the surface of a solid, its corners among them, in its own frame."""
    import trimesh

    match solid.kind:
        case "box":
            whole = trimesh.creation.box(extents=solid.sizes)
        case "sphere":
            whole = trimesh.creation.icosphere(radius=solid.sizes[0])
        case "cylinder":
            whole = trimesh.creation.cylinder(radius=solid.sizes[0], height=solid.sizes[1])
        case "capsule":
            whole = trimesh.creation.capsule(radius=solid.sizes[0], height=solid.sizes[1])
            whole.apply_translation(-whole.bounds.mean(axis=0))
        case "ellipsoid":
            whole = trimesh.creation.icosphere()
            whole.apply_scale(solid.sizes)
        case _:
            assert solid.mesh is not None
            whole = trimesh.Trimesh(solid.mesh.corners, solid.mesh.faces, process=False)
    if whole.area <= 0.0:
        return np.array(whole.vertices)
    spread, _ = trimesh.sample.sample_surface(whole, SAMPLES, seed=0)
    return np.concatenate([np.array(whole.vertices), np.array(spread)])


def _held(limits: tuple[float, float] | None) -> bool:
    return limits is not None and limits[1] - limits[0] < ROUNDING
