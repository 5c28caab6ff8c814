"""What a report shows comes out as data: with every digit, with units, in every format alike."""

from __future__ import annotations

import csv
import dataclasses
import json
import math
import re
import sys
from pathlib import Path
from typing import get_args

import numpy as np
import pyarrow.parquet as pq
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from stored_runs import stored_run
from typer.testing import CliRunner

import graspdsl as g
from graspdsl.cli.app import app
from graspdsl.report.balance import Alone, Holding, Load, Spread
from graspdsl.report.data_files import as_csv, as_jsonl, format_of
from graspdsl.report.evidence import Evidence
from graspdsl.report.exports import columns_of_table, tables_of
from graspdsl.report.figure_data import Convergence, FigureData, figure_tables, figures_of
from graspdsl.report.figures import drawing_of
from graspdsl.report.page import page
from graspdsl.report.summary import summarised
from graspdsl.report.tables import COUNT, INTERVAL, MILLIMETRES, SHARE, TEXT, Table, Value, fixed
from graspdsl.report.tables import Column as Shown
from graspdsl.trials.columns import Column
from graspdsl.trials.record import RejectedStart
from report.hand_made import HandMade, evidence

SPECS = Path(__file__).parents[2] / "specs"
TRIALS = 3


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> g.Run:
    """A finished run that has most of what a report can show; not to be changed."""
    place = tmp_path_factory.mktemp("made") / "run"
    spec = SPECS / "chapter" / "4_30_grasp_cartesian.yaml"
    virtual = 'resources.Γ="{γ1, <γ2, γ3>}"'  # one direction less for what is below, so that there is one to disturb
    return g.open_run(stored_run(place, spec, f"trials.count={TRIALS}", "evaluate=[force-closure]", virtual).path)


@pytest.fixture(scope="module")
def by_hand() -> Evidence:
    """Trials of a hand on a grid that end in two modes, stopped, with a contact off and after draws that were rejected:
    what the figures show that ``run`` does not have."""
    one = [HandMade(end=0.1 + 0.01 * n, ticks=100 + n, forces=(1.0, 0.5, 0.1)) for n in range(12)]
    other = [HandMade(end=1.4 + 0.01 * n, ticks=None) for n in range(12)]
    grid = "[{parameter: roll, low: -1, high: 1, cells: 13}, {parameter: yaw, low: 0, high: 1, cells: 2}]"
    trials = [*one, *other, HandMade(stopped=True), HandMade(touching=False)]
    made = evidence(1, trials, f"trials.grid={grid}", "trials.count=26")
    rejected = RejectedStart({"roll": 0.5, "yaw": 0.2, "height": 0.1, "standoff": 0.1}, "it rains")
    begun = [
        dataclasses.replace(record, start={**rejected.drawn, "roll": 0.1 * record.number}, rejected=(rejected,))
        for record in made.records
    ]
    return dataclasses.replace(made, records=tuple(begun))


def test_a_table_is_numbers_in_the_units_of_a_page() -> None:
    columns = (
        Shown("who"),
        Shown("n", COUNT),
        Shown("far", MILLIMETRES),
        Shown("share", SHARE),
        Shown("95 %", INTERVAL),
        Shown("either", TEXT),
        Shown("mixed", COUNT),
    )
    rows = (
        ("a", 2, 0.0125, 1 / 3, (0.1, 0.6), Value(0.5, fixed(1, "rad")), 1),
        ("b", 0, math.nan, None, None, Value(None, fixed(1, "rad")), Value("stopped", Shown("").format)),
    )
    found = columns_of_table(Table("", columns, rows))
    units = {"who": "", "n": "1", "far": "mm", "share": "1", "95 %.low": "1", "95 %.high": "1", "either": "rad"}
    assert {name: column.unit for name, column in found.items()} == {**units, "mixed": ""}
    text = (
        "who,n,far,share,95 %.low,95 %.high,either,mixed\na,2,12.5,0.3333333333333333,0.1,0.6,0.5,1\nb,0,,,,,,stopped\n"
    )
    assert as_csv(found) == text


def test_numbers_come_back_as_they_were() -> None:
    values = [0.1 + 0.2, 5e-324, -0.0, math.nan, math.inf, 1e300]
    columns = {
        "x": Column(np.array(values), "m"),
        "short": Column(np.array([*values[:3], 0.1, 1 / 3, math.nan], dtype=np.float32), "m"),
        "words": Column(np.array(["a,b", 'say "γ"', "two\nlines", "", "-", "e"]), ""),
        "big": Column(np.array([2**63 - 1] * 6), "1"),
    }
    lines = list(csv.DictReader(as_csv(columns).splitlines(keepends=True)))
    for name in ("x", "short"):
        read = np.array([float(line[name] or "nan") for line in lines], dtype=columns[name].values.dtype)
        np.testing.assert_array_equal(read, columns[name].values)
    assert [line["words"] for line in lines] == columns["words"].values.tolist()
    records = [json.loads(line, parse_constant=pytest.fail) for line in as_jsonl(columns).splitlines()]
    assert [record["x"] for record in records] == [*values[:3], None, None, 1e300]
    assert {record["big"] for record in records} == {2**63 - 1}


@pytest.mark.slow
def test_every_table_has_its_export(run: g.Run) -> None:
    assert run.tables[0] == "trials"
    assert {"summary", "outcomes", "modes", "residuals", "quality-verdicts", "courses"} <= {*run.tables}
    for name in run.tables:
        table = run.table(name)
        assert len({len(values) for values in table.values()}) == 1
        assert table.units.keys() == table.keys()
    assert run.table("outcomes")["outcome"].tolist() == [*run.summary.outcomes]
    said = {name: (value, unit) for name, value, unit in zip(*run.table("summary").values(), strict=True)}
    assert said["converged.share"] == (run.summary.converged.share, "1")
    assert said["residuals.moment.end"] == (run.summary.moment.end, "m")
    assert said["residuals.moment.squared.end"] == (run.summary.moment_squared.end, "m²")
    courses, course = run.table("courses"), run.evidence.courses[1]
    np.testing.assert_array_equal(courses["force_residual"][courses["number"] == 1], course.force)


@pytest.mark.slow
def test_trials_are_those_of_the_data_frame(run: g.Run, tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    frame = run.to_dataframe()
    read = pandas.read_parquet(run.export(tmp_path / "trials.parquet"))
    pandas.testing.assert_frame_equal(read, frame)
    assert read.attrs == frame.attrs
    schema = pq.read_schema(tmp_path / "trials.parquet")
    assert schema.field("object_shift").metadata == {b"unit": b"m"}
    assert schema.field("outcome").metadata is None
    of_csv = pandas.read_csv(run.export(tmp_path / "trials.csv"))
    assert json.loads((tmp_path / "trials.units.json").read_text("utf-8")) == frame.attrs["units"]
    of_jsonl = pandas.DataFrame(map(json.loads, run.export(tmp_path / "t.jsonl").read_text("utf-8").splitlines()))
    for name in frame.select_dtypes("number"):
        for other in (of_csv, of_jsonl):
            np.testing.assert_array_equal(other[name].to_numpy(float), frame[name].to_numpy(float), err_msg=name)


def drawn_in(figure: Figure) -> set[float]:
    """Every number that lines, bands and bars of a figure have, but for 0 and 1, where something begins or ends."""
    found = list[float]()
    for axes in figure.axes:
        for line in axes.lines:
            found += [*np.asarray(line.get_xdata(), dtype=float), *np.asarray(line.get_ydata(), dtype=float)]
        for path in (path for area in axes.collections if type(area) is not QuadMesh for path in area.get_paths()):
            found += path.vertices.ravel().tolist()
        for bar in (patch for patch in axes.patches if isinstance(patch, Rectangle)):
            found += [bar.get_x(), bar.get_x() + bar.get_width(), bar.get_height()]
    return {number for number in found if math.isfinite(number)} - {0.0, 1.0}


def test_all_that_a_figure_draws_is_in_its_tables(run: g.Run, by_hand: Evidence) -> None:
    kinds = set()
    for found in (run.evidence, by_hand):
        figures = figures_of(found, summarised(found))
        tables = {name: columns() for name, columns in figure_tables(figures).items()}
        for figure in figures:
            kinds.add(type(figure))
            own = [table for name, table in tables.items() if f"{name}-".startswith(f"figure-{figure.name}-")]
            assert own, figure.name
            for table in own:
                assert len({len(column.values) for column in table.values()}) == 1
                assert any(column.unit and np.isfinite(column.values).all() for column in table.values()), figure.name
                assert all(column.unit for column in table.values() if column.values.dtype.kind != "U")
            told = np.concatenate([column.values for table in own for column in table.values() if column.unit])
            written = {f"{round(number, 12):.9g}" for number in [*told, *100.0 * told]}  # shares are drawn in percent
            missing = {f"{round(number, 12):.9g}" for number in drawn_in(drawing_of(figure).figure)} - written
            # A share is drawn on to the end of its axis.
            assert len(missing) == isinstance(figure, Convergence), (figure.name, missing)
    assert kinds == {*get_args(FigureData)}


def test_quantiles_and_spreads_are_numbers_with_units(by_hand: Evidence) -> None:
    spread = Spread(0.1, 0.05, 0.2)
    load = Load(spread, spread, spread)
    held = Holding(3, "", {"contacts": load}, load, spread, Alone(spread, spread))
    tables = tables_of(by_hand, dataclasses.replace(summarised(by_hand), balance=held), ())
    starts, balance, summary = (tables[name]() for name in ("kept-starts", "balance", "summary"))
    of = starts["number of a start"].values.tolist().index("yaw (rad)")
    assert starts["unit"].values[of] == "rad"
    assert [starts[f"asked for.{name}"].values[of] for name in ("p5", "p50", "p95")] == pytest.approx([0.25, 0.5, 0.75])
    assert (balance["moment.p10"].values[0], balance["moment.p10"].unit) == (50.0, "mN·m")
    told = {
        name: (value, unit) for name, value, unit in zip(*(column.values for column in summary.values()), strict=True)
    }
    assert told["balance.without_table.falling.high"] == (0.2, "m/s²")
    assert told["starts.draws"] == (52.0, "1")


@pytest.mark.slow
def test_every_table_of_the_page_has_its_export(run: g.Run) -> None:
    """The tables of the page as they stand in it, held against those that have an export by their heads and rows."""
    text = page(run.evidence, run.summary, []).replace("\N{NO-BREAK SPACE}", " ")
    shown = {}
    for title, table in re.findall(r'aria-label="([^"]*)"><table[^>]*>(.*?)</table>', text, flags=re.DOTALL):
        heads = [re.sub(r"<[^>]*>", "", head).partition(" (")[0] for head in re.findall(r"<th.*?>(.*?)</th>", table)]
        shown[title] = (heads, table.count("<tr>") - 1)
    assert shown.pop("Trials")[1] == len(run.table("trials")["number"])
    exports = [run.table(name) for name in run.tables]
    parts = re.compile(r"\.(low|high|p5|p50|p95|p10|p90|median)$")
    known = [
        ([*dict.fromkeys(parts.sub("", name).replace("_", "").partition(" (")[0] for name in table)], table)
        for table in exports
    ]
    assert len(shown) >= 7
    for title, (heads, rows) in shown.items():
        found = [table for names, table in known if names in (heads, [*heads, "unit"])]
        assert rows in [len(next(iter(table.values()))) for table in found], title


@pytest.mark.slow
def test_all_tables_at_once(run: g.Run, tmp_path: Path) -> None:
    """A file each, whose units pandas and pyarrow find where they look for them."""
    pandas = pytest.importorskip("pandas")
    folder = run.export(tmp_path / "tables", "all", form="parquet")
    assert {file.name for file in folder.iterdir()} == {f"{name}.parquet" for name in run.tables}
    for name in run.tables:
        table, file = run.table(name), folder / f"{name}.parquet"
        assert pandas.read_parquet(file).attrs == {"units": table.units}
        fields = {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in pq.read_schema(file)}
        assert fields == table.units
    with pytest.raises(g.DiagnosticError, match=r"error\[folder-not-empty\]"):
        run.export(folder, "all")
    with pytest.raises(ValueError, match="trial: "):
        run.export(tmp_path / "x", "all", trial=1)


def test_a_trajectory(run: g.Run, tmp_path: Path) -> None:
    trajectory = run.trajectory(1)
    with np.load(run.export(tmp_path / "t.npz", "trajectory", trial=1)) as arrays:
        assert {*arrays} == {*trajectory}
        np.testing.assert_array_equal(arrays["points"], trajectory["points"])
    assert json.loads((tmp_path / "t.units.json").read_text("utf-8")) == trajectory.units
    lines = list(csv.DictReader(run.export(tmp_path / "t.csv", "trajectory", trial=1).open(encoding="utf-8")))
    read = np.array([line["points.point-2.y"] for line in lines], dtype=np.float32)
    np.testing.assert_array_equal(read, trajectory["points"][:, 1, 1])


def test_what_there_is_not_is_said(run: g.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(g.DiagnosticError, match=r"error\[unknown-format\].*\n  hint: did you mean parquet\?"):
        format_of(tmp_path / "x.parqet")
    with pytest.raises(g.DiagnosticError, match=r"end it with \.csv, \.jsonl, \.parquet or \.npz"):
        run.export(tmp_path / "x")
    with pytest.raises(g.DiagnosticError, match=r"error\[unknown-trial\]"):
        run.export(tmp_path / "x.csv", "trajectory", trial=TRIALS)
    with pytest.raises(ValueError, match="trial: "):
        run.export(tmp_path / "x.csv", "trajectory")
    with pytest.raises(g.DiagnosticError, match=r"x\.csv: error\[folder-not-writable\]"):
        run.export(run.path / "run.json" / "x.csv")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ImportError, match=r'parquet needs pyarrow: pip install "graspdsl\[parquet\]"'):
        run.export(tmp_path / "x.parquet")
    answer = CliRunner().invoke(app, ["export", str(run.path), "--to", str(tmp_path / "x.parquet")])
    assert (answer.exit_code, answer.stdout) == (1, "")
    assert (
        'error[not-installed]: parquet needs pyarrow\n  hint: install it: pip install "graspdsl[parquet]"'
        in answer.stderr
    )
    assert list(tmp_path.iterdir()) == []


def test_the_command(run: g.Run, tmp_path: Path) -> None:
    def export(*words: str) -> tuple[int, str, str]:
        answer = CliRunner().invoke(app, ["export", str(run.path), *words])
        return answer.exit_code, answer.stdout, answer.stderr

    assert export() == (0, as_csv(run.columns_for("trials")), "")
    assert export("--format", "jsonl")[1].count("\n") == TRIALS
    code, _, said = export("--what", "modes", "--to", str(tmp_path / "modes.csv"))
    assert (code, said) == (0, f"modes → {tmp_path / 'modes.csv'}\n")
    assert export("--format", "parquet")[2].startswith("-: error[unknown-format]: parquet is no text for stdout")
    assert export("--what", "all")[2].startswith("-: error[unknown-format]: all tables are files of a folder")
    code, _, said = export("--what", "all", "--to", str(tmp_path / "all"))
    assert (code, said) == (0, f"{len(run.tables)} tables → {tmp_path / 'all'}\n")
    assert (tmp_path / "all" / "modes.csv").read_bytes() == (tmp_path / "modes.csv").read_bytes()
    assert export("--what", "mods")[2].endswith("hint: did you mean modes?\n")
    assert export("--what", "trajectory")[0] == export("--trial", "1")[0] == 2
    assert export("--what", "trajectory", "--trial", "1")[1].startswith("tick,time,phase,")
