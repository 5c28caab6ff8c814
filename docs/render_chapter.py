"""Draw the pictures of the page on the chapter, each from runs of its specs.

Run it with the developers' tools installed: python docs/render_chapter.py
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Ellipse

import graspdsl as g
from graspdsl.arrays import Array

ROOT = Path(__file__).resolve().parent.parent
CHAPTER = ROOT / "specs" / "chapter"
IMAGES = ROOT / "docs" / "images"
BLUE, ORANGE, GREEN, PURPLE, GREY = "#0072b2", "#c45200", "#00805d", "#ab5286", "#565f69"
SIZES = (0.10, 0.12, 0.15)  # m, the ellipsoid of specs/chapter


def trajectories(spec: str, *settings: str, trials: int = 1) -> list[g.Trajectory]:
    """Those of the first trials of a spec of the chapter."""
    program = g.load(CHAPTER / spec, set=settings)
    run = g.run(program, trials=trials, progress=False)
    return [run.trajectory(number) for number in range(trials)]


def residuals() -> Figure:
    """Medians of both residuals under four controllers."""
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    shown = (
        ("φ_fr alone, Eq. 4.13", BLUE, "π_fr|Γ Γ"),
        ("φ_mr alone, Eq. 4.17", ORANGE, "π_mr|Γ Γ"),
        ("C*: φ_fr, then φ_mr", PURPLE, "π_cstar|Γ Γ"),
        ("φ_mr ◁ φ_fr, Eq. 4.18", GREEN, "π_g|Γ Γ"),
    )
    for label, colour, formula in shown:
        settings = (
            f"program.0.run={formula}",
            "program.0.limit=2",
            "program.0.full_time=true",
            "monitors.progress=off",
        )
        runs = trajectories("4_18_grasp.yaml", *settings, trials=20)
        for axis, channel, scale in zip(axes, ("force_residual", "moment_residual"), (1.0, 1000.0), strict=True):
            axis.plot(scale * np.median([run[channel][:100] for run in runs], axis=0), color=colour, label=label)
    for axis, name in zip(axes, ("‖ρ_f‖", "‖ρ_m‖ [mm]"), strict=True):
        axis.set(xlabel="tick", ylabel=f"{name}, median of 20 trials", ylim=(0, None))
        axis.spines[["top", "right"]].set_visible(False)
    axes[0].legend(fontsize=8, frameon=False)
    return figure


def null_space() -> Figure:
    """The steps of a tick, in the plane of both gradients: with all contacts moving, and with two of them.

    Of all ticks of twenty trials it is one at which, with two moving, they are of like size and far from a right angle.
    """
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    runs = trajectories("4_18_grasp.yaml", trials=20)
    ticks = [(run["points"][tick], run["normals"][tick]) for run in runs for tick in range(len(run["time"]))]
    fewer = _steps("{γ2, γ3}")

    def shows(tick: tuple[Array, Array]) -> float:
        force, moment, both = fewer(*tick)
        along = abs(moment @ force) / np.linalg.norm(force)
        sizes = np.array([along, np.linalg.norm(both - force), np.linalg.norm(force)])
        return float(sizes.min() / sizes.max())

    chosen = max(ticks, key=shows)
    for axis, moving in zip(axes, ("{γ1, γ2, γ3}", "{γ2, γ3}"), strict=True):
        force, moment, both = _steps(moving)(*chosen)
        along = force / np.linalg.norm(force)
        across = moment - (moment @ along) * along
        across /= np.linalg.norm(across)
        for vector, colour, label, width in (
            (both - force, GREEN, "of the moment, the part across: N of it", 5.0),
            (moment, ORANGE, "moment: −k∇φ_mr", 1.8),
            (force, BLUE, "force: −k∇φ_fr", 1.8),
            (both, GREY, "executed: force and that part", 1.8),
        ):
            tip = (float(vector @ along), float(vector @ across))
            axis.annotate("", tip, (0, 0), arrowprops={"arrowstyle": "-|>", "color": colour, "lw": width, "alpha": 0.8})
            axis.plot(*tip, color=colour, lw=width, label=label)
        tips = np.array([[v @ along, v @ across] for v in (force, moment, both)])
        low, high = np.minimum(tips.min(axis=0), 0.0), tips.max(axis=0)
        margin = 0.12 * (high - low).max()
        axis.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin), aspect="equal")
        degrees = np.degrees(np.arccos(_cosine(force, moment)))
        axis.set_title(f"moving: {moving}; {degrees:.0f}° between", fontsize=9)
        axis.set(xlabel="along the step of the force [mm]", ylabel="across it [mm]")
    axes[1].legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _steps(moving: str) -> Callable[[Array, Array], list[Array]]:
    """What makes of points and normals the steps [mm] of the force residual, the moment residual and 4.30, with some
    contacts moving."""
    contacts = {f"γ{number}": f"point-{number}" for number in (1, 2, 3)}
    resources = {**contacts, "Γ": "{γ1, γ2, γ3}", "Γ_τ": moving}
    formulas = ("φ_fr|τ_frx(Γ_τ) σ_fr(Γ)", "φ_mr|τ_mrx(Γ_τ) σ_mr(Γ)", "π_gx|Γ_τ Γ")
    made = [g.compile(one, hand="points", resources=resources, control={"cap": 0.1}) for one in formulas]
    example = made[0].example()

    def steps(points: Array, normals: Array) -> list[Array]:
        seen = replace(example, points=points.astype(float), normals=normals.astype(float))
        return [1000.0 * controller(seen).command.displacement.ravel() for controller in made]

    return steps


def _cosine(one: Array, other: Array) -> float:
    return float(one @ other / (np.linalg.norm(one) * np.linalg.norm(other)))


def paths() -> Figure:
    """Where three contacts slide on an ellipsoid, from two sides."""
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
    [run] = trajectories("4_30_grasp_cartesian.yaml")
    points, normals = 100.0 * run["points"][:, :3], run["normals"][:, :3]
    for axis, (x, y) in zip(axes, ((0, 1), (0, 2)), strict=True):
        axis.add_patch(Ellipse((0, 0), 100 * SIZES[x], 100 * SIZES[y], facecolor="0.95", edgecolor="0.6"))
        for contact, colour in enumerate((BLUE, ORANGE, GREEN)):
            axis.plot(points[:, contact, x], points[:, contact, y], color=colour, lw=1.8, label=f"γ{contact + 1}")
            axis.plot(*points[0, contact, [x, y]], "o", color=colour, mfc="white", ms=6)
            end, push = points[-1, contact, [x, y]], 2.0 * normals[-1, contact, [x, y]]
            arrow = {"arrowstyle": "-|>", "color": colour, "lw": 1.4}
            axis.annotate("", end, end - push, arrowprops=arrow)
        axis.set(
            xlabel=f"{'xyz'[x]} [cm]", ylabel=f"{'xyz'[y]} [cm]", aspect="equal", xlim=(-9.5, 9.5), ylim=(-9.8, 9.8)
        )
        axis.spines[["top", "right"]].set_visible(False)
    axes[0].legend(fontsize=8, frameon=False, loc="upper left")
    axes[0].set_title("○ where they were drawn; arrows: unit forces at the end", fontsize=9)
    return figure


def virtual() -> Figure:
    """Where three contacts come to rest on a cylinder, as three and as two of which one is virtual."""
    figure, axes = plt.subplots(1, 2, figsize=(7.4, 3.6), layout="constrained")
    cylinder = "scene.object={cylinder: {diameter: 0.10, height: 0.20}}"
    for axis, resources in zip(axes, ("{γ1, γ2, γ3}", "{γ1, <γ2, γ3>}"), strict=True):
        [run] = trajectories("4_30_grasp_cartesian.yaml", cylinder, f'resources.Γ="{resources}"', "trials.seed=4")
        points, normals = 100.0 * run["points"][:, :3, :2], run["normals"][-1, :3, :2]
        axis.add_patch(Circle((0, 0), 5.0, facecolor="0.95", edgecolor="0.6"))
        for contact, colour in enumerate((BLUE, ORANGE, GREEN)):
            axis.plot(*points[:, contact].T, color=colour, lw=1.8)
            axis.plot(*points[0, contact], "o", color=colour, mfc="white", ms=6)
            end, push = points[-1, contact], 2.2 * normals[contact]
            axis.annotate("", end, end - push, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.4})
            axis.text(*(end - 1.35 * push), f"γ{contact + 1}", color=colour, ha="center", va="center")
        axis.set(aspect="equal", xlim=(-9, 9), ylim=(-9, 9), title=f"Γ = {resources}")
        axis.set_axis_off()
    return figure


def sliding() -> Figure:
    """Heights and forces of a trial in which contacts climb while they press."""
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.0), layout="constrained")
    [run] = trajectories("4_24_slide.yaml")
    rows = run["phase"] == 1
    time, heights, forces = run["time"][rows], 100.0 * run["points"][rows][..., 2], run["forces"][rows]
    names = (("γ2", ORANGE), ("γ3", GREEN), ("γ1, the thumb", BLUE))  # in the order of the fingers
    for contact, (name, colour) in enumerate(names):
        axes[0].plot(time, heights[:, contact], color=colour, label=name)
        axes[1].plot(time, np.linalg.norm(forces[:, contact], axis=-1), color=colour)
    axes[0].plot(time, heights[:, :2].mean(axis=-1), color=PURPLE, lw=3, ls=":", label="<γ2, γ3>, their mean")
    axes[0].axhline(12.0, color=GREY, lw=1, ls="--", label="x_ref")
    axes[1].axhline(0.5, color=GREY, lw=1, ls="--", label="κ_f")
    axes[0].set(xlabel="time [s]", ylabel="height [cm]")
    axes[1].set(xlabel="time [s]", ylabel="force [N]", ylim=(0, 1))
    axes[0].legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    axes[1].legend(fontsize=8, frameon=False)
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
    return figure


def gravity() -> Figure:
    """How a held ball is turned until the thumb opposes its weight."""
    figure, axis = plt.subplots(figsize=(9, 2.8), layout="constrained")
    [run] = trajectories("4_41_rotate_orientation.yaml")
    rows = run["phase"] == 1
    axis.plot(run["time"][rows], np.linalg.norm(run["sensed_force_residual"][rows], axis=-1), color=BLUE)
    axis.axhline(0.04, color=GREY, lw=1, ls="--")
    axis.set(xlabel="time [s]", ylabel="‖ρ_f‖ of {γ1, γ_g}", ylim=(0, None))
    axis.spines[["top", "right"]].set_visible(False)
    return figure


PICTURES = {
    "residuals": residuals,
    "null_space": null_space,
    "paths": paths,
    "virtual": virtual,
    "sliding": sliding,
    "gravity": gravity,
}


def main() -> None:
    """Draw them all; the same runs give the same files."""
    mpl.rcParams.update(
        {
            "svg.hashsalt": "graspdsl",
            "svg.fonttype": "none",
            "font.family": "sans-serif",
            "path.simplify_threshold": 1.0,
        }
    )
    for name, draw in PICTURES.items():
        draw().savefig(IMAGES / f"chapter_{name}.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
