"""Does a scene give its monitors anything to watch."""

from __future__ import annotations

from graspdsl.compiler.complaints import Complaints
from graspdsl.objects.shapes import catalogue
from graspdsl.places.document import Document, Path
from graspdsl.spec.models import Spec
from graspdsl.spec.monitors import MONITORS
from graspdsl.spec.scene import InlineObject
from graspdsl.spec.watching import OFF, SceneFacts
from graspdsl.worlds.kinds import WORLDS


def check_monitors(spec: Spec, document: Document, complaints: Complaints) -> None:
    """Warn of monitors that are asked for and can never speak in the scene."""
    scene = facts_of(spec)
    for key in sorted(spec.monitors.model_fields_set):
        monitor, bound = MONITORS[key], scene.bounds[key]
        lacking = [scene.lacks[need] for need in monitor.needs if need in scene.lacks]
        if bound != OFF and (reason := lacking[0] if lacking else monitor.out_of_reach(bound, scene)):
            path: Path = ("monitors", key)
            complaints.about(path)
            complaints.warning("no-effect", f"{key} has no effect: {reason}", document.key_span(path), "leave it out")


def facts_of(spec: Spec) -> SceneFacts:
    """What of a spec matters to monitors."""
    thing, world = spec.scene.object, WORLDS[spec.scene.world]
    lacks = {"table": "for a held object the table is out of the way"} if spec.scene.held else {}
    if spec.scene.afloat:
        why = "without gravity an object floats"
        lacks |= {"table": f"{why}, and the table is out of the way", "upright": f"{why}: it may turn, and never falls"}
    if isinstance(thing, InlineObject) and thing.fixed:
        lacks["motion"] = "the object is fixed to the world"
    if _is_ball(thing):
        lacks["upright"] = "a ball may roll, and never leans"
    return SceneFacts(
        lacks={**lacks, **{str(ability): why for ability, why in world.lacks.items()}},
        longest=max(phase.limit for phase in spec.program),
        waiting=tuple(p.limit for p in spec.program if p.until.force_residual or p.until.moment_residual),
        tick=None if world.probes(spec.control.displacement) else 1.0 / world.rate,
        bounds={key: spec.monitors.given(key) for key in MONITORS},
    )


def _is_ball(thing: str | InlineObject) -> bool:
    name = thing if isinstance(thing, str) else thing.like
    if name is None:
        return isinstance(thing, InlineObject) and thing.shape is not None and thing.shape.rolls
    known = catalogue().get(name)
    return known is not None and known.shape.rolls
