"""The shapes of beams and continuum on one another, and how far all models deviate."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.crosscheck.comparison import ANCF, CONTINUUM, EXACT, OUTSIDE, Comparison, Row
from coupling.crosscheck.samples import Samples, Section, is_beam, nodes_of
from coupling.crosscheck.solved import Solved, asked
from coupling.descriptions import line_bodies

Array = NDArray[np.float64]

COLOURS = {ANCF: "#0072B2", "calculix": "#009E73", "exudyn": "#CC79A7", EXACT: "#000000"}
MARKS = {ANCF: "o", "calculix": "s", "exudyn": "^", EXACT: "D"}
SOLID, REST = "#E69F00", "#c9ced4"
SMALL = 0.08
"""Largest displacement, over the size of what is drawn, below which it is magnified [-]."""
NOT_ZERO = 1e-6
"""Least deviation that the diagram shows [-]."""


class Shapes(NamedTuple):
    """points : (k, 3) [m]  surface nodes at rest;  quads : (f, 4) int
    solid, beams : (k, 3) [m]  where they are by each model; None: not computed
    """  # fmt: skip

    points: Array
    quads: NDArray[np.intp]
    solid: Array | None
    beams: Array | None


def draw(result: Comparison, path: Path) -> Path:
    """Both shapes above, deviations below."""
    import matplotlib
    from matplotlib.figure import Figure

    from coupling.plot import STYLE

    rows = [row for row in result.rows if row.deviations]
    with matplotlib.rc_context(STYLE):
        height = 5.0 + 0.28 * len(rows)
        figure = Figure(figsize=(10.0, height), dpi=130, layout="constrained")
        parts: Any = figure.subfigures(2, 1, height_ratios=[4.2, height - 4.2])
        _draw_shapes(parts[0], result)
        _draw_deviations(parts[1].subplots(), rows)
        title = result.scene.title or result.scene.folder.name
        figure.suptitle(title, x=0.01, ha="left", weight="bold")
        figure.savefig(path)
    return path


# ---------------------------------------------------------------------------------- shapes


def state_of(solved: Solved) -> Array:
    """(n,) coordinates that are drawn: in equilibrium, or where the first probe is farthest."""
    if "transient" in asked(solved.scene).stages:
        return solved.course.peak
    stages = {"static", "pointing", "frequencies"}
    if stages & set(asked(solved.scene).stages):
        return solved.equilibrium.q
    return solved.expanded.q


def shapes(result: Comparison) -> dict[str, Shapes]:
    """Of each beam of the case."""
    beams = result.models[ANCF].solved
    solid = result.models[CONTINUUM].solved if CONTINUUM in result.models else None
    assert beams is not None
    found = {}
    for name in line_bodies(result.scene):
        if solid is None or is_beam(solid.model, name):
            found[name] = _ribbon(beams, name)
            continue
        body: Any = solid.model.layout.bodies[name]
        quads = surface(body.cells)
        used, local = np.unique(quads, return_inverse=True)
        points = nodes_of(solid.model, name)[used]
        at = solid.model.layout.node_dofs[name][used][:, None] + np.arange(3)
        there = beams.samples({name: points}).places(state_of(beams))
        found[name] = Shapes(points, local.reshape(quads.shape), state_of(solid)[at], there)
    return found


def _ribbon(beams: Solved, name: str) -> Shapes:
    """The axis of a beam, as quads without width."""
    points = beams.scene.shapes[name].points
    made: Samples = beams.samples({name: points})
    i = np.arange(len(points) - 1)
    return Shapes(points, np.stack([i, i + 1, i + 1, i], 1), None, made.places(state_of(beams)))


def surface(cells: NDArray[np.intp]) -> NDArray[np.intp]:
    """(f, 4)  corners of the faces that belong to one cell only."""
    from meshes.families import FACES

    quads = cells[:, FACES["hexahedron"]].reshape(-1, 4)
    _, first, count = np.unique(
        np.sort(quads, axis=1), axis=0, return_index=True, return_counts=True
    )
    return quads[first[count == 1]]


def _draw_shapes(figure: Any, result: Comparison) -> None:
    """All beams in the plane of their motion; beside it the section at the first probe, if any."""
    bodies = shapes(result)
    plane = _plane(list(bodies.values()))
    factor = _magnified(list(bodies.values()))
    axes = figure.subplots(1, 2, gridspec_kw={"width_ratios": [2.4, 1.0]})
    for one in bodies.values():
        _draw_one(axes[0], one, plane, factor)
    axes[0].set_aspect("equal", adjustable="datalim")
    times = "true scale" if factor == 1.0 else f"displacements x {factor:g}"
    axes[0].set_title(f"at rest and deformed, {times}")
    axes[0].set_xlabel("[m]")
    _legend(axes[0], result)
    _draw_section(axes[1], result)


def _plane(bodies: list[Shapes]) -> Array:
    """(2, 3) directions of the picture: along the bodies, and where they go."""
    points = np.concatenate([one.points for one in bodies])
    moved = np.concatenate([_moved(one) for one in bodies])
    first = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    first *= np.sign(first[np.argmax(np.abs(first))])
    across = moved - np.outer(moved @ first, first)
    spread = np.linalg.norm(across, axis=1).max()
    if spread <= 1e-9 * np.ptp(points, axis=0).max():
        across = points - points.mean(axis=0)
        across = across - np.outer(across @ first, first)
    second = np.linalg.svd(across, full_matrices=False)[2][0]
    second -= (second @ first) * first
    second *= np.sign(second[np.argmax(np.abs(second))])
    return np.stack([first, second / np.linalg.norm(second)])


def _moved(one: Shapes) -> Array:
    there = one.beams if one.solid is None else one.solid
    assert there is not None
    return there - one.points


def _magnified(bodies: list[Shapes]) -> float:
    """1, or a round factor that makes displacements seen."""
    size = max(float(np.ptp(one.points, axis=0).max()) for one in bodies)
    most = max(float(np.linalg.norm(_moved(one), axis=1).max()) for one in bodies)
    if most == 0.0 or most >= SMALL * size:
        return 1.0
    wanted = SMALL * size / most
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(power * max(k for k in (1, 2, 5) if k * power <= wanted))


def _draw_one(ax: Any, one: Shapes, plane: Array, factor: float) -> None:
    from matplotlib.collections import PolyCollection

    def seen(points: Array) -> Any:
        return (points @ plane.T)[one.quads]

    ax.add_collection(PolyCollection(seen(one.points), fc="#eef0f2", ec=REST, lw=0.5))
    if one.solid is not None:
        there = one.points + factor * (one.solid - one.points)
        ax.add_collection(PolyCollection(seen(there), fc="#fbe3b0", ec=SOLID, lw=0.6))
    if one.beams is not None:
        there = one.points + factor * (one.beams - one.points)
        wire = PolyCollection(seen(there), fc="none", ec=COLOURS[ANCF], lw=0.5, ls=(0, (3, 2)))
        ax.add_collection(wire)
    ax.autoscale_view()


def _legend(ax: Any, result: Comparison) -> None:
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], color=REST, lw=3, label="at rest")]
    if CONTINUUM in result.models:
        handles.append(Line2D([], [], color=SOLID, lw=3, label="continuum"))
    handles.append(Line2D([], [], color=COLOURS[ANCF], ls="--", lw=1, label="ANCF"))
    ax.legend(handles=handles, loc="best")


def _draw_section(ax: Any, result: Comparison) -> None:
    """The section at the first probe: how it deforms in its own plane, much magnified."""
    solid = result.models[CONTINUUM].solved if CONTINUUM in result.models else None
    beams = result.models[ANCF].solved
    if solid is None or beams is None or not solid.sections:
        ax.axis("off")
        return
    name, section = next(iter(solid.sections.items()))
    body = result.scene.probe[name].body
    there = Section(beams.samples({body: section.samples.points}), section.axes)
    flat, wide = section.flat(state_of(solid))
    rims = {CONTINUUM: wide, ANCF: there.flat(state_of(beams))[1]}
    most = max(float(np.abs(rim - flat).max()) for rim in rims.values())
    size = float(np.ptp(flat, axis=0).max())
    factor = 1.0 if most == 0.0 else 10.0 ** np.floor(np.log10(0.1 * size / most))
    ax.plot(*(1e3 * flat.T), ".", color=REST, ms=4)
    for who, mark in ((CONTINUUM, "o"), (ANCF, ".")):
        rim = flat + factor * (rims[who] - flat)
        colour = SOLID if who == CONTINUUM else COLOURS[ANCF]
        ax.plot(*(1e3 * rim.T), mark, color=colour, ms=5 if mark == "o" else 3, mfc="none")
    ax.margins(0.1)
    ax.set_aspect("equal")
    ax.set_title(f"section at {name}, strains × {factor:.0e}")
    ax.set_xlabel("along e2 [mm]")
    ax.set_ylabel("along e3 [mm]")


# ------------------------------------------------------------------------------ deviations


def _draw_deviations(ax: Any, rows: list[Row]) -> None:
    """One line for each quantity: what is allowed as a bar, each model as a mark."""
    for i, row in enumerate(rows):
        y = len(rows) - i
        ax.barh(y, row.tolerances[ANCF], left=0.0, height=0.7, color="#e8f2e8", zorder=0)
        if np.isfinite(row.error):
            ax.barh(y, max(row.error, NOT_ZERO), height=0.28, color=SOLID, zorder=1)
        for name, apart in row.deviations.items():
            if name != CONTINUUM:
                colour = "#D00000" if name in row.beyond else COLOURS[name]
                ax.plot(max(abs(apart), NOT_ZERO), y, MARKS[name], color=colour, ms=6, zorder=2)
    ax.set_xscale("log")
    most = max((abs(x) for row in rows for x in row.deviations.values()), default=0.0)
    limits = [limit for row in rows for limit in row.tolerances.values()]
    ax.set_xlim(NOT_ZERO / 1.5, 2.0 * max(most, *limits, 1e-3))
    labels = [f"{row.stage}: {row.quantity}" for row in reversed(rows)]
    ax.set_yticks(range(1, len(rows) + 1), labels, fontsize=8)
    ax.set_xlabel("deviation [-] (what is less than 1e-6 is drawn there)")
    _legend_of_deviations(ax, rows)


def _legend_of_deviations(ax: Any, rows: list[Row]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    there = {name for row in rows for name in row.deviations}
    handles: list[Any] = [
        Line2D([], [], color=COLOURS[n], marker=MARKS[n], ls="", label=n)
        for n in (ANCF, *OUTSIDE, EXACT)
        if n in there
    ]
    handles += [Patch(color="#e8f2e8", label="allowed"),
                Patch(color=SOLID, label="error of the continuum")]  # fmt: skip
    ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0))
