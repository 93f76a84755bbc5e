"""Weight, loads on faces, damping and mass of solids against closed forms; stress at points."""

from dataclasses import replace

import numpy as np
import pytest
from continuum_cases import ALUMINIUM, COLD, Held, bar, cantilever, distorted, free, point

from mechanics.check import check
from mechanics.continuum import von_mises
from mechanics.description import Clamp, Continuum, Description, Particle, Site, Traction
from mechanics.dynamics import Control
from mechanics.modes import modes
from mechanics.schemes import Scheme
from mechanics.solver import Mechanics
from mechanics.system import System
from meshes.materials import constant_material, library_material

E, NU, RHO = 69e9, 0.33, 2700.0
X, Y, Z = np.eye(3)
G = 9.81


def faces(mesh, region):
    family, members = mesh.regions[region]
    return mesh.cells[family][members]


def held(mesh, loads=(), gravity=(0.0, 0.0, 0.0), element="hexahedron20", **options):
    """Clamped at the middle of the face x0, with a reference point on x1."""
    cells = mesh.cells[element.removesuffix("-full")]
    material = options.pop("material", ALUMINIUM)
    body = Continuum("body", mesh.points, cells, material, COLD, element, **options)
    places = [point(mesh, "x0", "body@0"), point(mesh, "x1", "body@1")]
    root = mesh.points[places[0].nodes]
    centre = places[0].weights @ root / places[0].weights.sum()
    joints = [Clamp("wall", Site("body@0"), Site(None, position=centre))]
    system = System(Description([body, *places], joints, list(loads), np.asarray(gravity)))
    return Held(system, system.layout.node_dofs["body@1"][0])


def stresses(made, found):
    return made.system.elements[0].stresses(found.q, made.rest()[0])


# -- weight --------------------------------------------------------------------------------------


def test_a_hanging_bar_is_stretched_by_its_weight():
    """ρ g L²/(2 E), and the stress ρ g (L - x) at every point of quadrature."""
    made = held(bar((1.0, 0.05, 0.05), (10, 2, 2)), gravity=(1e3 * G, 0.0, 0.0))
    found = made.equilibrium()
    weight = RHO * 1e3 * G
    assert made.at_tip(found.q)[0, 0] - 1.0 == pytest.approx(0.5 * weight / E, rel=1e-3)
    body = made.system.layout.bodies["body"]
    centres = body.points[body.cells].mean(axis=1)[:, 0]
    for middle in 0.1 * np.arange(10) + 0.05:
        mine = np.abs(centres - middle) < 0.02
        sigma = stresses(made, found)[mine][..., 0, 0].mean()
        assert sigma == pytest.approx(weight * (1.0 - middle), rel=2e-3)


def test_a_cantilever_bends_under_its_weight():
    """q L⁴/(8 E I) and shear q L²/(2 κ G A), κ of a rectangle after Cowper."""
    h = 0.05
    made = held(bar((1.0, h, h), (16, 2, 2)), gravity=(0.0, 0.0, -G))
    sag = -made.at_tip(made.equilibrium().q)[0, 2]
    q, inertia, kappa = RHO * G * h**2, h**4 / 12.0, 10.0 * (1 + NU) / (12.0 + 11.0 * NU)
    expected = q / (8.0 * E * inertia) + q / (2.0 * kappa * E / (2.0 * (1.0 + NU)) * h**2)
    assert sag == pytest.approx(expected, rel=5e-4)


def test_a_suspended_weight_is_the_reaction():
    """The multipliers of the clamp carry all of the weight."""
    made = held(bar((0.4, 0.1, 0.1), (4, 2, 2)), gravity=(0.0, 0.0, -G))
    found = made.equilibrium()
    y = np.concatenate([found.q, found.lam])
    pull = made.system.constraint_force(y, 1.0, made.rest())
    total = pull[: 3 * len(made.system.layout.bodies["body"].points)].reshape(-1, 3).sum(axis=0)
    assert np.abs(total) == pytest.approx([0.0, 0.0, RHO * 0.004 * G], abs=1e-6)


# -- loads on faces ------------------------------------------------------------------------------


@pytest.mark.parametrize("element", ["hexahedron20", "hexahedron20-full", "hexahedron27"])
def test_a_pulled_face_of_any_mesh_stretches_evenly(element):
    """Cells of unlike shape: σ = p at every point, which inconsistent loads would not give."""
    mesh = distorted((4, 2, 2), (0.4, 0.1, 0.1), 0.01, element.removesuffix("-full"))
    pull = Traction("pull", "body", X, lambda t: 1e6 * t, faces=faces(mesh, "x1"))
    made = held(mesh, [pull], element=element)
    found = made.equilibrium()
    sigma = stresses(made, found)
    assert sigma[..., 0, 0] == pytest.approx(1e6, rel=1e-4)
    assert von_mises(sigma) == pytest.approx(1e6, rel=1e-4)
    assert made.at_tip(found.q)[0, 0] - 0.4 == pytest.approx(0.4e6 / E, rel=1e-4)


def test_pressure_on_a_beam():
    """p b on its upper face bends like a line load."""
    h, p = 0.05, 1e3
    mesh = bar((1.0, h, h), (16, 2, 2))
    load = Traction("p", "body", -Z, lambda t: p * t, faces=faces(mesh, "z1"))
    sag = -(made := held(mesh, [load])).at_tip(made.equilibrium().q)[0, 2]
    inertia, kappa = h**4 / 12.0, 10.0 * (1 + NU) / (12.0 + 11.0 * NU)
    expected = p * h / (8.0 * E * inertia) + p * h / (2.0 * kappa * E / (2.0 * (1.0 + NU)) * h**2)
    assert sag == pytest.approx(expected, rel=1e-3)


def test_loads_that_a_body_cannot_carry_are_refused():
    mesh = bar((0.2, 0.1, 0.1), (2, 2, 1))
    body = Continuum("body", mesh.points, mesh.cells["hexahedron20"], ALUMINIUM, COLD)
    pull = Traction("pull", "body", X, lambda t: t, faces=faces(mesh, "x1"))
    every = [
        (replace(pull, faces=None), "it needs the faces of 'body'"),
        (replace(pull, edge=[0, 1]), "not of an edge"),
        (replace(pull, faces=np.zeros((1, 4), int)), "with 8 nodes each"),
        (replace(pull, faces=np.full((1, 8), 10**6)), "its faces others"),
        (replace(pull, body="ball"), "neither shell nor solid"),
        (replace(pull, body="nobody"), "no body 'nobody'"),
    ]
    for load, words in every:
        found = check(Description([body, Particle("ball", X, 1.0)], loads=[load]))
        assert len(found) == 1 and words in found[0], (found, words)
    assert check(Description([body], loads=[pull])) == []


# -- damping, mass that follows temperature ------------------------------------------------------


def test_a_mode_decays_as_the_rayleigh_factors_say():
    """ζ = α_M/(2 ω) + α_K ω/2 of the first bending mode, from the work of one slow motion."""
    factors, mesh = (2.0, 3e-6), bar((1.0, 0.05, 0.05), (8, 2, 1))
    body = Continuum("body", mesh.points, mesh.cells["hexahedron20"], ALUMINIUM, COLD)
    joints = [Clamp("wall", Site("body@0"), Site(None, position=np.zeros(3)))]
    told = Description([body, point(mesh, "x0", "body@0")], joints, rayleigh=factors)
    system = System(told)
    made, n = Held(system, 0), system.n
    q, coef = system.layout.q0, made.rest()
    found = modes(system, q, np.zeros(system.m), coef, 1)
    w, phi = 2.0 * np.pi * found.frequencies[0], found.shapes[:, 0]
    y, v = system.unknowns(q), np.concatenate([phi, np.zeros(system.m)])
    pull = system.residual(y, v, 0.0, coef)[:n] - system.residual(y, 0.0 * v, 0.0, coef)[:n]
    ratio = factors[0] / (2.0 * w) + 0.5 * factors[1] * w
    assert phi @ pull == pytest.approx(2.0 * ratio * w, rel=1e-6)
    # and in motion: energy falls by exp(-4 pi ζ) in each period
    solver = Mechanics(told, Control(np.inf, h := 1.0 / (100.0 * found.frequencies[0]), h,
                                     Scheme(alpha=0.0)))  # fmt: skip
    T = np.tile([COLD, 0.0, 0.0], (len(solver.x), 1))
    state = solver.initial(T)
    amplitude = 1e-4 / np.abs(phi).max()
    state = state._replace(motion=state.motion._replace(v=amplitude * w * phi))
    energies = []
    for _ in range(4):
        state, _, why = solver.advance(state, 100.0 * h, T, T)
        assert why == ""
        energies.append(state.ledger[0] + state.ledger[1])
    decay = -np.polyfit(np.arange(4), np.log(energies), 1)[0] / (4.0 * np.pi)
    assert decay == pytest.approx(ratio, rel=0.02)


def test_mass_follows_the_density_law_cell_by_cell():
    """Half of a bar is warm: its cells are lighter by the ratio of the densities."""
    paper = library_material("al6061-paper")
    mesh = bar((0.4, 0.1, 0.1), (4, 2, 1))
    body = Continuum("body", mesh.points, mesh.cells["hexahedron20"], paper, 298.15,
                     velocity=3.0 * X)  # fmt: skip
    for asked in (False, True):
        solver = Mechanics(Description([body], heavy_when_cold=asked), Control(1e-4, 1e-2, 1e-9))
        T = np.tile([298.15, 0.0, 0.0], (len(solver.x), 1))
        hot = T + np.array([60.0, 0.0, 0.0])
        state = solver.initial(T)
        before = state.ledger[0]
        assert before == pytest.approx(0.5 * paper.density * 0.004 * 9.0, rel=1e-9)
        for start, end in ((T, hot), (hot, hot)):
            state, _, why = solver.advance(state, 0.02, start, end)
            assert why == ""
        p = solver.system.packed_at(hot)
        ratio = _mass(solver.system, p) / (paper.density * 0.004)
        factor = float(paper.density_factor(np.array(358.15))) if asked else 1.0
        assert ratio == pytest.approx(factor, rel=1e-9)
        x = solver.x[:, 0]
        uneven = T.copy()
        uneven[x > 0.25, 0] += 60.0
        between = _mass(solver.system, solver.system.packed_at(uneven)) / (paper.density * 0.004)
        assert (between == pytest.approx(1.0, rel=1e-12)) is not asked


def _mass(system, packed):
    from mechanics.march import inertia

    out, shift = np.empty(system.n), np.zeros(system.n)
    shift[system.layout.node_dofs["body"]] = 1.0
    inertia(packed, shift, out)
    return shift @ out


# -- stress --------------------------------------------------------------------------------------


def test_equivalent_stress_of_bending_and_torsion():
    """√(σ² + 3 τ²): M z/I along and, in a square bar, the shear of Saint Venant."""
    h = 0.01
    made = cantilever(bar((0.1, h, h), (10, 2, 2)), load=(0.0, 0.0, -10.0))
    found = made.equilibrium()
    sigma = stresses(made, found)
    body = made.system.layout.bodies["body"]
    middle = np.abs(body.points[body.cells].mean(axis=1)[:, 0] - 0.055) < 1e-3
    # resultants of one slice: moment of the force about it, and the force itself
    volumes = made.system.elements[0].volumes[middle]
    shear = np.sum(volumes * sigma[middle][..., 0, 2]) / 0.01
    assert shear == pytest.approx(-10.0, rel=1e-3)
    assert von_mises(sigma)[middle].max() == pytest.approx(
        10.0 * 0.045 * (h / 4 * (1 + 1 / np.sqrt(3))) / (h**4 / 12.0), rel=0.07
    )


def test_pressure_all_round_has_no_equivalent_stress():
    mesh = distorted((2, 2, 2), (0.2, 0.2, 0.2), 0.01)
    made = free(mesh)
    shrunk = made.system.layout.q0 * (1.0 - 1e-5)
    sigma = made.system.elements[0].stresses(shrunk, made.rest()[0])
    bulk = E / (3.0 * (1.0 - 2.0 * NU))
    assert np.trace(sigma, axis1=-2, axis2=-1) / 3.0 == pytest.approx(-3e-5 * bulk, rel=1e-4)
    assert von_mises(sigma).max() < 1e-9 * bulk


def test_a_constant_material_has_no_density_law():
    plain = constant_material("plain", RHO, E, NU, 23e-6, 150.0, 900.0)
    mesh = bar((0.2, 0.1, 0.1), (2, 2, 1))
    body = Continuum("body", mesh.points, mesh.cells["hexahedron20"], plain, COLD)
    system = System(Description([body], heavy_when_cold=True))
    T = np.tile([COLD + 100.0, 0.0, 0.0], (len(system.layout.x), 1))
    assert _mass(system, system.packed_at(T)) == pytest.approx(RHO * 0.002, rel=1e-12)
