"""Formulas that the sections on hinges and mast compare with, and both cases against them."""

import numpy as np
import pytest

from coupling.paper import hinges, mast
from coupling.paper.workshop import CASES, Workshop
from meshes.materials import library_material

ROOM = hinges.ROOM


def test_curvature_of_two_layers():
    """Least energy of two bonded layers of the same thickness, over strain and curvature."""
    T, half = ROOM + 105.0, 0.5 * hinges.LEAF
    E = [float(library_material(name).youngs_modulus(T)) for name in ("al6061", "invar")]
    free = [float(library_material(name).thermal_strain(T, ROOM)) for name in ("al6061", "invar")]
    A, b = np.zeros((2, 2)), np.zeros(2)
    for layer, (low, high) in enumerate([(0.0, half), (-half, 0.0)]):
        x, w = np.polynomial.legendre.leggauss(4)
        y = 0.5 * (low + high) + 0.5 * (high - low) * x
        for place, weight in zip(y, 0.5 * (high - low) * w, strict=True):
            shape = np.array([1.0, place])
            A += E[layer] * weight * np.outer(shape, shape)
            b += E[layer] * weight * free[layer] * shape
    assert hinges.bimetal_curvature(T) == pytest.approx(np.linalg.solve(A, b)[1], rel=1e-9)


def test_turn_of_a_leaf_on_a_spring():
    """Two unknowns of a cubic, by least energy: a leaf of unit curvature."""
    E, L = float(library_material("al6061").youngs_modulus(ROOM)), hinges.LENGTH
    EI = E * hinges.SECOND_MOMENT
    for stiffness, key in ((0.0, 1), (1e12, 3), (hinges.SPRING, 4)):
        # v = a x^2 + b x^3: energy EI/2 int (v'' - 1)^2 + k/2 v(L)^2
        A = EI * np.array([[4 * L, 6 * L**2], [6 * L**2, 12 * L**3]])
        end = np.array([L**2, L**3])
        a, b = np.linalg.solve(A + stiffness * np.outer(end, end), EI * np.array([2 * L, 3 * L**2]))
        turn = 2 * a * L + 3 * b * L**2
        assert turn / L == pytest.approx(hinges.held()[key], abs=1e-5)


def test_pressure_on_a_line_carries_the_force():
    force = 54.0
    metal = library_material("al6061")
    E = float(metal.youngs_modulus(293.15)) / (2 * (1 - float(metal.poissons_ratio(293.15)) ** 2))
    R = mast.PIN * mast.BUSH / (mast.BUSH - mast.PIN)
    half = np.sqrt(4 * force * R / (np.pi * E * mast.PRESSED))
    carried = 0.5 * np.pi * half * mast.PRESSED * mast.line_pressure(force)
    assert carried == pytest.approx(force, rel=1e-9)
    assert half < 0.1 * mast.PIN  # or the faces would not be flat


def test_errors_of_table_6(tmp_path):
    entry = mast._errors(mast._table(Workshop(tmp_path)))
    assert entry.verdict.startswith("reproduced")
    assert entry.inputs.startswith("0.165, 4.620, 14.439, 1.700")


def test_gradients_as_printed_are_refused(tmp_path):
    entry = hinges._refused(Workshop(tmp_path))
    assert entry.inputs.count("refused") == 3


@pytest.mark.slow
def test_leaves_bend_as_a_formula_says(tmp_path):
    """10 s of the pentagonal hinge: it has come to rest to a few per cent of the angle."""
    wanted = {f"a{i}": f"probe.arm_{i}.rz" for i in hinges.held()}
    ran = Workshop(tmp_path, CASES).run("hinge_pentagonal", (), {"time.end": 10.0}, wanted)
    alpha = float(library_material("al6061").expansion(ROOM))
    for i, part in hinges.held().items():
        turn = np.ravel(ran.values[f"a{i}"])[ran.times > 4.0].mean()
        assert turn == pytest.approx(-part * alpha * 1e3 * hinges.LENGTH, rel=0.01, abs=1e-8)
