"""Does a scene give its monitors anything to watch."""

from __future__ import annotations

from collections.abc import Mapping

from graspdsl.compiler.complaints import Complaints
from graspdsl.objects.shapes import catalogue
from graspdsl.places.document import Document, Path
from graspdsl.spec.models import Spec
from graspdsl.spec.monitors import OFF, TIMES
from graspdsl.spec.scene import InlineObject
from graspdsl.worlds.kind import Ability
from graspdsl.worlds.kinds import WORLDS

NEEDS: Mapping[Ability, tuple[str, ...]] = {
    "hand": ("palm", "link", "table", "joint_limit"),
    "motion": ("lean", "shift", "dragged"),
    "parting": ("lost",),
}
FIXED = dict.fromkeys(("lean", "shift", "dragged"), "the object is fixed to the world")
HELD = {"table": "for a held object the table is out of the way"}
ROLLING = {"lean": "a ball may roll, and never leans"}


def check_monitors(spec: Spec, document: Document, complaints: Complaints) -> None:
    """Warn of monitors that are asked for and can never speak in the scene."""
    idle = {**_never_long_enough(spec), **_idle(spec)}
    for name in sorted(spec.monitors.model_fields_set & idle.keys()):
        if getattr(spec.monitors, name) != OFF:
            path: Path = ("monitors", name)
            complaints.about(path)
            message = f"{name} has no effect: {idle[name]}"
            complaints.warning("no-effect", message, document.key_span(path), "leave it out")


def _never_long_enough(spec: Spec) -> Mapping[str, str]:
    """The monitors whose bounds no trial can reach, each with the reason."""
    bounds, world, idle = spec.monitors, WORLDS[spec.scene.world], dict[str, str]()
    longest = max(phase.limit for phase in spec.program)
    waiting = [phase.limit for phase in spec.program if phase.until.force_residual or phase.until.moment_residual]
    for name in TIMES:
        bound = getattr(bounds, name)
        if bound != OFF and bound >= longest:
            idle[name] = f"no phase lasts for more than {longest:g} s"
    if bounds.dragged != OFF and bounds.shift != OFF and bounds.dragged >= bounds.shift:
        idle["dragged"] = f"an object that has moved by {bounds.shift:g} m has ended the trial as diverged"
    if not waiting:
        idle["progress"] = "no phase waits for a residual"
    elif bounds.progress != OFF and not world.probes(spec.control.displacement):
        window = bounds.progress.window
        if 2.0 * window > max(waiting) + 1.0 / world.rate:
            idle["progress"] = f"no phase that waits for a residual lasts for two windows of {window:g} s"
    return idle


def _idle(spec: Spec) -> Mapping[str, str]:
    """The monitors that have nothing to watch, each with the reason."""
    thing = spec.scene.object
    lacks = WORLDS[spec.scene.world].lacks
    idle = dict(HELD) if spec.scene.held else {}
    idle |= {name: why for need, why in lacks.items() for name in NEEDS.get(need, ())}
    if "motion" in lacks:
        return idle
    if isinstance(thing, InlineObject) and thing.fixed:
        return {**idle, **FIXED}
    return {**idle, **ROLLING} if _is_ball(thing) else idle


def _is_ball(thing: str | InlineObject) -> bool:
    name = thing if isinstance(thing, str) else thing.like
    if name is None:
        return isinstance(thing, InlineObject) and thing.shape is not None and thing.shape.rolls
    known = catalogue().get(name)
    return known is not None and known.shape.rolls
