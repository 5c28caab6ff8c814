"""Bad models and bad hand files: one complaint for each, at its place, from validate and from run."""

from __future__ import annotations

import json
import math
import re
import time
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner

from graspdsl.cli.app import app
from graspdsl.compiler.program import examine
from graspdsl.diagnostics import DiagnosticError, Severity, has_errors
from graspdsl.hands.description_files import DescriptionFileError
from graspdsl.hands.descriptions import Hand
from graspdsl.hands.hand_check import faults
from graspdsl.hands.hand_files import hand_in
from graspdsl.models.kinematic_tree import MOST_LINKS
from graspdsl.models.urdf_text import urdf_text
from graspdsl.places.document import parse_document
from graspdsl.places.files import SpecFolder
from graspdsl.places.validation import validate_document
from graspdsl.places.xml_files import LARGEST

from .models import HAND, SPEC, URDF, changed, model_of, with_links, write


@dataclass(frozen=True, slots=True)
class Case:
    """A change to the small hand's model, the code of the complaint, and words of it."""

    name: str
    change: tuple[str, str]
    code: str
    said: str


FINGER_MASS = '<mass value="0.1"/>\n'
FINGER_INERTIA = '\n      <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/>'
AXIS = '<axis xyz="0 1 0"/>'
LIMIT = '<axis xyz="0 1 0"/><limit lower="-0.5" upper="1" effort="1" velocity="2"/>'
THUMB = '<joint name="thumb-bend" type="revolute"><parent link="palm"/><child link="thumb"/>'
BOX = '<box size="0.01 0.01 0.04"/>'
BALL = '<sphere radius="0.01"/>'
TIP = '<sphere radius="0.01"/>'
FIXED = '<joint name="c" type="fixed"><parent link="palm"/><child link="{}"/></joint>'
MOUNTING = FIXED.replace('"c"', '"mounting"')
XACRO = 'xmlns:x="{}"'
MACROS = ("not-a-urdf", "a xacro file")
PLACE = '<origin xyz="0.03 0 0"/>'


def _limit(old: str, new: str) -> tuple[str, str]:
    return LIMIT, LIMIT.replace(old, new)


def _finger_mass(value: str) -> tuple[str, str]:
    return FINGER_MASS, f'<mass value="{value}"/>\n'


def _inertia(**moments: str) -> tuple[str, str]:
    whole = {"ixx": "1e-4", "iyy": "1e-4", "izz": "1e-4", "ixy": "0", "ixz": "0", "iyz": "0", **moments}
    return FINGER_INERTIA, f"<inertia {' '.join(f'{key}={json.dumps(value)}' for key, value in whole.items())}/>"


def _tip_inertia(ixx: str) -> tuple[str, str]:
    whole = '<inertia ixx="1e-6" iyy="1e-6"'
    return whole, whole.replace('ixx="1e-6"', f'ixx="{ixx}"')


MODELS = (
    Case("joint twice", ('name="thumb-bend"', 'name="bend"'), "declared-twice", "there are two joints 'bend'"),
    Case("link twice", ('<link name="thumb">', '<link name="tip">'), "declared-twice", "there are two links 'tip'"),
    Case("no name", ('<link name="thumb">', "<link>"), "bad-name", "for a <link>, found none"),
    Case("long name", ('joint name="cell"', f'joint name="{"c" * 101}"'), "bad-name", "up to 100 characters"),
    Case("steering name", ('joint name="cell"', 'joint name="c&#x202e;l"'), "bad-name", r"found 'c\u202el'"),
    Case("negative mass", _finger_mass("-0.1"), "out-of-range", "the value of <mass> is negative: -0.1"),
    Case("no mass", _finger_mass("nan"), "not-a-number", "found 'nan'"),
    Case("infinite mass", _finger_mass("inf"), "not-a-number", "found 'inf'"),
    Case("overflowing mass", _finger_mass("1e999"), "not-a-number", "found '1e999'"),
    Case("great mass", _finger_mass("1e9"), "out-of-range", "the mass of finger is 1e+09 kg"),
    Case("mass of another tongue", _finger_mass("0,1"), "not-a-number", "found '0,1'"),
    Case("mass in other digits", _finger_mass("١"), "not-a-number", "found '١'"),
    Case("infinite inertia", _inertia(izz="1e999"), "not-a-number", "as the izz of <inertia>, found '1e999'"),
    Case("inertia left out", (FINGER_INERTIA, ""), "missing-element", "<inertial> has no <inertia>"),
    Case("axis of nothing", (AXIS, '<axis xyz="0 0 0"/>'), "zero-axis", "the joint bend: its axis is zero"),
    Case("axis nan", (AXIS, '<axis xyz="0 nan 0"/>'), "not-a-number", "found '0 nan 0'"),
    Case("axis too short", (AXIS, '<axis xyz="0 1"/>'), "not-a-number", "expected three numbers"),
    Case("axis in words", (AXIS, '<axis xyz="up"/>'), "not-a-number", "found 'up'"),
    Case("axis twice", (AXIS, AXIS + AXIS), "declared-twice", "expected one <axis> in <joint>, found 2"),
    Case("origin nan", (PLACE, '<origin xyz="nan 0 0"/>'), "not-a-number", "as the xyz of <origin>, found 'nan 0 0'"),
    Case("origin far", (PLACE, '<origin xyz="30 0 0"/>'), "out-of-range", "lengths are in metres"),
    Case("origin in degrees", (PLACE, '<origin rpy="0 90 0"/>'), "out-of-range", "angles are in radians"),
    Case("limits nan", _limit("-0.5", "nan"), "not-a-number", "as the lower of <limit>, found 'nan'"),
    Case("limits infinite", _limit('upper="1"', 'upper="inf"'), "not-a-number", "as the upper of <limit>, found 'inf'"),
    Case("limits turned", _limit("-0.5", "2"), "out-of-range", "its limits leave no room: 2 to 1"),
    Case("limits equal", _limit("-0.5", "1"), "joint-not-movable", "its limits are both 1, and"),
    Case("no limits", (LIMIT, AXIS), "joint-without-limits", "the joint bend has no limits"),
    Case(
        "negative effort", _limit('effort="1"', 'effort="-1"'), "out-of-range", "the effort of <limit> is negative: -1"
    ),
    Case(
        "negative velocity",
        _limit('velocity="2"', 'velocity="-2"'),
        "out-of-range",
        "the velocity of <limit> is negative: -2",
    ),
    Case("two roots", ("</robot>", '<link name="stray"/></robot>'), "no-root", "2 links have no parent"),
    Case("two parents", ("</robot>", f"{FIXED.format('tip')}</robot>"), "two-parents", "by the joints cell and c"),
    Case("cycle", (THUMB, THUMB.replace("palm", "thumb")), "joint-cycle", "the joints form a cycle: thumb"),
    Case("unknown parent", (THUMB, THUMB.replace("palm", "plam")), "unknown-link", "is 'plam', which is no link"),
    Case("no parent", (THUMB, THUMB.replace('<parent link="palm"/>', "")), "wrong-joint", "has 0 <parent>"),
    Case("unknown type", (THUMB, THUMB.replace("revolute", "screw")), "unknown-joint-type", "'screw'"),
    Case("floating", (THUMB, THUMB.replace("revolute", "floating")), "unknown-joint-type", "'floating'"),
    Case("no type", (THUMB, THUMB.replace('type="revolute"', "")), "unknown-joint-type", "has no type"),
    Case("negative box", (BOX, '<box size="0.01 -0.01 0.04"/>'), "out-of-range", "the size of <box> is negative"),
    Case("flat box", (BOX, '<box size="0.01 0 0.04"/>'), "out-of-range", "the size of <box> is zero"),
    Case("no box", (BOX, "<box/>"), "missing-key", "its <box> has no size"),
    Case("ball nan", (TIP, '<sphere radius="nan"/>'), "not-a-number", "as the radius of <sphere>, found 'nan'"),
    Case("ball of nothing", (TIP, '<sphere radius="0"/>'), "out-of-range", "the radius of <sphere> is zero"),
    Case("endless tube", (TIP, '<cylinder radius="0.01" length="1e999"/>'), "not-a-number", "the length of <cylinder>"),
    Case("cone", (TIP, '<cone radius="0.01"/>'), "wrong-shape", "of a <collision>, found <cone>"),
    Case("two shapes", (TIP, BALL + BALL), "wrong-shape", "found <sphere> and <sphere>"),
    Case("no shape", (TIP, ""), "wrong-shape", "found none"),
    Case("mesh of nothing", (TIP, "<mesh/>"), "missing-key", "its <mesh> has no filename"),
    Case(
        "mesh of another kind",
        (TIP, '<mesh filename="a.step"/>'),
        "unknown-mesh-format",
        "a.step is no file of triangles",
    ),
    Case("mesh elsewhere", (TIP, '<mesh filename="../a.stl"/>'), "outside-of-folder", "leads out of the folder"),
    Case(
        "mesh scale",
        (TIP, '<mesh filename="a.stl" scale="1 0 1"/>'),
        "out-of-range",
        "the scale of <mesh> is zero: 1 0 1",
    ),
    Case(
        "taken name",
        ("</robot>", f'<link name="a"/>{MOUNTING.format("a")}</robot>'),
        "name-taken",
        "the joint mounting of the model has the name of the joint between mount and hand",
    ),
    Case("macros", ("</robot>", f"<x:m {XACRO.format('http://www.ros.org/wiki/xacro')}/></robot>"), *MACROS),
    Case("inner macros", (PLACE, f"<x:m {XACRO.format('https://wiki.ros.org/xacro')}>{PLACE}</x:m>"), *MACROS),
    Case("macros of old", (PLACE, f"<x:m {XACRO.format('xacro')}/>{PLACE}"), *MACROS),
    Case("encoding", ('<robot name="two">', "<?xml version='1.0' encoding='wide'?><robot>"), "bad-xml", "'wide'"),
    Case("document type", ('<robot name="two">', "<!DOCTYPE robot><robot>"), "bad-xml", "declares a document type"),
    Case("no XML", ("</robot>", ""), "bad-xml", "no element found"),
    Case("large", ("</robot>", " " * LARGEST + "</robot>"), "file-too-large", "where an XML file may have"),
    Case("no links", (URDF, "<robot/>"), "no-root", "two.urdf has no links"),
)
FILES = (
    Case("unknown root", ("root: palm", "root: plam"), "unknown-root", "there is no link 'plam'"),
    Case("surface", ("palm_surface: 0.05", "palm_surface: .inf"), "not-finite", "expected a finite number (m)"),
    Case("surface in mm", ("palm_surface: 0.05", "palm_surface: 50"), "out-of-range", "of at most 1 (m), found 50"),
    Case("weight", ("  bend: {weight: 10.0", "  bend: {weight: .nan"), "not-finite", "found .nan"),
    Case("great weight", ("  bend: {weight: 10.0", "  bend: {weight: 1.0e+9"), "out-of-range", "at most 1000"),
    Case("no weight", ("  bend: {weight: 10.0", "  bend: {weight: 0"), "out-of-range", "above 0"),
    Case("weight in words", ("  bend: {weight: 10.0", "  bend: {weight: '1'"), "wrong-type", "expected a number"),
    Case("way", ("  bend: {weight: 10.0, closes: 1", "  bend: {weight: 10.0, closes: 2"), "out-of-range", "at most 1"),
    Case("radius", ("sphere: {radius: 0.01}", "sphere: {radius: 1.0e+9}"), "out-of-range", "at most 1 (m)"),
    Case("centre", ("sphere: {", "sphere: {centre: [0, .nan, 0], "), "not-finite", "(m), found .nan"),
    Case("half a centre", ("sphere: {", "sphere: {centre: [0, 0], "), "wrong-length", "a place (m), found 2 values"),
    Case("capsule", ("axis: [0.0, 0.0, 1.0]", "axis: [0, 0, 0]"), "zero-axis", "a direction is needed"),
    Case("posture", ("open: {bend: 0.1}", "open: {bend: .inf}"), "not-finite", "found .inf"),
    Case("no finger", ("finger: [bend]", "finger: []"), "wrong-length", "at least 1 item, found 0"),
    Case("no joints", ("both: [bend, thumb-bend]", "both: []"), "wrong-length", "at least 1 item, found 0"),
    Case("joint twice", ("both: [bend, thumb-bend]", "both: [bend, bend]"), "declared-twice", "bend stands twice"),
    Case("other finger", ("finger: [bend]", "finger: [thumb-bend]"), "wrong-finger", "thumb-bend does not move tip"),
    Case("name of a path", ("hand: two", "hand: ../two"), "bad-name", "found the text '../two'"),
    Case("steering name", ("hand: two", r'hand: "two\e[2J"'), "bad-character", "escape"),
    Case("markup", ("  both:", "  <b>both</b>:"), "bad-name", "<b>both</b>"),
    Case("contact of a path", ("  pad:", "  ../pad:"), "bad-name", "found the text '../pad'"),
    Case("posture of a path", ("open:", "a/b:"), "bad-name", "found the text 'a/b'"),
    Case("set of all", ("  both:", "  all:"), "name-taken", "the joint set all"),
    Case("set like a joint", ("  both:", "  bend:"), "name-taken", "the joint set bend has the name of a joint"),
    Case("many signs", ("urdf: two.urdf", f"urdf: {'a' * 1001}"), "wrong-length", "at most 1000 characters"),
)


def _model(case: Case) -> tuple[str, str]:
    return changed(URDF, case.change), HAND


def _file(case: Case) -> tuple[str, str]:
    return URDF, changed(HAND, case.change)


CASES = [pytest.param(_model, case, id=f"model: {case.name}") for case in MODELS] + [
    pytest.param(_file, case, id=f"file: {case.name}") for case in FILES
]


def test_the_hand_that_is_changed_is_sound(tmp_path: Path) -> None:
    found = examine(SPEC, "spec.yaml", (), write(tmp_path).parent)
    assert found.diagnostics == ()
    assert found.program is not None


@pytest.mark.parametrize(("make", "case"), CASES)
def test_each_fault_is_one_complaint_of_validate_and_of_run(
    make: Callable[[Case], tuple[str, str]], case: Case, tmp_path: Path
) -> None:
    urdf, hand = make(case)
    spec = write(tmp_path, urdf, hand)
    began = time.perf_counter()
    told = CliRunner().invoke(app, ["validate", str(spec), "--json"])
    (fault,) = json.loads(told.stdout)["files"][0]["diagnostics"]
    assert (told.exit_code, fault["code"], fault["severity"]) == (1, case.code, "error")
    assert case.said in f"{fault['message']} {fault['hint']}"
    assert re.match(r"hand\.yaml:\d+:\d+: ", fault["message"])
    assert (fault["line"], fault["column"]) == (3, 30)  # where the spec names the hand
    ran = CliRunner().invoke(app, ["run", str(spec), "--out", str(tmp_path / "out")])
    assert (ran.exit_code, ran.stdout) == (1, "")
    assert f"[{case.code}]" in ran.stderr
    assert not (tmp_path / "out").exists()
    assert time.perf_counter() - began < 3.0


def test_many_complaints_of_long_names_stay_short(tmp_path: Path) -> None:
    link = '<link name="{}"/><joint name="{}" type="fixed"><parent link="palm"/><child link="none"/></joint>'
    write(tmp_path, f"<robot>{''.join(link.format(f'{i:x>90}', i) for i in range(2000))}</robot>")
    found = examine(SPEC, "spec.yaml", (), tmp_path).diagnostics
    assert 1 < len(found) <= 20
    assert max(len(f"{fault.message}{fault.hint}") for fault in found) < 5000


def test_all_faults_of_elements_are_told_at_once(tmp_path: Path) -> None:
    urdf = URDF
    for change in ((AXIS, '<axis xyz="0 0 0"/>'), ('value="0.5"', 'value="-1"'), (BOX, "<cone/>"), _inertia(ixx="x")):
        urdf = changed(urdf, change)
    write(tmp_path, urdf)
    found = examine(SPEC, "spec.yaml", (), tmp_path).diagnostics
    codes = sorted(fault.code for fault in found)
    assert codes == ["not-a-number", "out-of-range", "wrong-shape", "zero-axis"]


def test_a_complaint_about_a_model_has_its_line_and_column(tmp_path: Path) -> None:
    write(tmp_path, changed(URDF, (TIP, '<sphere radius="-1"/>')))
    with pytest.raises(DescriptionFileError) as caught:
        hand_in(SpecFolder(tmp_path), "hand.yaml")
    (fault,) = caught.value.diagnostics
    line = next(number for number, text in enumerate(URDF.split("\n"), 1) if TIP in text)
    column = URDF.split("\n")[line - 1].index(TIP) + 1
    assert fault.message.startswith(f"two.urdf:{line}:{column}: the link tip: ")
    assert fault.span is not None
    assert (fault.span.line, fault.span.column) == (2, 7)


MENDED = {
    "negative": (_inertia(ixx="-1e-4"), "-0.0001, 0.0001, 0.0001 kg m²: it is given 1e-13, 0.0001, 0.0001"),
    "none": (_inertia(ixx="0", iyy="0", izz="0"), "finger, 0, 0, 0 kg m²: it is given 2.5e-06"),
    "indefinite": (_inertia(ixy="2e-4"), "-0.0001, 0.0001, 0.0003 kg m²"),
    "of no body": (_inertia(ixx="3e-4"), "0.0001, 0.0001, 0.0003 kg m²: it is given 0.000133, 0.000133, 0.000267"),
    "of no body, of a tip": (_tip_inertia("3e-6"), "1e-06, 1e-06, 3e-06 kg m²"),
}


@pytest.mark.parametrize("name", MENDED)
def test_an_inertia_that_no_body_has_is_mended_with_a_warning_of_both(name: str, tmp_path: Path) -> None:
    change, said = MENDED[name]
    spec = write(tmp_path, changed(URDF, change))
    (fault,) = examine(SPEC, "spec.yaml", (), tmp_path).diagnostics
    assert (fault.code, fault.severity, said in fault.message) == ("wrong-inertia", Severity.WARNING, True)
    if name == "none":
        assert CliRunner().invoke(app, ["validate", str(spec)]).exit_code == 0
        assert CliRunner().invoke(app, ["validate", str(tmp_path / "hand.yaml")]).exit_code == 0


@pytest.mark.parametrize(
    ("links", "said"),
    [(MOST_LINKS, "where a model may have 2000"), (MOST_LINKS - 10, "where a hand may have 100"), (90, "")],
)
def test_very_many_links_are_refused_at_once(links: int, said: str, tmp_path: Path) -> None:
    write(tmp_path, with_links(links))
    began = time.perf_counter()
    found = examine(SPEC, "spec.yaml", (), tmp_path).diagnostics
    assert time.perf_counter() - began < 2.0
    assert [said in fault.message for fault in found] == ([True] if said else [])


def _mutants() -> Iterator[tuple[str, ElementTree.Element]]:
    """The model with every attribute made wrong in some ways, and every element left out, renamed and doubled."""
    whole = ElementTree.fromstring(URDF)
    for number, element in enumerate(whole.iter()):
        for key in element.attrib:
            for value in ("", "x", "nan", "1e999", "-1", "0", "1 2"):
                mutant = deepcopy(whole)
                list(mutant.iter())[number].set(key, value)
                yield f"{number} {element.tag} {key}={value}", mutant
        for parent, child in [(number, place) for place in range(len(element))]:
            for what in ("left out", "renamed", "doubled"):
                mutant = deepcopy(whole)
                above = list(mutant.iter())[parent]
                if what == "left out":
                    above.remove(above[child])
                elif what == "renamed":
                    above[child].tag = "other"
                else:
                    above.append(deepcopy(above[child]))
                yield f"{number} {element.tag}, {element[child].tag} {what}", mutant


@pytest.mark.slow
def test_no_mutant_of_a_model_gets_past_but_whole() -> None:
    """Each is refused with complaints, or accepted with only finite numbers; nothing else is ever raised."""
    document = parse_document(HAND, "hand.yaml")
    hand = validate_document(document, Hand)
    accepted, refused = 0, 0
    for name, mutant in _mutants():
        try:
            model = model_of(ElementTree.tostring(mutant, encoding="unicode"), hand.root)
        except DiagnosticError:
            refused += 1
            continue
        if has_errors(faults(hand, model, document)):
            refused += 1
            continue
        accepted += 1
        kept = [element for element in ElementTree.fromstring(urdf_text(model)).iter() if element.tag != "robot"]
        texts = [text for element in kept for key, text in element.items() if key not in ("name", "type", "link")]
        assert all(math.isfinite(float(word)) for text in texts for word in text.split()), name
    assert refused > accepted > 0
