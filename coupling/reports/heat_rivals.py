"""A box that conducts, stores and radiates, by three programs: ours, plain scikit-fem, CalculiX.

k and c rise with temperature, all faces radiate, one absorbs; backward Euler with equal steps,
consistent capacity. Ours and scikit-fem solve for the stored heat, CalculiX for its rate at the end
of a step, so that the answers of the two differ by the square of the change in a step. Times are
those of the processor, with one thread each, so that what else a machine does matters less.
"""

import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Material, constant, polynomial
from meshes.mesh import Mesh
from meshes.solids import box
from thermal.boundary import STEFAN_BOLTZMANN
from thermal.description import Description, Flux, Radiation, Settings, Solid
from thermal.solvers import build

Array = NDArray[np.float64]

SIDE, INITIAL, SINK = 0.1, 400.0, 150.0
"""Length of an edge [m], temperatures at the start and of the surroundings [K]."""
EMISSIVITY, SUN, STEP = 0.8, 5e4, 10.0
"""[-], absorbed flux density on the face x0 [W/m^2], step [s]."""
DENSITY = 2700.0
CONDUCTIVITY, CAPACITY = (120.0, 0.5), (800.0, 1.2)
"""[kg/m^3]; [W/(m K)] and [J/(kg K)]: at 300 K, and slope."""
ALONE = {**os.environ, "OMP_NUM_THREADS": "1"}
DIRECT, ITERATIVE = "SPOOLES", "ITERATIVE CHOLESKY"
"""Solvers of CalculiX: the usual one, and the fastest of its others for this box."""
FACES = np.array(
    [[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]]
)
"""Corners of the faces of a hexahedron as CalculiX counts them."""


class Answer(NamedTuple):
    """Temperatures [K] after some steps; processor times [s] of each, and of what precedes."""

    T: Array
    steps: list[float]
    start: float


def mesh(cells: int) -> Mesh:
    """A cube of ``cells`` hexahedra along each edge."""
    return box([SIDE] * 3, (cells,) * 3)


def ours(cells: int, steps: int, linear: str = "auto") -> Answer:
    """By the solver solid."""
    begun = process_time()
    solver = build(
        "solid",
        description(cells),
        Settings(scheme="backward-euler", steps=1, linear=linear, capacity="consistent"),
    )
    T, ready, taken = solver.initial(), process_time(), []
    for i in range(steps):
        before = process_time()
        T, _, why = solver.advance(T, i * STEP, STEP, np.zeros_like(T))
        taken.append(process_time() - before)
        assert not why, why
    return Answer(T, taken, ready - begun)


def description(cells: int) -> Description:
    """The box."""
    k = polynomial("conductivity", "W/(m K)", CONDUCTIVITY, 300.0)
    c = polynomial("heat_capacity", "J/(kg K)", CAPACITY, 300.0)
    young, poisson = constant("youngs_modulus", "Pa", 69e9), constant("poissons_ratio", "1", 0.33)
    material = Material("m", DENSITY, young, poisson, constant("expansion", "1/K", 23e-6), k, c)
    return Description(
        solids=(Solid("box", mesh(cells), {"": material}, INITIAL),),
        conditions=(
            Radiation("radiation", "box", EMISSIVITY, lambda t: SINK),
            Flux("sun", "box", lambda t: SUN, None, "x0"),
        ),
    )


def plain(cells: int, steps: int) -> Answer:
    """By scikit-fem as its examples have it: assembled in each iteration, CG with Jacobi."""
    begun = process_time()
    iterate = _plain_iteration(mesh(cells))
    T, ready, taken = np.full((cells + 1) ** 3, INITIAL), process_time(), []
    for _ in range(steps):
        before, old = process_time(), T
        for _ in range(20):
            change = iterate(T, old)
            T = T + change
            if np.abs(change).max() < 1e-8 * T.max():
                break
        taken.append(process_time() - before)
    return Answer(T, taken, ready - begun)


def _plain_iteration(grid: Mesh) -> Callable[[Array, Array], Array]:
    from scipy.sparse.linalg import cg
    from skfem import Basis, BilinearForm, ElementHex1, FacetBasis, LinearForm, MeshHex
    from skfem.helpers import dot, grad

    cells = grid.cells["hexahedron"][:, [0, 1, 3, 4, 2, 5, 7, 6]]
    m = MeshHex(grid.points.T.copy(), cells.T.copy())
    bulk = Basis(m, ElementHex1(), intorder=2)
    skin = FacetBasis(m, ElementHex1(), intorder=2)
    lit = FacetBasis(m, ElementHex1(), facets=m.facets_satisfying(lambda x: x[0] < 1e-9))

    def k(T):
        return CONDUCTIVITY[0] + CONDUCTIVITY[1] * (T - 300.0)

    def c(T):
        return DENSITY * (CAPACITY[0] + CAPACITY[1] * (T - 300.0))

    @BilinearForm
    def tangent(u, v, w):
        return c(w["T"]) * u * v / STEP + k(w["T"]) * dot(grad(u), grad(v))

    @BilinearForm
    def slope(u, v, w):
        return 4.0 * EMISSIVITY * STEFAN_BOLTZMANN * w["T"] ** 3 * u * v

    @LinearForm
    def residual(v, w):
        rise = 0.5 * (c(w["T"]) + c(w["old"])) * (w["T"] - w["old"]) / STEP
        return rise * v + k(w["T"]) * dot(grad(w["T"]), grad(v))

    @LinearForm
    def radiated(v, w):
        return EMISSIVITY * STEFAN_BOLTZMANN * (w["T"] ** 4 - SINK**4) * v

    @LinearForm
    def absorbed(v, w):
        return SUN * v

    def iterate(T, old):
        inside, outside = bulk.interpolate(T), skin.interpolate(T)
        A = tangent.assemble(bulk, T=inside) + slope.assemble(skin, T=outside)
        r = residual.assemble(bulk, T=inside, old=bulk.interpolate(old))
        r = absorbed.assemble(lit) - radiated.assemble(skin, T=outside) - r
        diagonal = A.diagonal()
        change, failed = cg(A, r, rtol=1e-6, M=_Jacobi(diagonal))
        assert not failed
        return change

    return iterate


def _Jacobi(diagonal: Array):
    from scipy.sparse import diags_array

    return diags_array(1.0 / diagonal)


def calculix(cells: int, steps: int, solver: str = ITERATIVE) -> Answer:
    """By ``ccx``: the time of a step is what further increments of a run add to it.

    solver : of its linear systems
    """
    (T, one), (_, more) = (_ran(cells, n, solver) for n in (steps, 2 * steps))
    each = (more - one) / steps
    return Answer(T, [each] * steps, one - steps * each)


def _ran(cells: int, steps: int, solver: str) -> tuple[Array, float]:
    """Temperatures after a run, and its time [s]."""
    with TemporaryDirectory(prefix="heat-") as folder:
        (Path(folder) / "job.inp").write_text(deck(mesh(cells), steps, solver), encoding="ascii")
        before = _of_children()
        subprocess.run(["ccx", "job"], cwd=folder, check=True, capture_output=True, env=ALONE)
        taken = _of_children() - before
        lines = (Path(folder) / "job.dat").read_text().splitlines()[-((cells + 1) ** 3) :]
    return np.array([float(line.split()[1]) for line in lines]), taken


def _of_children() -> float:
    """Processor time [s] of programs that have ended."""
    times = os.times()
    return times.children_user + times.children_system


def deck(grid: Mesh, steps: int, solver: str) -> str:
    """The box for CalculiX, whose temperatures are printed at the end."""
    cells = grid.cells["hexahedron"]
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{i},{x:.12g},{y:.12g},{z:.12g}" for i, (x, y, z) in enumerate(grid.points, 1)]
    lines += ["*ELEMENT, TYPE=DC3D8, ELSET=BODY"]
    lines += [f"{i}," + ",".join(map(str, nodes)) for i, nodes in enumerate(cells + 1, 1)]
    lines += ["*MATERIAL, NAME=M", "*DENSITY", f"{DENSITY}"]
    for keyword, (value, slope) in (("CONDUCTIVITY", CONDUCTIVITY), ("SPECIFIC HEAT", CAPACITY)):
        lines += [f"*{keyword}"] + [f"{value + slope * (T - 300.0)}, {T}" for T in (100.0, 900.0)]
    lines += ["*SOLID SECTION, ELSET=BODY, MATERIAL=M", "*PHYSICAL CONSTANTS, ABSOLUTE ZERO=0."]
    lines[-1] += f", STEFAN BOLTZMANN={STEFAN_BOLTZMANN}"
    lines += ["*INITIAL CONDITIONS, TYPE=TEMPERATURE", f"ALL, {INITIAL}"]
    lines += [f"*STEP, INC={steps + 1}", f"*HEAT TRANSFER, DIRECT, SOLVER={solver}"]
    lines += [f"{STEP}, {STEP * steps}"]
    lines += ["*DFLUX", *_on(grid, "x0", f"S{{}}, {SUN}"), "*RADIATE"]
    for side in ("x0", "x1", "y0", "y1", "z0", "z1"):
        lines += _on(grid, side, f"R{{}}, {SINK}, {EMISSIVITY}")
    lines += [f"*NODE PRINT, NSET=ALL, FREQUENCY={steps}", "NT", "*END STEP", ""]
    return "\n".join(lines)


def _on(grid: Mesh, side: str, text: str) -> list[str]:
    """A line for each cell at a side of the box, with the number of its face."""
    axis, end = "xyz".index(side[0]), float(side[1]) * SIDE
    at = np.abs(grid.points[:, axis] - end) < 1e-9
    hit = at[grid.cells["hexahedron"][:, FACES]].all(axis=2)
    return [f"{cell + 1}, " + text.format(face + 1) for cell, face in np.argwhere(hit)]
