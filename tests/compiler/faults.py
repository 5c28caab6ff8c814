"""Specs with faults, and the text of what is said of them.

``python -m compiler.faults`` in the folder ``tests`` prints what ``golden/diagnostics.txt`` should hold.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from graspdsl.compiler.program import examine
from graspdsl.diagnostics import Diagnostic, as_text

from .specs import floating, spec


@dataclass(frozen=True)
class Case:
    """A spec, what is given on the command line, and what the two have to do with each other."""

    about: str
    text: str
    overrides: tuple[str, ...] = ()

    @cached_property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """What is said of it."""
        return examine(self.text, "spec.yaml", self.overrides).diagnostics

    def __str__(self) -> str:
        said = [as_text(diagnostic, "spec.yaml", self.text) for diagnostic in self.diagnostics]
        return "\n".join([f"## {self.about}", *said])


def _formula(about: str, formula: str) -> Case:
    return Case(about, spec(formula))


def _floating(about: str, *formulas: str, **parts: str) -> Case:
    return Case(about, floating(*formulas, **parts))


def _held(about: str, formula: str) -> Case:
    return Case(about, spec(formula, scene="world: bullet, object: {like: towel-roll, held: true}"))


def _resource(about: str, name: str, meaning: str) -> Case:
    return Case(about, spec(resources={name: meaning}))


def _controller(about: str, formula: str, definitions: dict[str, str]) -> Case:
    return Case(about, spec(formula, controllers=definitions))


def _chain(first: str, next_one: str) -> dict[str, str]:
    return {"π_a0|Γ Γ": first, **{f"π_a{i}|Γ Γ": next_one.replace("π_a", f"π_a{i - 1}") for i in range(1, 41)}}


TOWEL_ROLL = "world: bullet, hand: barrett, object: towel-roll"
SCENE = (
    Case("a start posture of a joint that is not there", spec(start="posture: {spred-1: 1.0}")),
    Case("a start posture beyond a limit", spec(start="posture: {spread-1: {uniform: [1.0, 4.0]}}")),
    Case("trials that are all equal", spec().replace("program:", "trials: {count: 4, start: {roll: 0.3}}\nprogram:")),
    Case("trials that are all equal, on the command line", spec(start="roll: 0.3"), ("trials.count=8",)),
    Case("a hand that is not there", spec(scene="world: bullet, hand: baret, object: towel-roll")),
    Case("a mount that is not there", spec(scene="world: bullet, mount: gantri, object: towel-roll")),
    Case(
        "an object that another hand does not hold",
        spec(scene="world: bullet, mount: dexter, object: ball"),
    ),
    Case("an object that is not there", spec(scene="world: bullet, object: towel-rol")),
    Case("a file of triangles by its name alone", spec(scene="world: bullet, object: parts/part.STL")),
    Case("a URDF file by its name alone", spec(scene="world: bullet, object: {like: part.urdf, mass: 1.0}")),
    Case("a URDF file given as a mesh is", spec(scene="world: bullet, object: {urdf: {file: part.urdf}}")),
)
WORLDS = (
    _floating("load cells in the floating world", scene="object: ball, sensing: load-cell"),
    _floating("a skin with parameters in the floating world", scene="object: ball, sensing: {skin: {pitch: 0.001}}"),
    _floating("a box in the floating world", scene="object: {box: {size: [0.1, 0.1, 0.1]}}"),
    _floating("a bottle of several parts in the floating world", scene="object: {like: squirt-bottle, fixed: true}"),
    Case(
        "a bottle in bullet with a neck wider than its body",
        spec(
            scene="world: bullet, object: {bottle: {diameter: 0.08, height: 0.22, neck_diameter: 0.09, "
            "body_height: 0.13, neck_height: 0.04, shoulder: 0.015, edge: 0.008}}"
        ),
    ),
    Case(
        "bare contacts in bullet",
        spec(
            "π_s|Γ Γ (π_gx|Γ Γ)",
            scene="world: bullet, hand: points, object: towel-roll",
            resources={"γ1": "point-1", "γ2": "point-2", "γ3": "point-3"},
        ),
    ),
    _floating("a start from the side in the floating world", start="approach: side"),
    Case("a start over the surface in bullet", spec(start="approach: surface")),
    _floating("a held object in the floating world", scene="object: {like: ball, held: true}"),
    _floating("forces in the floating world", "π_close|Γ Γ"),
    _floating("forces after a grasp in the floating world", "π_gx|Γ Γ then π_s|Γ Γ (π_gx|Γ Γ)"),
    _floating("joints in the floating world", "φ_k|τ_k(wrist) σ_k(wrist)"),
    _floating("rotations in the floating world", "π_gθ|Γ {γ1, γ_g}"),
    _formula("surface coordinates in bullet, sliding", "π_g|Γ Γ"),
    _formula("rotations in bullet, without a held object", "π_gθ|Γ Γ"),
    Case("moments about an object that is not held", spec(control="origin: object")),
    _floating(
        "a cylinder with edges larger than itself",
        scene="object: {cylinder: {diameter: 0.1, height: 0.2, edge: 0.4}}",
    ),
    _floating("a lift and a shake in the floating world", evaluate="force-closure, lift, shake"),
    Case(
        "a held object to be shaken",
        spec(scene="world: bullet, object: {like: towel-roll, held: true}", evaluate="force-closure, shake"),
    ),
    _floating("friction in the floating world", scene="object: ball, friction: 0.5"),
    _floating("a start of a hand in the floating world", start="roll: 0.3"),
    _floating(
        "monitors in the floating world", monitors="palm: stop, lost: on, lean: off, dragged: 0.01, progress: off"
    ),
    Case(
        "monitors of a fixed object",
        spec(scene="world: bullet, object: {like: ball, fixed: true}", monitors="lean: 0.2, shift: 0.05"),
    ),
    Case(
        "monitors of a held ball",
        spec(scene="world: bullet, object: {like: ball, held: true}", monitors="lean: 0.2, table: stop, palm: on"),
    ),
    Case("monitors by their outcomes", spec(monitors="palm-collision: off, joint-limit: 1, toppled: 0.2, timeout: 9")),
    Case("monitors that are not understood", spec(monitors="palm: never, lean: stop, lots: 1, progress: {window: 0}")),
    Case("load cells on the command line", floating(), ("scene.sensing=load-cell",)),
    _floating("conventions that no grade judges by", grading="torque_scale: 0.04"),
    _floating("a scale of moments below all that is held", evaluate="force-closure", grading="torque_scale: 1e-12"),
    _floating("edges of no cone", evaluate="grasp-matrix", grading="edges: 8"),
    Case("conventions for a lift", spec(evaluate="lift", grading="edges: 8")),
    _floating(
        "conventions that frictionless contacts have no use for",
        evaluate="ferrari-canny",
        grading="contact: frictionless, torsion: 0.001, edges: 8",
    ),
    _floating(
        "friction that frictionless contacts are not judged by",
        scene="object: ball, friction: 0.5",
        evaluate="force-closure",
        grading="contact: frictionless",
    ),
    _floating("a torsion of hard contacts", evaluate="force-closure", grading="contact: hard, torsion: 0.001"),
    _floating(
        "conventions that cannot be",
        evaluate="force-closure",
        grading="contact: soft, torsion: -0.1, edges: 5, torque_scale: 4 cm",
    ),
)
SENSING = (
    Case("a sensor that is not there", spec(scene=f"{TOWEL_ROLL}, sensing: lod-cell")),
    Case("a sensor with parameters that is not there", spec(scene=f"{TOWEL_ROLL}, sensing: {{skn: {{}}}}")),
    Case("two sensors", spec(scene=f"{TOWEL_ROLL}, sensing: {{load-cell: {{}}, skin: {{}}}}")),
    Case("a parameter of another sensor", spec(scene=f"{TOWEL_ROLL}, sensing: {{skin: {{force_noise: 0.1}}}}")),
    Case("noise below zero", spec(scene=f"{TOWEL_ROLL}, sensing: {{load-cell: {{force_noise: -0.02}}}}")),
    Case(
        "a touch that ends above where it begins",
        spec(scene=f"{TOWEL_ROLL}, sensing: {{exact: {{touch: {{begins: 0.03, ends: 0.06}}}}}}"),
    ),
    Case("a touch within the noise", spec(scene=f"{TOWEL_ROLL}, sensing: {{load-cell: {{force_noise: 0.8}}}}")),
)
NAMES = (
    _formula("one controller after another, by a semicolon", "π_close|Γ Γ; π_s|Γ Γ (π_gx|Γ Γ)"),
    _formula("priority the wrong way round", "π_close|Γ Γ ⊳ π_close|Γ Γ"),
    Case("gravity by a bare letter", spec("π_rgθ|γ1 {γ1, g}")),
    Case("gravity by its name", spec("π_rgθ|γ1 {γ1, gravity}")),
    _formula("two contacts by one name", "π_close|{γ1, γ23} Γ"),
    _formula("two contacts by one subscript", "π_close|{γ1, γ_{23}} Γ"),
    _formula("a virtual contact of one name", "π_close|{γ1, <γ23>} Γ"),
    _formula("a length with its unit", "φ_p|τ_p(γ1) σ_p(γ1) (5 mm, 0, 0)"),
    _formula("a potential that is not there", "φ_frr|τ_frx(Γ) σ_fr(Γ)"),
    _formula("an effector transform that is not there", "φ_fr|τ_frxx(Γ) σ_fr(Γ)"),
    _formula("a sensor transform that is not there", "φ_fr|τ_frx(Γ) σ_frr(Γ)"),
    _formula("a controller that is not there", "π_clos|Γ Γ"),
    _formula("a resource that is not there", "π_close|γ4 γ4"),
    _formula("a parameter that is not there", "π_s|Γ Γ (κ_x)"),
    Case("a force that pulls", spec("π_close|Γ Γ", "π_s|Γ Γ (π_gx|Γ Γ)", parameters="kappa_f: -5")),
    Case("a force that no hand has, on the command line", spec("π_close|Γ Γ"), ("parameters.κ_f=5000",)),
    Case("a force beyond all bounds", spec("π_close|Γ Γ", parameters="κ_f: 1e300")),
    _formula("a force in a formula that pulls", "φ_f|τ_f(Γ) σ_f(Γ) (-2 σ_n(Γ))"),
    _formula("a factor in a formula beyond all bounds", "φ_f|τ_f(Γ) σ_f(Γ) (1e300 σ_f(Γ))"),
    _formula("a vector in a formula beyond all bounds", "φ_f|τ_f(γ1) σ_f(γ1) (0, -1e300, 0)"),
    Case("a parameter, and there are none", spec("π_close|Γ Γ", parameters="")),
)
CONTROLLERS = (
    _formula("a sensor of another task space", "φ_fr|τ_frx(Γ) σ_mr(Γ)"),
    _formula("an effector of another potential", "φ_fr|τ_mrx(Γ) σ_fr(Γ)"),
    _formula("gravity cannot be moved", "φ_fr|τ_frx({γ1, <γ2, γ_g>}) σ_fr(Γ)"),
    _held("gravity in a virtual contact cannot be moved", "π_rgθ|<γ1, γ_g> {γ1, γ_g}"),
    Case("gravity by another name cannot be moved", floating("π_gx|Γ_m Γ_m", resources={"Γ_m": '"{γ1, γ_g}"'})),
    _held("turning contacts without gravity", "π_rgθ|Γ Γ"),
    _formula("◁ between two spaces", "π_gx|Γ Γ ◁ π_close|Γ Γ"),
    _formula("a gradient that the world cannot carry out", "π_gx|Γ Γ"),
    _formula("'then' inside ◁", "(π_fr|Γ Γ then π_mr|Γ Γ) ◁ π_g|Γ Γ"),
    _floating("'then' inside ◁ by an abbreviation", "π_cstar|Γ Γ ◁ π_fr|Γ Γ"),
    _formula("'then' inside a reference", "π_s|Γ Γ (π_gx|Γ Γ then π_gx|γ1 Γ)"),
    _formula("different resources in one servo", "φ_p|τ_p(Γ) σ_p({γ1, γ2}) (σ_p({γ1, γ2}))"),
    _formula("different resources where 4.24 needs the same", "π_s|Γ {γ1, γ2} (π_gx|Γ Γ)"),
    _formula("too many arguments", "π_s|(Γ, Γ) Γ (π_gx|Γ Γ)"),
    _formula("an abbreviation without its reference", "π_s|Γ Γ"),
    _formula("an abbreviation with a reference too many", "π_close|Γ Γ (κ_f)"),
)
REFERENCES = (
    _formula("a reference of what strives for zero", "π_s|Γ Γ (φ_fr|τ_frx(Γ) σ_fr(Γ) (0, 0, 0))"),
    _formula("no reference", "φ_p|τ_p(Γ) σ_p(Γ)"),
    _formula("a vector of the wrong size", "π_s|Γ Γ (0.1, 0, 0.3)"),
    _formula("a vector of the wrong size for one resource", "π_s|γ1 γ1 (0.1)"),
    Case("a list where one number is needed", spec("π_close|Γ Γ", parameters="κ_f: [0.5, 1]")),
    _formula("a posture of the wrong size", "φ_k|τ_k(all) σ_k(flexion) (1, 2)"),
    Case(
        "a posture of the wrong size for one joint",
        spec("φ_k|τ_k(all) σ_k(Γ_k) (1, 2)", resources={"Γ_k": "wrist-x"}),
    ),
    _formula("a posture of other joints", "φ_k|τ_k(all) σ_k(flexion) (σ_k(fingers))"),
    _held("an orientation of gravity alone", "φ_r|τ_r(γ1) σ_r(γ_g) (σ_r(γ1))"),
    _held("orientations of too few contacts", "φ_r|τ_r({γ1, γ2}) σ_r({γ1, γ2}) (σ_r({γ1, γ_g}))"),
    _formula("orientations of contacts that nothing makes turn alike", "φ_r|τ_r(γ1) σ_r(γ2) (σ_r(γ2))"),
    _formula("a sensor of another space", "φ_f|τ_f(Γ) σ_f(Γ) (κ_f σ_p(Γ))"),
    _formula("a sensor over other resources", "φ_f|τ_f(Γ) σ_f(Γ) (κ_f σ_n({γ1, γ2}))"),
    _formula("a gradient over the surface where one in x is needed", "π_s|Γ Γ (π_g|Γ Γ)"),
    _formula("a gradient for forces", "φ_f|τ_f(Γ) σ_f(Γ) (π_gx|Γ Γ)"),
    _formula("faults inside a reference", "π_s|Γ Γ (φ_mr|τ_mrx(γ9) σ_mr(Γ) ◁ π_gy|Γ Γ)"),
)
RESOURCES = (
    _formula("a set of nothing", "π_close|{} {}"),
    _formula("a virtual contact of nothing", "π_close|{γ1, <>} Γ"),
    _formula("a virtual contact of one", "π_close|{γ1, <γ2>} Γ"),
    _formula("a contact twice in a set", "π_close|{γ1, γ2, γ1} Γ"),
    _formula("a contact twice in a nested virtual contact", "π_close|{<γ1, <γ2, γ1>>} Γ"),
    _formula("the same virtual contact twice", "π_close|{<γ2, γ3>, <γ3, γ2>} Γ"),
    _formula("a set in a set", "π_close|{γ1, Γ} Γ"),
    _formula("joints where contacts are needed", "φ_p|τ_p(flexion) σ_p(flexion) (0, 0, 0)"),
    _formula("joints among contacts", "π_close|{γ1, flexion} {γ1, flexion}"),
    _formula("contacts where joints are needed", "φ_k|τ_k(Γ) σ_k(γ1)"),
    _formula("joint sets in a set", "φ_k|τ_k(all) σ_k({flexion, wrist})"),
    _formula("joints for one parameter, contacts for the other", "π_s|Γ flexion (π_gx|Γ Γ)"),
    _formula("gravity where it is not sensed", "π_s|Γ Γ (φ_fr|τ_frx(Γ) σ_fr({γ1, γ_g}))"),
    _resource("a contact that the hand has not", "γ3", "finger-4"),
    Case(
        "contacts that float, and no hand",
        spec("π_gx|Γ Γ", scene="world: floating, object: ball", resources={"γ1": "contact-1"}),
    ),
    _resource("a contact in two members of a set", "γ2", "finger-3"),
    _formula("a contact beside a virtual contact of it", "π_close|{γ1, <γ1, γ2>} {γ1, <γ1, γ2>}"),
    _resource("a set without its quotes", "Γ", "{γ1, <γ2, γ3>}"),
    _resource("a resource that is no text", "γ2", "2"),
    _resource("gravity declared", "γ_g", "finger-1"),
    _resource("a name in two spellings", "gamma_2", "finger-2"),
    _resource("a text that cannot be read", "Γ", '"{γ1, <γ2, γ3}"'),
    _resource("a declaration by an unknown name", "Γ_m", '"{γ1, γ7}"'),
    Case(
        "declarations in a circle",
        spec("π_close|Γ_a Γ_a", resources={"Γ_a": "Γ_b", "Γ_b": '"{γ1, γ_c}"', "γ_c": '"<γ2, Γ_a>"'}),
    ),
    Case("a circle through an alias", spec(resources={"γ4": "γ5", "γ5": "γ4"})),
    Case("an alias of a set inside a set", spec("π_close|{γ1, Γ_m} Γ", resources={"Γ_m": "Γ"})),
)
SECTIONS = (
    Case("resources under another name", spec().replace("resources:", "resource:")),
    Case("resources under a name that is none", spec().replace("resources:", "contacts:")),
    Case("parameters under another name", spec("π_close|Γ Γ").replace("parameters:", "params:")),
    Case("resources that are a list", spec(), ("resources=[finger-1]",)),
    Case("a file in place of parameters", spec("π_close|Γ Γ"), ("parameters=/x/p.yaml",)),
)
DEFINITIONS = (
    _controller("a name of the prelude", "π_close|Γ Γ", {"π_gx|Γ Γ": "π_close|Γ Γ"}),
    _controller("a name twice", "π_a|Γ Γ", {"π_a|Γ Γ": "π_close|Γ Γ", "pi_a|G G": "π_close|Γ Γ"}),
    _controller("a head that cannot be read", "π_close|Γ Γ", {"φ_a|Γ Γ": "π_close|Γ Γ"}),
    _controller("a body that cannot be read", "π_a|Γ Γ", {"π_a|Γ Γ": "φ_f|τ_f(Γ σ_f(Γ)"}),
    _controller("a fault in a body", "π_a|Γ Γ", {"π_a|Γ Γ": "π_s|Γ Γ (φ_fr|τ_frx(Γ) σ_mr(Γ))"}),
    _controller("a definition by itself", "π_a|Γ Γ", {"π_a|Γ Γ": "π_close|Γ Γ ◁ π_a|Γ Γ"}),
    _controller("definitions in a circle", "π_a|Γ Γ", {"π_a|Γ Γ": "π_b|Γ Γ", "π_b|Γ Γ": "π_a|Γ Γ"}),
    _controller("sequences in a circle", "π_a", {"π_a": "π_close|Γ Γ then π_b", "π_b": "π_a then π_close|Γ Γ"}),
    _controller("different resources for one parameter", "π_a|Γ γ1", {"π_a|Γ Γ": "π_close|Γ Γ"}),
    _controller(
        "a reference that scales a sensor and is no number",
        "π_a|Γ Γ (1, 2)",
        {"π_a|Γ Γ (f)": "φ_f|τ_f(Γ) σ_f(Γ) (f σ_n(Γ))"},
    ),
    _controller("definitions that double forty times", "π_a40|Γ Γ", _chain("π_close|Γ Γ", "π_a|Γ Γ ◁ π_a|Γ Γ")),
    _controller("sets that double forty times", "π_a40|Γ Γ", _chain("π_close|Γ Γ", "π_a|{Γ, Γ} {Γ, Γ}")),
)
PROGRAM = (
    Case("a residual that nothing lowers", spec("π_close|Γ Γ", until="force_residual: 0.1, moment_residual: 0.01")),
    Case("parameters in two spellings", spec(parameters="κ_f: 0.5, kappa_f: 1")),
    Case("a parameter that is no number", spec("π_close|Γ Γ", parameters="κ_f: much")),
    _formula("a formula that cannot be read", "π_close|Γ"),
)
SENSED = spec(scene=f"{TOWEL_ROLL}, sensing: load-cell")
GRID = "count: 3, grid: [{parameter: roll, low: -1.0, high: 1.0, cells: 4}]"
MONITORS = "palm: 30, lost: 100, dragged: 0.2, progress: {window: 16}"
REVERSED = "φ_f|τ_f(Γ) σ_f(Γ) (κ_f σ_n(Γ)) ◁ φ_p|τ_p(Γ) σ_p(Γ) (π_gx|Γ Γ)"
WEIGHTLESS = "world: bullet, object: towel-roll, gravity: 0"
WEIGHTLESS_HELD = "world: bullet, object: {like: towel-roll, held: true}, gravity: 0"
EFFECTS = (
    Case("a net force that is always low enough", spec(until="force_residual: 3.0")),
    _floating("a net force that is never low enough", "π_gx|γ1 γ1", until="force_residual: 0.1"),
    Case("a moment that is always low enough", spec(until="moment_residual: 0.4")),
    Case("a force that is always near enough", spec("π_close|Γ Γ", until="force_error: 0.6")),
    Case("a force that probing does not control", spec(control="displacement: probing", until="force_error: 0.1")),
    Case("conditions that must hold longer than the phase lasts", spec(until="contact: all, hold: 31")),
    _floating("conditions of two stages that must hold", "π_cstar|Γ Γ", until="force_residual: 0.1, hold: 16"),
    Case("a limit of less than a tick", spec().replace("    until", "    limit: 0.01\n    until")),
    Case("hysteresis of one stage", spec().replace("    until", "    hysteresis: 2\n    until")),
    Case("position before the force that presses", spec(REVERSED)),
    Case("position before the force, in the null space of its task", spec(REVERSED, control="nullspace: task")),
    Case("posture before the force that presses", spec("π_close|Γ Γ ◁ φ_k|τ_k(all) σ_k(flexion)")),
    Case("a controller before itself", spec("π_close|Γ Γ ◁ π_close|Γ Γ")),
    Case(
        "a posture of all joints before a part of it",
        spec("φ_k|τ_k(all) σ_k(flexion) ◁ φ_k|τ_k(all) σ_k(all)", control="nullspace: task"),
    ),
    Case("a force beyond what the joints can press", spec("π_close|Γ Γ", parameters="κ_f: 50")),
    Case("such a force in a formula", spec("φ_f|τ_f(γ1) σ_f(γ1) (0, 0, 30)")),
    Case("a force under which a touch ends", spec("π_close|Γ Γ", parameters="κ_f: 0.02")),
    Case("damping beyond what it damps", spec(control="damping: 5")),
    Case("settings that no controller uses", spec("π_close|Γ Γ", control="damping: 1, moment_gain: 2, origin: world")),
    Case("a damping that transposes have not", spec(control="inverse: transpose, damping: 0.1")),
    Case("gains of zero", spec(control="moment_gain: 0, admittance: 0")),
    _floating("probing of what floats", control="displacement: probing"),
    _floating("a mount and a mass of what floats", scene="mount: wam, object: {like: ball, mass: 2}"),
    Case("a mass of what stays", spec(scene="world: bullet, object: {like: ball, fixed: true, mass: 2}")),
    Case(
        "an edge where nothing floats",
        spec(scene="world: bullet, object: {cylinder: {diameter: 0.1, height: 0.2, edge: 0.01}}"),
    ),
    Case("monitors that no trial is long enough for", spec(until="force_residual: 0.1", monitors=MONITORS)),
    Case("progress that nothing waits for", spec(monitors="progress: {window: 3}")),
    Case("weight of nothing", spec(scene=WEIGHTLESS, monitors="lean: 0.2, table: 1", evaluate="lift, shake")),
    Case("gravity of nothing", spec("π_rgθ|γ1 {γ1, γ_g}", scene=WEIGHTLESS_HELD)),
    _floating("gravity of what floats on its contacts", scene="object: ball, gravity: 1.62"),
    _floating("physics of what floats on its contacts", scene="object: ball, physics: {time_step: 0.001}"),
    Case("steps of physics that are no part of a tick", spec(scene=f"{TOWEL_ROLL}, physics: {{time_step: 0.003}}")),
    Case(
        "physics that is out of range",
        spec(scene=f"{TOWEL_ROLL}, physics: {{time_step: 2, solver_iterations: 0.5, substeps: 3}}"),
    ),
    Case("forces that no virtual contact shares", spec("π_close|γ1 γ1", control="virtual_forces: shared")),
    Case(
        "a share under which a touch ends",
        spec("π_close|Γ Γ", parameters="κ_f: 0.05", control="virtual_forces: shared"),
    ),
    Case("a number that looks octal", spec().replace("program:", "trials: {count: 1, seed: 010}\nprogram:")),
    Case("a number that looks octal on the command line", spec(), ("trials.seed=0017",)),
    Case("cells that no trial begins in", spec().replace("program:", f"trials: {{{GRID}}}\nprogram:")),
)
OVERRIDES = (
    Case("a formula on the command line", spec(), ("program.0.run=π_close|Γ γ9",)),
    Case("a resource on the command line", spec(), ('resources.Γ="{γ1, <γ2, γ9>}"',)),
    Case("a controller on the command line", spec("π_a|Γ Γ"), ("controllers.π_a|Γ Γ=π_close|Γ γ1 then",)),
    Case("a parameter on the command line", spec("π_close|Γ Γ"), ("parameters.kappa_f=1",)),
    Case("a hand on the command line", spec(), ("scene.hand=baret",)),
    Case("a mesh by its name alone on the command line", spec(), ("scene.object=/x/m.stl",)),
    Case("a mesh of an unknown kind", spec(), ("scene.object=/x/m.step",)),
    Case("a mesh by its name alone as a mesh", spec(), ("scene.object={mesh: /x/m.stl}",)),
    Case("a mesh inside a name", spec(), ("scene.object.mesh.file=/x/m.stl",)),
    Case("a mass inside a name", spec(), ("scene.object.mass=1",)),
    Case("a parameter of another sensor than the file's on the command line", SENSED, ("scene.sensing.skin.pitch=1",)),
    Case("a parameter of the file's sensor on the command line", SENSED, ("scene.sensing.load-cell.latency=1",)),
    Case("a condition on the command line", spec("π_close|Γ Γ"), ("program.0.until.force_residual=0.1",)),
)
SEVERAL = (
    Case(
        "faults of every kind at once",
        spec(
            "π_close|γ4 Γ",
            "π_s|Γ Γ (π_g|Γ Γ)",
            "π_a|Γ Γ ◁ ◁ π_b",
            scene="world: bullet, hand: barrett, object: towl, friction: -1",
            resources={"γ2": "finger-9", "Γ_m": "'{γ1, <γ3>}'"},
            controllers={"π_a|Γ Γ": "φ_zz|τ_p(Γ) σ_p(Γ) (0)", "π_b": "φ_f(Γ)"},
            control="stepp: 1",
        ).replace("name: test\n", "name: test\nname: again\n"),
        ("program.1.run=π_s|Γ Γ (π_g|γ1 Γ)", "trials.count=none"),
    ),
)
CASES = (
    *SCENE,
    *WORLDS,
    *SENSING,
    *NAMES,
    *CONTROLLERS,
    *REFERENCES,
    *RESOURCES,
    *SECTIONS,
    *DEFINITIONS,
    *PROGRAM,
    *EFFECTS,
    *OVERRIDES,
    *SEVERAL,
)


def report() -> Iterator[str]:
    """What is said of every case."""
    return (str(case) for case in CASES)


if __name__ == "__main__":
    print("\n\n".join(report()))
