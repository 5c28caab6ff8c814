"""Generated syntax trees: every shape that the notation can write, with brackets well below the nesting limit."""

from __future__ import annotations

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from graspdsl.notation.names import canonical
from graspdsl.notation.tree import (
    Abbreviation,
    Controller,
    Expression,
    Head,
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

LETTER = "[A-Za-zΑ-ΡΣ-Ωα-ρσ-ω]"
PIECE = "[A-Za-zΑ-ΡΣ-Ωα-ρσ-ω0-9]{1,4}|[a-z]?(alpha|theta|sigma|eta|Gamma|phi|g|G)|[0-9]"
HEADS = ("φ", "τ", "σ", "π")

# Words as a user may type them.
subscripts: SearchStrategy[str] = st.lists(
    st.tuples(st.sampled_from(["_", "__"]), st.from_regex(PIECE, fullmatch=True)).filter(
        lambda piece: piece[0] == "_" or not piece[1][0].isdigit()
    ),
    max_size=3,
).map(lambda pieces: "".join(seam + piece for seam, piece in pieces))
words = st.tuples(st.from_regex(f"({LETTER})({PIECE})?|gamma|Gamma|g|G|kappa", fullmatch=True), subscripts).map("".join)


def has_role(name: str) -> bool:
    """Whether a canonical name is that of a potential, a transform or an abbreviation."""
    return name[0] in HEADS and (len(name) == 1 or not name[1].isalpha())


def _role(head: str) -> SearchStrategy[Name]:
    return subscripts.map(lambda rest: Name(canonical(head + rest))).filter(lambda name: has_role(name.text))


names = words.map(lambda word: Name(canonical(word))).filter(
    lambda name: name.text != "then" and not has_role(name.text)
)
potentials, effectors, sensors, abbreviations = map(_role, HEADS)

resource: SearchStrategy[Resource] = st.recursive(
    names, lambda members: st.lists(members, max_size=3).map(lambda some: Virtual(tuple(some))), max_leaves=4
)
resources: SearchStrategy[Resources] = resource | st.lists(resource, max_size=3).map(
    lambda some: ResourceSet(tuple(some))
)
arguments = st.lists(resources, min_size=1, max_size=3).map(tuple)

numbers = st.floats(allow_nan=False, allow_infinity=False)
vectors = st.lists(numbers, min_size=1, max_size=6).map(lambda values: Vector(tuple(values)))
scaled = st.builds(ScaledSensor, st.none() | numbers | names, st.builds(Transform, sensors, resources))


def _controllers(references: SearchStrategy[Reference | None]) -> SearchStrategy[Expression]:
    return (
        st.builds(
            Controller,
            potentials,
            st.builds(Transform, effectors, resources),
            st.builds(Transform, sensors, resources),
            references,
        )
        | st.builds(Abbreviation, abbreviations, arguments, arguments, references)
        | st.builds(Abbreviation, abbreviations)
    )


def _larger(smaller: SearchStrategy[Expression]) -> SearchStrategy[Expression]:
    several = st.lists(smaller, min_size=2, max_size=3).map(tuple)
    return several.map(SubjectTo) | several.map(Then) | _controllers(smaller)


expressions: SearchStrategy[Expression] = st.recursive(
    _controllers(st.none() | vectors | names | scaled), _larger, max_leaves=6
)

parameters = st.lists(names, min_size=1, max_size=3).map(tuple)
heads: SearchStrategy[Head] = st.builds(Head, abbreviations) | st.builds(
    Head, abbreviations, parameters, parameters, st.none() | names
)
