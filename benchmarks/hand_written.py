"""What a numpy programmer would write by hand for two of the chapter's controllers, without a language and a compiler.

Each is as general as its spec needs, and no more: which terms vanish, and which matrices are of rank one, has been
worked out on paper. The results are those of the compiled controllers to 1e-12, which the benchmarks assert.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.compiler.program import Program
from graspdsl.worlds.protocol import Observation

REACH = 0.05  # squared motion along the normal, below which a finger is not driven faster
VANISHED = 1e-9  # a displacement that has no direction
ENOUGH = 1e-15  # of a length of one
MOST = 100  # passes of Newton's method


class SlideToGrasp:
    """π_sgx|Γ Γ, Eq. 4.31, of contacts that all belong to Γ: force first, then position, whose reference is
    force residual before moment residual."""

    def __init__(self, program: Program) -> None:
        control, target, robot = program.spec.control, program.target, program.robot
        self.weights = program.phases[-1].grasp.weights
        self.shares = self.weights / self.weights.sum()
        self.scale = np.array(robot.weights)
        self.lower, self.upper = target.limits
        self.fingers = np.array(
            [[float(joint in contact.finger) for joint in robot.joints] for contact in robot.hand.contacts.values()]
        )
        step, radius = target.step(float(self.weights @ self.weights)), control.curvature_radius
        self.force_step = step * self.weights[:, None]
        self.moment_step = -control.moment_gain * step / radius * self.weights[:, None]
        self.cap, self.gain = target.cap, control.position_gain
        self.damping = control.damping**2 * np.eye(3 * len(self.weights))
        self.press, self.admittance = program.spec.parameters["κ_f"], control.admittance
        self.fastest = control.approach / target.rate

    def command(self, seen: Observation) -> Array:
        """The displacement of the joints, (n,); those that it would take beyond a limit are locked."""
        locked = np.zeros(len(self.scale), dtype=bool)
        while True:
            moved = self.moved(seen)
            if locked.any():
                moved[locked] = 0.0
            after = seen.joints + moved
            beyond = ((after < self.lower) & (moved < 0.0)) | ((after > self.upper) & (moved > 0.0))
            if not beyond.any():
                return moved
            locked |= beyond
            seen = replace(seen, jacobian=np.where(locked, 0.0, seen.jacobian))

    def moved(self, seen: Observation) -> Array:
        """The displacement of the joints, (n,), whatever their limits."""
        points, normals, touching = seen.points, seen.normals, seen.touching
        jacobian = seen.jacobian * self.scale
        into = np.vecmat(normals, jacobian)
        # Force: each contact presses along its normal by what it lacks, and one that does not touch comes nearer.
        lacks = self.admittance * (self.press - np.vecdot(normals, seen.forces))
        pressed = np.where(touching, lacks.clip(-self.fastest, self.fastest), 0.0)
        moved = pressed @ into
        if not touching.all():
            own = into * self.fingers
            rate = np.where(touching, 0.0, self.fastest / np.maximum(np.vecdot(own, own), REACH))
            return np.asarray((moved + rate @ own) * self.scale)
        # Position: where to slide, force residual before moment residual, which is (x, y, z).
        net_force = self.weights @ normals
        turning = (self.weights * (points - self.shares @ points).T) @ normals
        x, y, z = turning[1, 2] - turning[2, 1], turning[2, 0] - turning[0, 2], turning[0, 1] - turning[1, 0]
        force = self.force_step * (net_force - (normals @ net_force)[:, None] * normals)
        moment = self.moment_step * (normals @ np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]))
        shift = (force + without(force.ravel(), moment.ravel()).reshape(-1, 3)).ravel()
        farthest = np.sqrt(np.vecdot(shift.reshape(-1, 3), shift.reshape(-1, 3)).max())
        shift /= max(1.0, farthest / self.cap)
        rows = jacobian.reshape(-1, len(self.scale))
        position = self.gain * (np.linalg.solve(rows @ rows.T + self.damping, shift) @ rows)
        return np.asarray((moved + without(moved, position)) * self.scale)


def without(higher: Array, lower: Array) -> Array:
    """What is left of a lower displacement across a higher one."""
    long = float(np.sqrt(higher @ higher))
    if long <= VANISHED:
        return lower
    direction = higher / long
    return np.asarray(lower - (direction @ lower) * direction)


class FloatingGrasp:
    """π_gx|Γ Γ, Eq. 4.30, of N times k contacts that float on an ellipsoid, until both residuals have been low long
    enough. Arrays are (N, k, 3), as anyone would have them."""

    def __init__(self, program: Program) -> None:
        control, target, until = program.spec.control, program.target, program.spec.program[0].until
        weights = program.phases[0].grasp.weights
        assert set(weights.tolist()) <= {0.0, 1.0}
        self.force_step = target.step(float(weights @ weights))
        self.moment_step = control.moment_gain * self.force_step / control.curvature_radius
        self.cap, self.rate = target.cap, target.rate
        assert until.force_residual is not None
        assert until.moment_residual is not None
        self.low_force, self.low_moment, self.hold = until.force_residual, until.moment_residual, until.hold
        self.axes = np.array(program.body.shape.extent) / 2
        self.spread = self.axes**2 - self.axes.min() ** 2

    def run(self, points: Array, most: int) -> tuple[Array, Array]:
        """Contacts (N, k, 3) [m] as they are in the end, and the number of observations (N,) that each trial took; no
        more than ``most`` ticks."""
        ended, counts = points.copy(), np.full(len(points), most + 1)
        places, since, now = np.arange(len(points)), np.full(len(points), np.inf), self.laid(points)
        for tick in range(most + 1):
            time = tick / self.rate
            moved, low = self.tick(now)
            since = np.where(low, np.minimum(since, time), np.inf)
            done = time - since >= self.hold - 1e-9
            if done.any():
                ended[places[done]], counts[places[done]] = self.back(self.of(now, done)), tick + 1
                now, moved, places, since = self.of(now, ~done), self.of(moved, ~done), places[~done], since[~done]
                if not len(places):
                    break
            now = self.slid(now, moved)
        return ended, counts

    def laid(self, points: Array) -> Array:
        """Points (N, k, 3) as they are worked with."""
        return points

    def back(self, points: Array) -> Array:
        """Points as (N, k, 3)."""
        return points

    def of(self, points: Array, chosen: Flags) -> Array:
        """Those of some trials."""
        return points[chosen]

    def tick(self, points: Array) -> tuple[Array, Flags]:
        """Displacements (N, k, 3) of contacts, and in which trials both residuals are low, (N,)."""
        normals = -self.outward(points)
        net_force = normals.sum(axis=1)
        net_moment = np.cross(points - points.mean(axis=1, keepdims=True), normals).sum(axis=1)
        across = np.vecdot(normals, net_force[:, None])[..., None] * normals
        force = self.force_step * (net_force[:, None] - across)
        moment = -self.moment_step * np.cross(normals, net_moment[:, None])
        squared = (force * force).sum(axis=(1, 2))
        along = np.where(squared > VANISHED**2, (force * moment).sum(axis=(1, 2)) / squared.clip(VANISHED**2), 0.0)
        moved = force + moment - along[:, None, None] * force
        moved /= np.maximum(1.0, np.linalg.norm(moved, axis=-1).max(axis=-1) / self.cap)[:, None, None]
        low: Flags = np.linalg.norm(net_force, axis=-1) < self.low_force
        return moved, low & (np.linalg.norm(net_moment, axis=-1) < self.low_moment)

    def outward(self, points: Array) -> Array:
        """The unit normals at points."""
        normals = points / self.axes**2
        return np.asarray(normals / np.linalg.norm(normals, axis=-1, keepdims=True))

    def slid(self, points: Array, moved: Array) -> Array:
        """Points after a step along the tangent planes, put back on the surface: the nearest point, by Newton's method
        on how far the scaled point is from the unit sphere."""
        normals = self.outward(points)
        astray = points + moved - np.vecdot(moved, normals)[..., None] * normals
        scaled = np.abs(astray) * self.axes
        root = (scaled - self.spread).max(axis=-1)
        for _ in range(MOST):
            below = root[..., None] + self.spread
            share = scaled / below
            squares = share * share
            length = np.sqrt(squares.sum(axis=-1))
            if (length <= 1.0 + ENOUGH).all():
                break
            root = root + np.maximum(length - 1.0, 0.0) * length**2 / (squares / below).sum(axis=-1)
        return np.asarray(np.copysign(self.axes * share / length[..., None], astray))


class FloatingGraspByCoordinate(FloatingGrasp):
    """The same with arrays (3, k, N): whoever has profiled numpy puts the long axis last."""

    def __init__(self, program: Program) -> None:
        super().__init__(program)
        self.axes, self.spread = self.axes[:, None, None], self.spread[:, None, None]

    def laid(self, points: Array) -> Array:
        """(3, k, N) of (N, k, 3)."""
        return np.ascontiguousarray(points.transpose(2, 1, 0))

    def back(self, points: Array) -> Array:
        """(N, k, 3) of (3, k, N)."""
        return points.transpose(2, 1, 0)

    def of(self, points: Array, chosen: Flags) -> Array:
        """Those of some trials."""
        return points[..., chosen]

    def tick(self, points: Array) -> tuple[Array, Flags]:
        """Displacements (3, k, N) of contacts, and in which trials both residuals are low, (N,)."""
        normals = -self.outward(points)
        net_force = normals.sum(axis=1, keepdims=True)
        net_moment = _crossed(points - points.mean(axis=1, keepdims=True), normals).sum(axis=1, keepdims=True)
        force = self.force_step * (net_force - (normals * net_force).sum(axis=0) * normals)
        moment = -self.moment_step * _crossed(normals, net_moment)
        squared = (force * force).sum(axis=(0, 1))
        along = np.where(squared > VANISHED**2, (force * moment).sum(axis=(0, 1)) / squared.clip(VANISHED**2), 0.0)
        moved = force + moment - along * force
        moved /= np.maximum(1.0, np.sqrt((moved * moved).sum(axis=0).max(axis=0)) / self.cap)
        low: Flags = np.sqrt((net_force**2).sum(axis=(0, 1))) < self.low_force
        return moved, low & (np.sqrt((net_moment**2).sum(axis=(0, 1))) < self.low_moment)

    def outward(self, points: Array) -> Array:
        """The unit normals (3, k, N) at points."""
        normals = points / self.axes**2
        return np.asarray(normals / np.sqrt((normals * normals).sum(axis=0)))

    def slid(self, points: Array, moved: Array) -> Array:
        """As of the other layout."""
        normals = self.outward(points)
        astray = points + moved - (moved * normals).sum(axis=0) * normals
        scaled = np.abs(astray) * self.axes
        root = (scaled - self.spread).max(axis=0)
        for _ in range(MOST):
            below = root + self.spread
            share = scaled / below
            squares = share * share
            length = np.sqrt(squares.sum(axis=0))
            if (length <= 1.0 + ENOUGH).all():
                break
            root = root + np.maximum(length - 1.0, 0.0) * length**2 / (squares / below).sum(axis=0)
        return np.asarray(np.copysign(self.axes * share / length, astray))


def _crossed(a: Array, b: Array) -> Array:
    """a × b over the first axis."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
