"""What a formula pasted from the literature leaves open: names of resources and of references, taken for the usual."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import fields, replace

from graspdsl.compiler.surroundings import Surroundings
from graspdsl.notation.parser import parse_resources
from graspdsl.notation.tree import Abbreviation, Controller, Name, Reference, Resources, ResourceSet, Transform, Virtual

_POSTURE = {"σ_k", "τ_k"}  # which take joints, and not contacts
_JOINTS, _SET = "all", "Γ"
_ACT_AS_ONE = re.compile(r"γ([1-9]{2,})")

Tree = Reference | Transform | Resources


def assumed_around(tree: Tree, around: Surroundings) -> Surroundings:
    """What is around a formula, with a meaning for each name of which nothing is said.

    Γ_… is Γ, or all joints where posture is sensed or moved; γ23 is <γ2, γ3> where those are known; a reference is
    zero, of three numbers for each of its controller's contacts.
    """
    resources, parameters = dict(around.resources or {}), dict(around.parameters)
    of_joints = {
        name.text
        for node in _parts(tree)
        if isinstance(node, Transform) and node.name.text in _POSTURE
        for name in _named(node.resources)
    }
    given = [node for node in _parts(tree) if isinstance(node, Transform | Abbreviation)]
    for name in [name.text for node in given for name in _given(node)]:
        together = _ACT_AS_ONE.fullmatch(name)
        members = [f"γ{digit}" for digit in together.group(1)] if together else []
        if name in resources:
            continue
        if members and all(member in resources for member in members) and len(set(members)) == len(members):
            resources[name] = f"<{', '.join(members)}>"
        elif name.startswith("Γ_"):
            resources[name] = _JOINTS if name in of_joints else resources[_SET]
    for node in _parts(tree):
        if isinstance(node, Controller | Abbreviation) and isinstance(node.reference, Name):
            sensed = node.sensor.resources if isinstance(node, Controller) else node.sensor[0]
            if node.reference.text not in parameters:
                parameters[node.reference.text] = [0.0] * (3 * _count(sensed, resources))
    return replace(around, resources=resources, parameters=parameters)


def _count(tree: Resources, resources: dict[str, str]) -> int:
    """How many contacts and virtual contacts a resource is."""
    if isinstance(tree, Name) and resources.get(tree.text, "")[:1] == "{":
        tree = parse_resources(resources[tree.text])
    return len(tree.members) if isinstance(tree, ResourceSet) else 1


def _given(node: Transform | Abbreviation) -> Iterator[Name]:
    for resource in (node.resources,) if isinstance(node, Transform) else (*node.effector, *node.sensor):
        yield from _named(resource)


def _named(tree: Resources) -> Iterator[Name]:
    if isinstance(tree, Virtual | ResourceSet):
        for member in tree.members:
            yield from _named(member)
    else:
        yield tree


def _parts(tree: Tree) -> Iterator[Tree]:
    """A tree and all that is in it."""
    yield tree
    for field in fields(tree):
        value = getattr(tree, field.name)
        for part in value if isinstance(value, tuple) else (value,):
            if isinstance(part, Tree):
                yield from _parts(part)
