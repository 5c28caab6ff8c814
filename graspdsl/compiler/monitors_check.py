"""Does a scene give its monitors anything to watch."""

from __future__ import annotations

from collections.abc import Mapping

from graspdsl.compiler.complaints import Complaints
from graspdsl.objects.shapes import Sphere, catalogue
from graspdsl.spec.constructing import Path
from graspdsl.spec.document import Document
from graspdsl.spec.models import Spec
from graspdsl.spec.monitors import OFF
from graspdsl.spec.scene import InlineObject
from graspdsl.worlds.kinds import WORLDS

FLOATING = dict.fromkeys(("palm", "link", "table", "joint_limit"), "floating contacts have no hand")
STAYING = dict.fromkeys(("lean", "shift", "dragged"), "the object that contacts float on stays put")
TOUCHING = {"lost": "floating contacts never leave the surface"}
FIXED = dict.fromkeys(("lean", "shift", "dragged"), "the object is fixed to the world")
HELD = {"table": "for a held object the table is out of the way"}
ROLLING = {"lean": "a ball may roll, and never leans"}


def check_monitors(spec: Spec, document: Document, complaints: Complaints) -> None:
    """Warn of monitors that are asked for and can never speak in the scene."""
    idle = _idle(spec)
    for name in sorted(spec.monitors.model_fields_set & idle.keys()):
        if getattr(spec.monitors, name) != OFF:
            path: Path = ("monitors", name)
            complaints.about(path)
            message = f"{name} has no effect: {idle[name]}"
            complaints.warning("no-effect", message, document.key_span(path), "leave it out")


def _idle(spec: Spec) -> Mapping[str, str]:
    """The monitors that have nothing to watch, each with the reason."""
    thing = spec.scene.object
    if WORLDS[spec.scene.world].floats:
        return {**FLOATING, **STAYING, **TOUCHING}
    idle = dict(HELD) if spec.scene.held else {}
    if isinstance(thing, InlineObject) and thing.fixed:
        return {**idle, **FIXED}
    return {**idle, **ROLLING} if _is_ball(thing) else idle


def _is_ball(thing: str | InlineObject) -> bool:
    name = thing if isinstance(thing, str) else thing.like
    if name is None:
        return isinstance(thing, InlineObject) and thing.sphere is not None
    known = catalogue().get(name)
    return known is not None and isinstance(known.shape, Sphere)
