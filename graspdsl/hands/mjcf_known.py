"""What of MJCF is read, what may be left out, and the refusal, by name, of all else."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree import ElementTree

from graspdsl.diagnostics import listed
from graspdsl.hands.mjcf_parts import IN_URDF, ORIENTATIONS, Part, Source, refuse_all

READ: Mapping[str, frozenset[str]] = {
    tag: frozenset(keys)
    for tag, keys in {
        "mujoco": ("model",),
        "compiler": ("angle", "eulerseq", "autolimits"),
        "default": ("class",),
        "worldbody": (),
        "body": ("name", "childclass", "pos", *ORIENTATIONS),
        "frame": ("name", "childclass", "pos", *ORIENTATIONS),
        "inertial": ("pos", "mass", "diaginertia", "fullinertia", *ORIENTATIONS),
        "joint": (
            *("name", "class", "type", "pos", "axis", "range", "limited", "damping", "armature", "frictionloss"),
            *("actuatorfrcrange", "actuatorfrclimited"),
        ),
        "geom": ("name", "class", "type", "size", "fromto", "pos", "contype", "conaffinity", *ORIENTATIONS),
        "exclude": ("name", "body1", "body2"),
    }.items()
}

# Looks, names for other elements, what has a say only about meshes, free bodies or inertias from geoms, which are
# refused themselves, and the softness and friction of contacts, which the spec and the world give.
LEFT_OUT: Mapping[str, frozenset[str]] = {
    tag: frozenset(keys.split())
    for tag, keys in {
        "compiler": "meshdir texturedir assetdir strippath discardvisual convexhull exactmeshinertia fitaabb usethread "
        "fusestatic alignfree saveinertial inertiagrouprange",
        "body": "user sleep",
        "joint": "group user margin solreflimit solimplimit solreffriction solimpfriction springref actuatorgravcomp",
        "geom": "group user rgba material castshadow mass density shellinertia friction condim priority margin gap "
        "solref solimp solmix",
    }.items()
}

# Whatever else these say changes how a hand is built, moves or weighs.
ONLY_AS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "compiler": {
        "coordinate": ("local",),
        "inertiafromgeom": ("auto", "false"),
        "balanceinertia": ("false",),
        "boundmass": ("0",),
        "boundinertia": ("0",),
        "settotalmass": ("-1",),
    },
    "body": {"gravcomp": ("0",), "mocap": ("false",)},
    "joint": {
        "ref": ("0",),
        "stiffness": ("0",),
    },
}

INSIDE: Mapping[str, frozenset[str]] = {
    tag: frozenset(tags.split())
    for tag, tags in {
        "mujoco": "compiler default worldbody contact equality "
        "option size statistic visual asset tendon actuator sensor custom keyframe",
        "compiler": "lengthrange",
        "worldbody": "body frame geom site camera light",
        "body": "body frame joint geom inertial site camera light",
        "frame": "body frame joint geom inertial site camera light",
        "contact": "exclude",
        "equality": "joint tendon",
    }.items()
}

HINTS = {
    "freejoint": "take it out: the mount carries the hand",
    "include": "put the text of that file in its place",
    "mesh": "draw it as spheres, capsules, cylinders and boxes, or describe the hand in URDF",
}


def whole(source: Source, element: ElementTree.Element, attributes: Mapping[str, str] | None = None) -> Part:
    """The element with these attributes, or its own. Raises DiagnosticError for those that are not read."""
    refused = []
    part = Part(source, element, element.attrib if attributes is None else attributes)
    tag = element.tag
    for key, value in part.attributes.items():
        if key in READ[tag] or key in LEFT_OUT.get(tag, ()):
            continue
        allowed = ONLY_AS.get(tag, {}).get(key)
        if allowed is None:
            refused.append(part.refused(f"its {key} is not read", HINTS.get(key, IN_URDF)))
        elif not any(_same(value, word) for word in allowed):
            hint = f"write {key}={_quoted(allowed)}, or describe the hand in URDF"
            refused.append(part.refused(f"{key}={value!r} would change the hand and is not read", hint))
    refuse_all(refused)
    return part


def check_inside(source: Source, element: ElementTree.Element) -> None:
    """Raises DiagnosticError for the elements within this one that are not read, and may not be left out."""
    refuse_all(
        [
            source.refused(inner, f"<{inner.tag}> in <{element.tag}> is not read", HINTS.get(inner.tag, IN_URDF))
            for inner in element
            if inner.tag not in INSIDE.get(element.tag, ())
        ]
    )


def _same(value: str, word: str) -> bool:
    try:
        return float(value) == float(word)
    except ValueError:
        return value == word


def _quoted(words: tuple[str, ...]) -> str:
    return listed([f'"{word}"' for word in words], "or")
