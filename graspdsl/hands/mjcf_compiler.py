"""What <compiler> says of a whole MJCF file."""

from __future__ import annotations

from typing import NamedTuple
from xml.etree import ElementTree

from graspdsl.hands.mjcf_known import check_inside, whole
from graspdsl.hands.mjcf_parts import Angles, Source


class Compiler(NamedTuple):
    """How angles are read, whether a range alone limits a joint, and whether geoms weigh where no <inertial> is."""

    angles: Angles
    autolimits: bool
    geoms_weigh: bool


def compiler_of(tree: ElementTree.Element, source: Source) -> Compiler:
    """What all <compiler> say together; later ones go first. What is not read is noted in the source."""
    angles, autolimits, geoms_weigh = Angles(True, "xyz"), True, True
    for element in tree.findall("compiler"):
        with source.noting():
            part = whole(source, element)
            check_inside(source, element)
            if "angle" in part.attributes:
                angles = Angles(part.word("angle", ("degree", "radian")) == "degree", angles.sequence)
            if "autolimits" in part.attributes:
                autolimits = part.word("autolimits", ("true", "false")) == "true"
            if "inertiafromgeom" in part.attributes:
                geoms_weigh = part.word("inertiafromgeom", ("auto", "false")) == "auto"
            sequence = part.attributes.get("eulerseq", angles.sequence)
            if len(sequence) != 3 or not set(sequence.lower()) <= set("xyz"):
                raise part.refused(f"its eulerseq is {sequence!r}", "expected three letters out of xyzXYZ")
            angles = Angles(angles.degrees, sequence)
    return Compiler(angles, autolimits, geoms_weigh)
