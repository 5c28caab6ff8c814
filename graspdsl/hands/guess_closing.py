"""How a hand closes: which joints flex its fingers and which way, and where it is open, about to pinch, and closed.

The pinch is a posture in which the tip of the opposing finger stands before those of the others, a gap apart, with
joints as near to the middle of their ways as that lets them. From there the joints that flex the fingers go back
together as far as the tips move apart, which is open, and on as far as the first of them can, which is closed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array, Flags
from graspdsl.basis.algebra import cross
from graspdsl.hands.guess_fingers import Finger, Fingers, distal
from graspdsl.hands.guess_posture import PosedModel
from graspdsl.models.joint_kinds import ROTATING
from graspdsl.models.model import Frame

GAP = 0.25  # of the length of a finger and of its way, between opposing tips at the pinch
NEAR = 0.005  # m off the place of a tip that counts as much as the whole way of a joint
FACING = 1.0  # how much it counts that a finger flexes towards the opposing one
LEANING, LEAN = 2.0, 0.5  # how much, that its last link leans that way, and the sine from which on it does enough
BENT = 0.45  # of the way of a flexing joint, from open to closed, where it rather is at the pinch
PARALLEL = 0.7  # cosine: a joint that flexes a finger is so much along the last one
ONE_WAY = 0.3  # of its range, by which a joint goes farther to one side: that side flexes
TRIES = 6
STEPS = 40


@dataclass(frozen=True, slots=True)
class Closing:
    """How a hand closes.

    signs (n,): +1 or −1 of a driver that closes by going up or down, else 0; opened, pinch, closed: (n,) [rad or m];
    toward: (k, 3) the unit directions, in the frame of the root at the pinch, in which the tips close; columns:
    (k, 3, n) how the tips move there; tips: (k, 3) [m] where they are.
    """

    signs: npt.NDArray[np.int64]
    opened: Array
    pinch: Array
    closed: Array
    toward: Array
    columns: Array
    tips: Array

    def closers(self, finger: int) -> Flags:
        """Which drivers (n,) close a finger."""
        along = np.einsum("in,i->n", self.columns[finger], self.toward[finger])
        return np.asarray((self.signs != 0) & (np.abs(along) > 0.0))


def closing_of(posed: PosedModel, fingers: Fingers, neutral: Array) -> Closing:
    """How a hand closes; ``neutral`` is where its joints are nearest to 0."""
    search = _Search(posed, fingers.fingers)
    pinch = search.pinch(neutral, neutral)
    signs = search.signs(pinch)
    low, high = posed.limits
    first, last = np.where(signs > 0, low, high), np.where(signs > 0, high, low)
    pinch = search.pinch(pinch, np.where(signs, first + BENT * (last - first), pinch))
    signs = search.signs(pinch)
    first, last = np.where(signs > 0, low, high), np.where(signs > 0, high, low)
    back = np.where(signs, first - pinch, 0.0)
    ways = np.linspace(0.0, 1.0, STEPS)
    gaps = [search.gap(pinch + way * back) for way in ways]
    opened = pinch + ways[int(np.argmax(gaps))] * back
    forth = pinch - opened
    room = np.abs(last - pinch)[forth != 0.0] / np.abs(forth)[forth != 0.0]
    closed = pinch + (float(room.min()) if len(room) else 0.0) * forth
    tips, columns = search.moved(pinch)
    motion = columns @ (closed - opened)
    lengths = np.linalg.norm(motion, axis=1, keepdims=True)
    toward = np.where(lengths > 1e-6, motion / np.where(lengths > 1e-6, lengths, 1.0), search.facing(tips))
    return Closing(signs, opened, pinch, closed, toward, columns, tips)


class _Search:
    def __init__(self, posed: PosedModel, fingers: Sequence[Finger]) -> None:
        self._posed, self._fingers = posed, fingers
        self._low, self._high = posed.limits
        self._ranges = self._high - self._low
        others = np.array([finger.base.mean(axis=0) for finger in fingers[1:]])
        self._row = np.linalg.svd(others - others.mean(axis=0))[2][0] if len(others) > 1 else np.zeros(3)
        lengths, thickness = np.mean([self._sizes(finger) for finger in fingers], axis=0)
        self._gap = float(GAP * lengths + 2.0 * thickness)  # m, between the middles of the tips

    def _sizes(self, finger: Finger) -> tuple[float, float]:
        """How long a finger is [m], its links on end, and how far it slides; and how far its surface is from the middle
        of its tip, towards where the last joint moves it."""
        joints = [self._posed.model.joints[name] for name in finger.joints[1:]]
        frames = self._posed.frames(np.clip(np.zeros(len(self._low)), self._low, self._high))
        end = frames[finger.host].place + frames[finger.host].rotation @ finger.tip
        last = frames[self._posed.model.joints[finger.flexor].child].place
        slides = (self._posed.model.joints[name] for name in finger.joints)
        slid = sum(joint.limits[1] - joint.limits[0] for joint in slides if joint.kind not in ROTATING and joint.limits)
        length = slid + sum(np.linalg.norm(joint.frame.place) for joint in joints) + np.linalg.norm(end - last)
        flexing, sign = self._flexing(finger, end, frames)
        own = self._posed.points([finger.host], frames)
        pad = distal(own, frames[finger.host].rotation @ finger.along) - end
        return float(length), float((sign * pad @ flexing).max() if sign else np.abs(pad @ flexing).max())

    def moved(self, posture: Array) -> tuple[Array, Array]:
        """The tips (k, 3) [m] in a posture, and how each driver moves them (k, 3, n), in the frame of the root."""
        frames = self._posed.frames(posture)
        return self._tips(frames), np.array(
            [self._posed.columns(finger.host, finger.tip, frames)[0] for finger in self._fingers]
        )

    def _tips(self, frames: dict[str, Frame]) -> Array:
        return np.array(
            [frames[finger.host].place + frames[finger.host].rotation @ finger.tip for finger in self._fingers]
        )

    def facing(self, tips: Array) -> Array:
        """The unit directions (k, 3) from the tips to the side that opposes them."""
        across = tips[1:].mean(axis=0) - tips[0]
        across = across / max(float(np.linalg.norm(across)), 1e-9)
        return np.array([across, *(-across for _ in tips[1:])])

    def gap(self, posture: Array) -> float:
        """The distance [m] of the opposing tip from the nearest other."""
        tips = self._tips(self._posed.frames(posture))
        return float(np.linalg.norm(tips[1:] - tips[0], axis=1).min())

    def pinch(self, start: Array, rather: Array) -> Array:
        """The posture at which opposing tips are the gap apart, the joints near to where they ``rather`` are."""
        from scipy.optimize import least_squares

        low, high = self._low - 1e-9, self._high + 1e-9
        random = np.random.default_rng(0)
        best: tuple[float, Array] = (np.inf, start)
        for number in range(TRIES):
            spread = random.uniform(self._low, self._high)
            posture = np.clip(start + (0.5 * (spread - start) if number else 0.0), self._low, self._high)
            tips = self._tips(self._posed.frames(posture))
            guess = np.concatenate([posture, tips.mean(axis=0), self.facing(tips)[0]])
            ends = np.full(6, np.inf)
            found = least_squares(
                partial(self._off, rather=rather),
                np.clip(guess, [*low, *-ends], [*high, *ends]),
                jac=partial(self._slopes, rather=rather),
                bounds=([*low, *-ends], [*high, *ends]),
                max_nfev=60,
            )
            if found.cost < best[0] - 1e-6:
                best = float(found.cost), np.clip(found.x[:-6], self._low, self._high)
        return best[1]

    def _off(self, variables: Array, rather: Array) -> Array:
        self._last = variables.tobytes(), self._residuals(variables, rather)
        return self._last[1][0]

    def _slopes(self, variables: Array, rather: Array) -> Array:
        """The solver asks for the slopes where it has just asked for what is off."""
        at, (_, slopes) = self._last
        return slopes if at == variables.tobytes() else self._residuals(variables, rather)[1]

    def _residuals(self, variables: Array, rather: Array) -> tuple[Array, Array]:
        """What the posture (n,), the middle of the pinch (3,) and the way across it (3,) are off, and how that changes
        with them."""
        posture, centre, way = variables[:-6], variables[-6:-3], variables[-3:]
        count, others = len(variables), len(self._fingers) - 1
        frames = self._posed.frames(posture)
        beside = np.eye(3) - np.outer(self._row, self._row)
        residuals, slopes, middle, middles = [], [], np.zeros(3), np.zeros((3, count))
        for number, finger in enumerate(self._fingers):
            side, share = (1.0, 1.0 / others) if number else (-1.0, 1.0)
            moved, turned = self._posed.columns(finger.host, finger.tip, frames)
            tip = frames[finger.host].place + frames[finger.host].rotation @ finger.tip
            slope = np.hstack([moved, -np.eye(3), -side * self._gap / 2.0 * np.eye(3)])
            off = tip - centre - side * self._gap / 2.0 * way
            # Those of a row stay beside one another: only their middle is before the opposing one.
            across = beside if number else np.eye(3)
            residuals.append(np.sqrt(share) / NEAR * across @ off)
            slopes.append(np.sqrt(share) / NEAR * across @ slope)
            if number:
                middle, middles = middle + share * off, middles + share * slope
            flexing, sign = self._flexing(finger, tip, frames)
            if sign:
                facing = -side * sign * way
                turning = np.stack([cross(column, flexing) for column in turned.T], axis=1)
                residuals.append(np.array([FACING * (1.0 - facing @ flexing)]))
                slopes.append(-FACING * np.hstack([facing @ turning, np.zeros(3), -side * sign * flexing])[None])
            # A link that leans in meets an object with its end, and before the links behind it do.
            along = frames[finger.host].rotation @ finger.along
            if -side * way @ along < LEAN:
                turning = np.stack([cross(column, along) for column in turned.T], axis=1)
                residuals.append(np.array([LEANING * (LEAN + side * way @ along)]))
                slopes.append(LEANING * side * np.hstack([way @ turning, np.zeros(3), along])[None])
            else:
                residuals.append(np.zeros(1))
                slopes.append(np.zeros((1, count)))
        residuals.append(np.array([self._row @ middle, np.linalg.norm(way) - 1.0]) / (NEAR, 0.1))
        length = np.concatenate([np.zeros(count - 3), way / max(float(np.linalg.norm(way)), 1e-9)])
        slopes.append(np.array([self._row @ middles / NEAR, length / 0.1]))
        residuals.append((posture - rather) / self._ranges)
        slopes.append(np.hstack([np.diag(1.0 / self._ranges), np.zeros((len(posture), 6))]))
        return np.concatenate(residuals), np.vstack(slopes)

    def _flexing(self, finger: Finger, tip: Array, frames: dict[str, Frame]) -> tuple[Array, int]:
        """How the last joint of a finger moves its tip, a unit direction (3,), and the sign with which it flexes; 0
        where its limits do not tell."""
        joint = self._posed.model.joints[finger.flexor]
        frame = frames[joint.child]
        axis = frame.rotation @ joint.axis
        moved = cross(axis, tip - frame.place) if joint.kind in ROTATING else axis
        low, high = joint.limits or (-1.0, 1.0)
        sign = int(np.sign(low + high)) if abs(low + high) > ONE_WAY * (high - low) else 0
        return moved / max(float(np.linalg.norm(moved)), 1e-9), sign

    def signs(self, posture: Array) -> npt.NDArray[np.int64]:
        """Which way each driver (n,) closes, at the pinch: one that is along the last joint of a finger, or drives one
        that is, closes where it moves the tips together, whichever way it goes."""
        frames = self._posed.frames(posture)
        tips = self._tips(frames)
        closing = np.zeros(len(self._low))
        for finger, way in zip(self._fingers, self.facing(tips), strict=True):
            last = self._posed.model.joints[finger.flexor]
            axis = frames[last.child].rotation @ last.axis
            bends = {
                self._posed.followed[name][0]
                for name in finger.joints
                for joint in [self._posed.model.joints[name]]
                if (joint.kind in ROTATING) == (last.kind in ROTATING)
                and abs(axis @ frames[joint.child].rotation @ joint.axis) > PARALLEL
            }
            columns, _ = self._posed.columns(finger.host, finger.tip, frames)
            for driver in bends:
                closing[driver] += float(columns[:, driver] @ way)
        return np.sign(np.where(np.abs(closing) > 1e-4, closing, 0.0)).astype(np.int64)
