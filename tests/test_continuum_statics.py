"""Solid bodies against theories of rods, closed forms of heat, and CalculiX with the same mesh."""

import shutil
import subprocess

import numpy as np
import pytest
from continuum_cases import (
    ALUMINIUM,
    COLD,
    areas,
    bar,
    cantilever,
    distorted,
    free,
    point,
    straight,
)
from scipy.sparse.linalg import spsolve

from mechanics.buckling import buckling
from mechanics.description import Clamp, Continuum, Description, Site
from mechanics.system import Factors, System
from meshes.materials import constant_material, library_material
from meshes.sections import tube

E_MODULUS, ALPHA = 69e9, 23.1e-6
SQUARE = (1.0, 0.01, 0.01)
REDUCED, FULL, LAGRANGE = (
    ("hexahedron20", (20, 2, 1)),
    ("hexahedron20-full", (40, 1, 1)),
    ("hexahedron27", (40, 1, 1)),
)
meshes_of = pytest.mark.parametrize(("element", "counts"), [REDUCED, FULL, LAGRANGE])


def boom(element, counts, load=0.0):
    mesh = bar(SQUARE, counts, element.removesuffix("-full"))
    return cantilever(mesh, element=element, load=(0.0, 0.0, -load))


@meshes_of
def test_elastica(element, counts):
    """Theory of rods that stretch and shear; 2e-4 of the length covers the coarse mesh."""
    made = boom(element, counts, 172.5)
    r = made.at_tip(made.equilibrium().q)[0]
    assert r[[0, 2]] == pytest.approx([0.74557, -0.60330], abs=1.5e-4)
    assert abs(r[1]) < 1e-9


@meshes_of
def test_bent_by_a_load_and_by_heat(element, counts):
    """A dead load and 200 K across the thickness that bend the same way; theory of rods."""
    made = boom(element, counts, 86.25)
    r, _, r_z = made.at_tip(made.equilibrium(lambda x: COLD + 2e4 * x[:, 2]).q)
    assert r[[0, 2]] == pytest.approx([0.79299, -0.54020], abs=1.5e-4)
    assert np.arctan2(r_z[0], r_z[2]) == pytest.approx(0.99361, abs=2e-4)


def test_free_bow_of_a_temperature_that_is_linear_across():
    """Curvature alpha G and length (1 + alpha dT), the root swelling freely: no stress at all."""
    gradient = 2e3
    made = boom(*REDUCED)
    found = made.equilibrium(lambda x: COLD + 50.0 + gradient * x[:, 2])
    r, _, r_z = made.at_tip(found.q)
    stretch = 1.0 + ALPHA * 50.0
    angle = ALPHA * gradient / stretch  # fibres at z turn by ds/dz over ds/s
    expected = np.array([np.sin(angle), np.cos(angle) - 1.0]) * stretch / angle
    assert r[[0, 2]] == pytest.approx(expected, rel=2e-5)
    assert np.arctan2(r_z[0], r_z[2]) == pytest.approx(angle, rel=2e-5)
    assert np.linalg.norm(r_z) == pytest.approx(stretch, rel=1e-6)
    hot = made.rest(lambda x: COLD + 50.0 + gradient * x[:, 2])
    stress = made.system.elements[0].stresses(found.q, hot[0])
    assert np.abs(stress).max() < 1e-3 * E_MODULUS * ALPHA * gradient * 0.01


def test_frequencies_of_a_cantilever():
    roots = np.array([1.8751041, 1.8751041, 4.6940911])
    exact = roots**2 / (2.0 * np.pi) * np.sqrt(E_MODULUS * 1e-4 / 12.0 / 2700.0)
    found = boom(*REDUCED).frequencies(3)
    assert found == pytest.approx(exact, rel=1e-3)
    assert found[0] < exact[0]  # shear and rotational inertia, 8e-5


def test_frequency_of_a_tube_follows_its_modulus():
    """Mean radius 12.5 mm, wall 1 mm, length 1 m: 25.01 Hz at 25 degC; it falls as sqrt E(T)."""
    paper = library_material("al6061-paper")
    made = cantilever(straight(1.0, tube(0.0125, 0.001), 12, 8), paper, ends=("start", "end"))
    found = []
    for T in (298.15, 398.15):

        def field(x, T=T):
            return T + 0.0 * x[:, 0]

        found.append(made.frequencies(1, made.equilibrium(field, steps=1), field)[0])
    assert found[0] == pytest.approx(25.01, rel=5e-3)
    moduli = paper.youngs_modulus(np.array([298.15, 398.15]))
    swollen = np.sqrt(1.0 + paper.thermal_strain(np.array(398.15), COLD))
    assert found[1] / found[0] == pytest.approx(swollen * np.sqrt(moduli[1] / moduli[0]), rel=1e-3)


def test_reference_points_leave_saint_venants_stress_alone():
    """Tension and bending through a reference point: stress F/A and M z/I up to the ends."""
    made = cantilever(bar((0.1, 0.01, 0.01), (10, 2, 2)), load=(100.0, 0.0, 0.0))
    stress = made.system.elements[0].stresses(made.equilibrium().q, made.rest()[0])
    assert stress[..., 0, 0] == pytest.approx(np.full(stress.shape[:2], 1e6), rel=1e-4)
    stress[..., 0, 0] = 0.0
    assert np.abs(stress).max() < 1e2


def test_poissons_ratio_near_a_half_does_not_lock():
    """Thin bending with nu = 0.499: frequencies stay those of a beam."""
    rubber = constant_material("rubber", 1000.0, 1e7, 0.499, 1e-4, 0.2, 1500.0)
    made = cantilever(bar((1.0, 0.02, 0.02), (20, 2, 2)), rubber)
    exact = 1.8751041**2 / (2.0 * np.pi) * np.sqrt(1e7 * 4e-4 / 12.0 / 1000.0)
    assert made.frequencies(1)[0] == pytest.approx(exact, rel=3e-3)


def test_thin_bending_does_not_lock():
    """One cell through a wall 1/50 as thick as the cell is long."""
    made = cantilever(bar((1.0, 0.05, 0.001), (20, 2, 1)))
    exact = 1.8751041**2 / (2.0 * np.pi) * np.sqrt(E_MODULUS * 1e-6 / 12.0 / 2700.0)
    assert made.frequencies(1)[0] == pytest.approx(exact, rel=2e-2)  # a plate at its root


def test_thermal_buckling():
    """Both ends clamped: 4 pi^2 E I/L^2 = E A alpha dT; shear takes 1e-3."""
    mesh = bar((1.0, 0.01, 0.01), (20, 2, 1))
    body = Continuum("body", mesh.points, mesh.cells["hexahedron20"], ALUMINIUM, COLD)
    places = [point(mesh, end, f"body@{i}") for i, end in enumerate(("x0", "x1"))]
    joints = [
        Clamp("left", Site("body@0"), Site(None, position=np.zeros(3))),
        Clamp("right", Site("body@1"), Site(None, position=np.array([1.0, 0.0, 0.0]))),
    ]
    system = System(Description([body, *places], joints))
    T = np.zeros((len(system.layout.x), 3))
    T[:, 0] = COLD
    cold = system.coefficients(T)
    T[:, 0] += 100.0
    hot = system.coefficients(T)
    critical = 4.0 * np.pi**2 * 1e-4 / 12.0 / ALPHA
    found = buckling(system, cold, hot, 1)
    assert found.factors[0] * 100.0 == pytest.approx(critical, rel=3e-3)


@pytest.mark.skipif(shutil.which("ccx") is None, reason="ccx is not installed")
def test_same_as_calculix_with_the_same_mesh(tmp_path):
    """C3D20R on a distorted mesh, one face held, a force on every node of the other."""
    mesh = distorted((4, 2, 2))
    made, (loaded, area) = free(mesh), areas(mesh, "x1")
    held = areas(mesh, "x0")[0]
    load = np.array([1.0, -2.0, 3.0])
    (tmp_path / "bar.inp").write_text(_deck(mesh, held, loaded, np.outer(area, load)))
    subprocess.run(["ccx", "bar"], cwd=tmp_path, check=True, capture_output=True)
    lines = [line.split() for line in (tmp_path / "bar.dat").read_text().splitlines()]
    theirs = np.array([[float(x) for x in line[1:]] for line in lines if len(line) == 4])
    system = made.system
    y, force = system.unknowns(system.layout.q0), np.zeros((len(mesh.points), 3))
    K = system.pattern.matrix(system.matrix(y, 0.0 * y, 0.0, made.rest(), Factors(0, 1, 0)))
    force[loaded] = np.outer(area, load)
    kept = np.ones_like(force, bool)
    kept[held] = False
    kept, ours = kept.ravel(), np.zeros(force.size)
    ours[kept] = spsolve(K[kept][:, kept], force.ravel()[kept])
    assert np.abs(ours - theirs.ravel()).max() < 1e-6 * np.abs(theirs).max()


def _deck(mesh, held, loaded, forces):
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{i + 1}, {x:.12e}, {y:.12e}, {z:.12e}" for i, (x, y, z) in enumerate(mesh.points)]
    lines += ["*ELEMENT, TYPE=C3D20R, ELSET=BODY"]
    for i, cell in enumerate(mesh.cells["hexahedron20"] + 1):
        lines += [", ".join(map(str, [i + 1, *cell[:15]])) + ",", ", ".join(map(str, cell[15:]))]
    lines += [
        "*MATERIAL, NAME=M",
        "*ELASTIC",
        "69e9, 0.33",
        "*SOLID SECTION, ELSET=BODY, MATERIAL=M",
    ]
    lines += ["*BOUNDARY", *(f"{node + 1}, 1, 3" for node in held), "*STEP", "*STATIC", "*CLOAD"]
    for node, force in zip(loaded, forces, strict=True):
        lines += [f"{node + 1}, {k + 1}, {f:.12e}" for k, f in enumerate(force)]
    return "\n".join([*lines, "*NODE PRINT, NSET=ALL", "U", "*END STEP", ""])
