"""How the cost of a tick grows with contacts, joints and levels, on hands made for it; and that of floating trials with
how many there are.

What is told is the exponent p of cost ~ size^p, fitted over all sizes. Small sizes cost what a call of numpy costs,
whatever it is called with, which keeps p below that of the arithmetic.
"""

from __future__ import annotations

import math
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from measuring import Row, exponent, in_turn, told

import graspdsl
from graspdsl.compiler.program import program_of
from graspdsl.trials.setup import trial_loop
from graspdsl.worlds.protocol import Observation

FLOATING = Path(__file__).resolve().parents[1] / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
SLIDE = "π_s|Γ Γ (π_gx|Γ Γ)"
CONTACTS, JOINTS, LEVELS = (2, 3, 4, 5, 6, 8, 10), (4, 8, 12, 16, 24, 32, 40), (1, 2, 3, 4, 5, 6)
FINGERS = 4  # where joints are many or few
MIDDLE = 20  # joints, where contacts are many or few
TRIALS = (1_000, 10_000, 100_000)
SHORT = ("program.0.limit=0.08", "program.0.until.hold=0.04")  # s: four ticks a trial
LONGEST = 90.0  # s, of one number of trials
ROUNDS, EACH = 30, 5
INERTIA = '<inertial><mass value="0.05"/><inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial>'
LENGTH = 0.12  # m, of a finger


def rows() -> Iterator[Row]:
    """The exponents."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ticks = {count: tick_of(SLIDE, hand(folder, count, MIDDLE), count) for count in CONTACTS}
        yield fitted("tick of π_sgx by contacts", ticks, "≤ 1")
        ticks = {
            count: tick_of(SLIDE, hand(folder, min(FINGERS, count), count), min(FINGERS, count)) for count in JOINTS
        }
        yield fitted("tick of π_sgx by joints of the hand, besides six of the mount", ticks, "≤ 2")
        model, most = hand(folder, max(LEVELS), MIDDLE), max(LEVELS)
        ticks = {count: tick_of(chain(count), model, most) for count in LEVELS}
        yield fitted("tick by levels, above that of one", ticks, "≤ 1", above_first=True)
    yield floating()


def fitted(what: str, ticks: Mapping[int, Callable[[], object]], bound: str, *, above_first: bool = False) -> Row:
    """The row of ticks by their sizes. ``above_first``: of what cost and size are more than the first ones, where that
    does not do what all others do: a level alone projects nothing."""
    times = in_turn({str(size): tick for size, tick in ticks.items()}, ROUNDS, EACH)
    costs, sizes = np.array([np.median(taken) for taken in times.values()]), np.array(list(ticks), float)
    note = f"{min(ticks)}: {told(costs[0])}, {max(ticks)}: {told(costs[-1])}"
    if above_first:
        sizes, costs = sizes[1:] - sizes[0], costs[1:] - costs[0]
    return Row(f"{what}: exponent", exponent(sizes, costs), bound, None, note)


def tick_of(formula: str, model: Path, contacts: int) -> Callable[[], object]:
    """A tick of a formula on a hand of so many contacts, that press on something."""
    names = [f"γ{number + 1}" for number in range(contacts)]
    resources = {name: f"tip-{number}" for number, name in enumerate(names)}
    resources["Γ"] = f"{{{', '.join(names)}}}"
    controller = graspdsl.compile(
        formula, hand=model, resources=resources, parameters={"κ_f": 0.5, "x_far": [0.0, 0.0, 0.1]}
    )
    seen = observed(contacts, len(controller.joints))
    return lambda: controller.pipeline.ticks(seen, certified=False)


def chain(levels: int) -> str:
    """So many levels, each to take one contact somewhere."""
    return " ◁ ".join(f"φ_p|τ_p({{γ{number + 1}}}) σ_p({{γ{number + 1}}}) (x_far)" for number in range(levels))


def observed(contacts: int, joints: int) -> Observation:
    """Contacts that touch, anywhere."""
    random = np.random.default_rng(0)
    normals = random.normal(size=(contacts, 3))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return Observation(
        time=0.0,
        points=0.05 * random.normal(size=(contacts, 3)),
        normals=normals,
        forces=normals,
        touching=np.ones(contacts, dtype=bool),
        joints=np.zeros(joints),
        jacobian=0.1 * random.normal(size=(contacts, 3, joints)),
        angular_jacobian=random.normal(size=(contacts, 3, joints)),
        orientations=np.zeros((contacts, 3)),
        centre_of_mass=np.full(3, np.nan),
        weight=np.full(3, np.nan),
    )


def hand(folder: Path, fingers: int, joints: int) -> Path:
    """The file of a hand with fingers round a palm, which share so many joints."""
    name = f"hand-{fingers}-{joints}"
    shares = [joints // fingers + (number < joints % fingers) for number in range(fingers)]
    links = [f'<link name="palm">{INERTIA}</link>']
    lines = [f"hand: {name}", f"urdf: {name}.urdf", "root: palm", "palm: palm", "palm_surface: 0.02", "joints:"]
    contacts = ["contacts:"]
    for number, share in enumerate(shares):
        turn, parent = 2.0 * math.pi * number / fingers, "palm"
        for place in range(share):
            link = f"link-{number}-{place}"
            origin = f'xyz="0 0 {LENGTH / share:g}"'
            if not place:
                origin = f'xyz="{0.08 * math.cos(turn):.6f} {0.08 * math.sin(turn):.6f} 0.02" rpy="0 0 {turn:.6f}"'
            links.append(
                f'<link name="{link}">{INERTIA}</link><joint name="bend-{number}-{place}" type="revolute">'
                f'<parent link="{parent}"/><child link="{link}"/><origin {origin}/><axis xyz="0 -1 0"/>'
                '<limit lower="-1.5" upper="1.5" effort="1" velocity="2"/></joint>'
            )
            lines.append(f"  bend-{number}-{place}: {{weight: 10.0, closes: 1}}")
            parent = link
        links.append(
            f'<link name="end-{number}">{INERTIA}</link><joint name="cell-{number}" type="fixed">'
            f'<parent link="{parent}"/><child link="end-{number}"/><origin xyz="0 0 {LENGTH / share:g}"/></joint>'
        )
        own = ", ".join(f"bend-{number}-{place}" for place in range(share))
        contacts.append(
            f"  tip-{number}: {{link: end-{number}, cell: cell-{number}, sphere: {{radius: 0.01}}, finger: [{own}]}}"
        )
    (folder / f"{name}.urdf").write_text(f'<robot name="{name}">{"".join(links)}</robot>', encoding="utf-8")
    path = folder / f"{name}.yaml"
    path.write_text("\n".join([*lines, *contacts, "postures:", "  open: {}"]) + "\n", encoding="utf-8")
    return path


def floating(sizes: Sequence[int] = TRIALS) -> Row:
    """Trials of a few ticks, chunk after chunk as they run, and what memory grows by. The processor's time is told, for
    numbers this far apart have no turns."""
    loop = trial_loop(program_of(FLOATING.read_text("utf-8"), FLOATING.name, SHORT))
    for _ in loop.run_all(range(loop.together), 0):
        pass
    taken, grown, before = dict[int, float](), dict[int, float](), _most_memory()
    for size in sizes:
        if taken and max(taken.values()) * size / max(taken) > LONGEST:
            break
        began = time.process_time()
        for _ in loop.run_all(range(size), 0):
            pass
        taken[size], grown[size] = time.process_time() - began, _most_memory() - before
    said = ", ".join(f"{size}: {told(seconds)}, +{grown[size]:.0f} MB" for size, seconds in taken.items())
    left = [f"{size} would take too long" for size in sizes if size not in taken]
    note = "; ".join([said, *left])
    what = "floating trials by how many: exponent"
    return Row(what, exponent(list(taken), list(taken.values())), "≤ 1.05", None, note)


def _most_memory() -> float:
    """The most that this process has had in memory so far [MB]."""
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most / 1e6 if sys.platform == "darwin" else most / 1e3
