"""Generated formulas out of the names of the basis and of the default scene: any of them, and sound ones."""

from __future__ import annotations

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from graspdsl.basis.effectors import EFFECTORS
from graspdsl.basis.potentials import POTENTIALS
from graspdsl.basis.prelude import prelude
from graspdsl.basis.sensors import SENSORS
from graspdsl.basis.spaces import GradientSpace
from graspdsl.notation.tree import (
    Abbreviation,
    Controller,
    Expression,
    Name,
    Reference,
    Resource,
    Resources,
    ResourceSet,
    ScaledSensor,
    SubjectTo,
    Then,
    Transform,
    Vector,
    Virtual,
)

contacts = st.sampled_from(["γ1", "γ2", "γ3"]).map(Name)
virtual = st.permutations(["γ1", "γ2", "γ3"]).map(lambda names: Virtual(tuple(map(Name, names[:2]))))
odd: SearchStrategy[Resource] = st.sampled_from(
    [Name("γ_g"), Name("γ9"), Name("Γ"), Name("flexion"), Virtual(()), Virtual((Name("γ1"), Name("γ_g")))]
)
members = st.lists(contacts | virtual | odd, max_size=3).map(tuple)
resources: SearchStrategy[Resources] = st.one_of(
    st.just(Name("Γ")),
    st.just(Name("Γ")),
    contacts,
    virtual,
    st.sampled_from(["flexion", "all", "γ_g"]).map(Name),
    members.map(ResourceSet),
    members.map(Virtual),
)
vectors = st.sampled_from([1, 3, 6, 9, 10]).map(lambda size: Vector((0.25,) * size))
factors = st.none() | st.floats(-2, 2) | st.sampled_from(["κ_f", "κ_x"]).map(Name)


def _transforms(table: list[str]) -> SearchStrategy[Transform]:
    return st.builds(Transform, st.sampled_from(table).map(Name), resources)


scaled = st.builds(ScaledSensor, factors, _transforms([*SENSORS, "σ_z"]))


def _controllers(references: SearchStrategy[Reference | None]) -> SearchStrategy[Expression]:
    anything = st.builds(
        Controller,
        st.sampled_from([*POTENTIALS, "φ_z"]).map(Name),
        _transforms([*EFFECTORS, "τ_z"]),
        _transforms([*SENSORS, "σ_z"]),
        references,
    )
    names = st.sampled_from([*prelude(), "π_z"]).map(Name)
    abbreviation = st.builds(
        lambda name, over, reference: Abbreviation(name, (over,), (over,), reference), names, resources, references
    )
    return abbreviation | abbreviation | anything


def _larger(smaller: SearchStrategy[Expression]) -> SearchStrategy[Expression]:
    several = st.lists(smaller, min_size=2, max_size=3).map(tuple)
    return several.map(SubjectTo) | several.map(Then) | _controllers(smaller)


formulas: SearchStrategy[Expression] = st.recursive(
    _controllers(st.none() | vectors | scaled | st.just(Name("κ_f"))), _larger, max_leaves=5
)


three = ["γ1", "γ2", "γ3"]
apart = st.permutations(three).flatmap(
    lambda names: st.sampled_from(
        [
            Name("Γ"),
            Name(names[0]),
            ResourceSet((Name(names[0]), Name(names[1]))),
            ResourceSet((Virtual((Name(names[0]), Name(names[1]))), Name(names[2]))),
            Virtual((Name(names[0]), Virtual((Name(names[1]), Name(names[2]))))),
        ]
    )
)

joint_sets = st.sampled_from(["flexion", "fingers", "wrist", "all"]).map(Name)


def _with_gravity(tree: Resources) -> SearchStrategy[Resources]:
    """Resources as they are, and with gravity beside them or, for a virtual contact, inside it."""
    gravity = Name("γ_g")
    if isinstance(tree, Virtual):
        return st.sampled_from([tree, Virtual((*tree.members, gravity)), ResourceSet((tree, gravity)), gravity])
    if isinstance(tree, ResourceSet):
        return st.sampled_from([tree, ResourceSet((*tree.members, gravity))])
    if tree.text == "Γ":
        return st.just(tree)
    return st.sampled_from([tree, ResourceSet((gravity, tree)), Virtual((tree, gravity))])


@st.composite
def sound(draw: st.DrawFn, space: GradientSpace) -> Expression:
    """One to three controllers of a gradient space under ◁, each of them as the tables have it."""
    terms = [draw(_sound_controller(space)) for _ in range(draw(st.integers(1, 3)))]
    return terms[0] if len(terms) == 1 else SubjectTo(tuple(terms))


@st.composite
def _sound_controller(draw: st.DrawFn, space: GradientSpace) -> Expression:
    ways = [(p, name) for p in POTENTIALS.values() for name in p.effectors if EFFECTORS[name].gradient_space is space]
    potential, effector = draw(st.sampled_from(ways))
    sensor = draw(st.sampled_from(potential.sensors))
    sensed: Resources
    moved: Resources
    if SENSORS[sensor].over_joints:
        sensed, moved = draw(joint_sets), draw(joint_sets)
    else:
        sensed = draw(apart)
        moved = sensed if SENSORS[sensor].per_contact else draw(apart)
    if sensor == "σ_r":  # over any contacts, whichever are moved, and gravity leaves it alone
        moved, sensed = draw(apart), draw(_with_gravity(sensed).filter(lambda tree: tree != Name("γ_g")))
    if not (SENSORS[sensor].per_contact or SENSORS[sensor].over_joints):
        sensed = draw(_with_gravity(sensed))
    reference: Reference | None = None
    if potential.references and not (potential.has_default_reference and draw(st.booleans())):
        name = draw(st.sampled_from(potential.references))
        least = 0.0 if SENSORS[name].makes_forces else -2.0  # contacts push along their normals, they cannot pull
        factor = draw(st.none() | st.floats(least, 2) | st.just(Name("κ_f")))
        reference = ScaledSensor(factor, Transform(Name(name), sensed))
        if potential.displaced_by is not None and draw(st.booleans()):
            reference = draw(sound(potential.displaced_by))
    return Controller(
        Name(potential.symbol), Transform(Name(effector), moved), Transform(Name(sensor), sensed), reference
    )
