"""Joints of a MJCF that follow others: by equalities, and by tendons that one actuator pulls."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from graspdsl.diagnostics import listed
from graspdsl.models.joint_kinds import FIXED
from graspdsl.models.loops import Led, led_by_loops
from graspdsl.models.model import Joint, Mimic
from graspdsl.models.source import Complaints, Prepared
from graspdsl.models.strengths import pulled_joints

if TYPE_CHECKING:
    import mujoco


class Following(NamedTuple):
    """What joints follow others, and where joints keep still that a loop holds [rad or m], by their names."""

    mimics: Mapping[str, Mimic]
    still: Mapping[str, float]


def followed(model: mujoco.MjModel, given: Prepared, joints: Mapping[str, Joint], complaints: Complaints) -> Following:
    """What each of the joints follows that follows another.

    An equality of two joints couples them where it is linear, and so does one that holds a tendon of two joints. A
    fixed tendon that an actuator pulls, and no joint of which has an actuator of its own, couples its joints to the
    first of them in the measure in which it pulls each: where nothing hinders them, joints of equal springs move so.
    The joints of a closed loop follow its driven joint as they do where the model is moved. Noted are tendons through
    space that are pulled, which have no place here.
    """
    return _Following(model, given, joints, complaints).found()


HINT = "couple joints by an <equality> of joints, or take it out and couple them in the hand file"
ASIDE = "to let them differ, list both among the joints of the hand file"
COUPLE = "couple its joints in the hand file: couplings"


class _Following:
    def __init__(
        self, model: mujoco.MjModel, given: Prepared, joints: Mapping[str, Joint], complaints: Complaints
    ) -> None:
        import mujoco

        self._model, self._given, self._complaints = model, given, complaints
        self._moving = [number for number in range(model.njnt) if self._moves(joints.get(model.joint(number).name))]
        at = [mujoco.mjtTrn(int(kind)) for kind in model.actuator_trntype]
        targets = [int(target) for target in model.actuator_trnid[:, 0]]
        at_joints = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
        self._driven = {target for kind, target in zip(at, targets, strict=True) if kind in at_joints}
        self._pulled = {target for kind, target in zip(at, targets, strict=True) if kind == mujoco.mjtTrn.mjTRN_TENDON}
        self._found, self._still = dict[str, Mimic](), dict[str, float]()

    def _moves(self, joint: Joint | None) -> bool:
        return joint is not None and joint.kind != FIXED

    def _name(self, joint: int) -> str:
        return str(self._model.joint(joint).name)

    def found(self) -> Following:
        import mujoco

        model, loops = self._model, list[int]()
        for equality in range(model.neq):
            if not model.eq_active0[equality]:
                continue
            match mujoco.mjtEq(int(model.eq_type[equality])):
                case mujoco.mjtEq.mjEQ_JOINT:
                    self._by_joints(equality)
                case mujoco.mjtEq.mjEQ_TENDON:
                    self._by_held_tendon(equality)
                case mujoco.mjtEq.mjEQ_CONNECT | mujoco.mjtEq.mjEQ_WELD:
                    loops.append(equality)
        leaders = {leader for tendon in sorted(self._pulled) for leader in self._by_pulled_tendon(tendon)}
        self._by_loops(loops, leaders | self._driven)
        return Following(self._found, self._still)

    def _by_joints(self, equality: int) -> None:
        model, one, other = self._model, *self._ends(equality)
        constant, ratio, *bent = model.eq_data[equality][:5].tolist()
        if one not in self._moving:
            return
        if other < 0 or any(bent):
            what = "no joint" if other < 0 else f"{self._name(other)} by a curve"
            message = f"an equality has {self._name(one)} follow {what}: that is left out"
            hint = 'say polycoef="offset ratio 0 0 0", or couple it in the hand file'
            self._complaints.warn(self._given.place("joint", self._name(one)), "left-out", message, hint)
            return
        # The equality is about the ways of both from where they are in the file, which may be counted from a ref.
        own, led = (float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (one, other))
        self._found[self._name(one)] = Mimic(self._name(other), ratio, own + constant - ratio * led)

    def _ends(self, equality: int) -> tuple[int, int]:
        return int(self._model.eq_obj1id[equality]), int(self._model.eq_obj2id[equality])

    def _by_held_tendon(self, equality: int) -> None:
        model, tendon, other = self._model, *self._ends(equality)
        name, held = model.tendon(tendon).name, pulled_joints(model, tendon)
        if other < 0 and len(held) == 2 and all(held.values()) and held.keys() <= {*self._moving}:
            leader, follower = sorted(held)
            length = float(model.tendon_length0[tendon] + model.eq_data[equality][0])
            mimic = Mimic(self._name(leader), -held[leader] / held[follower], length / held[follower])
            self._found[self._name(follower)] = mimic
        else:
            message = f"an equality holds the tendon {name}, which is not of two joints alone: that is left out"
            self._complaints.warn(self._given.place("fixed", name), "left-out", message, COUPLE)

    def _by_pulled_tendon(self, tendon: int) -> Iterator[int]:
        """Couples what an actuator pulls; the joint that the others are coupled to."""
        name, pulled = self._model.tendon(tendon).name, pulled_joints(self._model, tendon)
        if not pulled:
            message = f"the tendon {name} runs through space and is pulled: forces of such tendons are not known here"
            self._complaints.fault(self._given.place("spatial", name), "tendon", message, HINT)
        own = {joint: factor for joint, factor in sorted(pulled.items()) if factor and joint in self._moving}
        free = [joint for joint in own if self._name(joint) not in self._found]
        if not free or self._driven & own.keys():
            return
        leader, *coupled = free
        for joint in coupled:
            self._found[self._name(joint)] = Mimic(self._name(leader), own[joint] / own[leader], 0.0)
        if coupled:
            told = f"{listed(map(self._name, coupled))} is coupled to {self._name(leader)}, whatever hinders it"
            message = f"one actuator pulls the tendon {name}: {told}"
            self._complaints.warn(self._given.place("fixed", name), "tendon-coupled", message, ASIDE)
        yield leader

    def _by_loops(self, loops: Sequence[int], driven: set[int]) -> None:
        """Couples the joints of loops to the driven ones."""
        inside = {joint for equality in loops for joint in self._around(equality)}
        free = [joint for joint in self._moving if self._name(joint) not in self._found]
        leaders = [joint for joint in free if joint in driven and self._model.jnt_limited[joint]]
        others = [joint for joint in free if joint in inside - driven]
        if not others:
            return
        crooked = list[Led]()
        found = list(led_by_loops(self._model, leaders, others)) if leaders else []
        for led in found:
            if not led.is_straight:
                crooked.append(led)
            elif led.leader is None:
                self._still[self._name(led.joint)] = led.offset
            else:
                self._found[self._name(led.joint)] = Mimic(self._name(led.leader), led.ratio, led.offset)
        if not found or crooked:
            names = listed([self._name(joint) for joint in ([led.joint for led in crooked] or others)])
            message = f"loops are left open: {names} follow no driven joint by a ratio"
            self._complaints.warn(self._given.file, "left-out", message, COUPLE)
        for led in found:
            if led.is_straight:
                name, leader = self._name(led.joint), led.leader
                does = "keeps still" if leader is None else f"follows {self._name(leader)} by {led.ratio:.4g}"
                message = f"in its loop {name} {does}, within {led.off:.2g}, as the model moves freely"
                hint = "to have it otherwise, couple it in the hand file"
                self._complaints.warn(self._given.place("joint", name), "loop-coupled", message, hint)

    def _around(self, equality: int) -> set[int]:
        """The joints of the loop that two joined bodies close."""
        import mujoco

        model, ends = self._model, self._ends(equality)
        if mujoco.mjtObj(int(model.eq_objtype[equality])) == mujoco.mjtObj.mjOBJ_SITE:
            ends = int(model.site_bodyid[ends[0]]), int(model.site_bodyid[ends[1]])
        above = [set[int](), set[int]()]
        for end, bodies in zip(ends, above, strict=True):
            while end > 0:
                bodies.add(end)
                end = int(model.body_parentid[end])
        around = above[0] ^ above[1]
        return {joint for joint in self._moving if int(model.jnt_bodyid[joint]) in around}
