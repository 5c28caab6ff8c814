"""Does a scene's sensor go with its hand, and is the threshold of touch above its noise?"""

from __future__ import annotations

from graspdsl.compiler.complaints import Complaints
from graspdsl.diagnostics import listed
from graspdsl.hands.descriptions import Robot
from graspdsl.places.document import Document, Path
from graspdsl.spec.models import Spec
from graspdsl.spec.sensing import LoadCell, Sensing
from graspdsl.worlds.kinds import WORLDS

DEVIATIONS = 4.0  # of the noise of a reading that a touch should begin above


def check_sensing(spec: Spec, document: Document, robot: Robot, complaints: Complaints) -> None:
    """Complain about load cells that the hand has not; warn of a touch that noise alone would begin."""
    world = WORLDS[spec.scene.world]
    if world.floats:
        return
    sensor = spec.scene.sensor
    path: Path = ("scene", "hand" if spec.scene.sensing is None else "sensing")
    without = [name for name, contact in robot.hand.contacts.items() if contact.link and not contact.cell]
    if isinstance(sensor, LoadCell) and without:
        message = (
            f"{listed(without)} of the hand {robot.hand.hand} {'have' if len(without) > 1 else 'has'} no load cell"
        )
        complaints.about(path)
        hint = "use sensing: skin, proximity or exact, or name the load cell's joint in the hand file"
        complaints.error("not-sensed", message, document.span(path), hint)
    noise = sensor.force_noise_at(world.rate)
    if isinstance(spec.scene.sensing, Sensing) and sensor.touch.begins < DEVIATIONS * noise:
        complaints.about(path)
        message = (
            f"a touch begins at {sensor.touch.begins:g} N, but the force of a reading has {noise:.2g} N of noise: "
            "fingers will feel touches that are none"
        )
        hint = f"let it begin above {DEVIATIONS * noise:.2g} N: 'touch: {{begins: …, ends: …}}', or lower the noise"
        complaints.warning("threshold-in-noise", message, document.span(path), hint)
