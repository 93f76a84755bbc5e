"""Materials against the sources they were taken from, and properties against quadrature."""

from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from meshes.materials import (
    Material,
    constant,
    constant_material,
    library,
    library_material,
    polynomial,
    table,
)
from meshes.properties import DATUM, joined

LIBRARY = [(name, p) for name in library() for p in library_material(name).properties]
each_property = pytest.mark.parametrize(
    "p", [pytest.param(p, id=f"{name}-{p.name}") for name, p in LIBRARY]
)

NIST_K = (0.07918, 1.0957, -0.07277, 0.08084, 0.02803, -0.09464, 0.04179, -0.00571)
NIST_C = (46.6467, -314.292, 866.662, -1298.3, 1162.27, -637.795, 210.351, -38.3094, 2.96344)
TITANIUM_K = (-5107.8774, 19240.422, -30789.064, 27134.756, -14226.379, 4438.2154, -763.07767)
TITANIUM_K += (55.796592,)
STEEL_K = (-1.4087, 1.3982, 0.2543, -0.6260, 0.2334, 0.4256, -0.4658, 0.1650, -0.0199)
STEEL_C = (22.0061, -127.5528, 303.647, -381.0098, 274.0328, -112.9212, 24.7593, -2.239153)
INVAR_K = (-2.7064, 8.5191, -15.923, 18.276, -11.9116, 4.40318, -0.86018, 0.068508)
FITS = [
    ("al6061", "conductivity", NIST_K, 290.0),
    ("al6061", "heat_capacity", NIST_C, 250.0),
    ("steel-304", "conductivity", STEEL_K, 273.15),
    ("steel-304", "heat_capacity", STEEL_C, 273.15),
    ("titanium-6al4v", "conductivity", TITANIUM_K, 250.0),
    ("invar", "conductivity", INVAR_K, 300.0),
]


def fit(coefficients, T):
    """The NIST form, written out."""
    return 10.0 ** sum(c * np.log10(T) ** i for i, c in enumerate(coefficients))


def elongation(T):
    """NIST, 6061-T6: (L - L293) / L293."""
    return 1e-5 * (-412.77 - 0.30389 * T + 8.7696e-3 * T**2 - 9.9821e-6 * T**3)


# --- properties -----------------------------------------------------------------------------


def test_polynomial_value_derivative_integral():
    p = polynomial("p", "1", [2.0, -3.0, 0.5], reference=300.0)
    assert p(310.0) == pytest.approx(2.0 - 30.0 + 50.0)
    assert p.derivative(310.0) == pytest.approx(-3.0 + 10.0)
    assert p.integral(300.0, 310.0) == pytest.approx(20.0 - 150.0 + 500.0 / 3.0)
    assert not p.is_constant


def test_constant():
    p = constant("p", "1", 4.0)
    assert p.is_constant
    assert p(np.array([1.0, 1e4])) == pytest.approx([4.0, 4.0])
    assert p.derivative(np.array([1.0, 1e4])) == pytest.approx([0.0, 0.0])
    assert p.integral(100.0, 350.0) == pytest.approx(1000.0)
    assert (p.lower, p.upper) == (-inf, inf)


def test_a_polynomial_of_zero_slope_is_constant_too():
    assert polynomial("p", "1", [4.0, 0.0], 300.0, 200.0, 400.0).is_constant


def test_linear_table_is_interpolation():
    T, y = [100.0, 150.0, 400.0], [1.0, 3.0, -2.0]
    at = np.linspace(50.0, 500.0, 91)
    assert table("p", "1", T, y)(at) == pytest.approx(np.interp(at, T, y))


def test_smooth_table_is_the_monotone_cubic():
    T, y = [100.0, 150.0, 300.0, 400.0], [1.0, 3.0, 3.5, 10.0]
    p, reference = table("p", "1", T, y, smooth=True), PchipInterpolator(T, y)
    at = np.linspace(100.0, 400.0, 61)
    assert p(at) == pytest.approx(reference(at))
    assert p.integral(110.0, 390.0) == pytest.approx(reference.integrate(110.0, 390.0))
    assert (p.derivative(at) >= 0.0).all()


@given(
    st.lists(st.tuples(st.floats(1.0, 90.0), st.floats(-5.0, 5.0)), min_size=2, max_size=8),
    st.floats(-100.0, 900.0),
    st.floats(-100.0, 900.0),
)
def test_integral_of_a_table_is_the_trapezoidal_rule(steps, a, b):
    T = np.cumsum([step for step, _ in steps])
    y = np.array([value for _, value in steps])
    nodes = np.union1d(T, [a, b])
    nodes = nodes[(nodes >= min(a, b)) & (nodes <= max(a, b))]
    area = np.trapezoid(np.interp(nodes, T, y), nodes) * np.sign(b - a)
    assert table("p", "1", T, y).integral(a, b) == pytest.approx(area, abs=1e-9)


def test_end_values_are_kept_outside_the_range():
    p = polynomial("p", "1", [1.0, 0.01], 300.0, 250.0, 350.0)
    assert p(np.array([0.0, 250.0, 350.0, 900.0])) == pytest.approx([0.5, 0.5, 1.5, 1.5])
    assert p.derivative(np.array([249.0, 300.0, 351.0])) == pytest.approx([0.0, 0.01, 0.0])
    assert p.integral(350.0, 450.0) == pytest.approx(150.0)
    assert p.integral(150.0, 250.0) == pytest.approx(50.0)


def test_shapes_and_scalars():
    p = table("p", "1", [100.0, 200.0, 300.0], [1.0, 2.0, 4.0])
    for q in (p, constant("p", "1", 2.0), polynomial("p", "1", [1.0, 2.0])):
        for of in (q, q.derivative, lambda T, q=q: q.integral(150.0, T)):
            assert isinstance(of(120.0), float)
            assert of(np.full((3, 2), 120.0)).shape == (3, 2)
            assert of(np.empty(0)).shape == (0,)
            assert of(np.array([120, 250])) == pytest.approx([of(120.0), of(250.0)])
    assert p.integral(np.array([100.0, 150.0]), np.array([[200.0], [300.0]])).shape == (2, 2)


def test_nan_is_not_hidden():
    p = table("p", "1", [100.0, 200.0], [1.0, 2.0])
    assert np.isnan(p(np.array([nan, 150.0]))).tolist() == [True, False]


def test_join_takes_over_values_and_slopes():
    below = polynomial("p", "1", [1.0, 0.002, 1e-6], 0.0, 10.0, 300.0, "cold")
    above = table("p", "1", [290.0, 320.0, 500.0], [2.0, 2.2, 2.6], "warm")
    p = joined(below, above, 280.0, 330.0)
    cold, warm = np.linspace(0.0, 280.0, 15), np.linspace(330.0, 600.0, 15)
    assert p(cold) == pytest.approx(below(cold))
    assert p(warm) == pytest.approx(above(warm))
    for T in (280.0, 330.0):
        assert p(T - 1e-9) == pytest.approx(p(T + 1e-9), rel=1e-9)
        assert p.derivative(T - 1e-9) == pytest.approx(p.derivative(T + 1e-9), rel=1e-6)
    assert p.integral(0.0, 600.0) == pytest.approx(
        quad(p, 0.0, 600.0, points=[10.0, 280.0, 330.0, 500.0], epsabs=0.0)[0]
    )
    assert (p.lower, p.upper) == (10.0, 500.0)
    assert p.source == "to 280 K cold; from 330 K warm; a cubic in between"


@pytest.mark.parametrize(("material", "name", "coefficients", "upper"), FITS)
def test_sampled_fits_stay_on_their_formula(material, name, coefficients, upper):
    p = getattr(library_material(material), name)
    T = np.geomspace(p.lower, upper, 20_001)
    assert p(T) == pytest.approx(fit(coefficients, T), rel=2e-8)
    for a, b in ((p.lower, upper), (100.0, 101.0), (150.0, upper)):
        exact = quad(lambda T: fit(coefficients, T), a, b, epsabs=0.0, epsrel=1e-10)[0]
        assert p.integral(a, b) == pytest.approx(exact, rel=2e-8)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: table("k", "1", [300.0], [1.0]), "two or more"),
        (lambda: table("k", "1", [300.0, 400.0], [1.0]), "as many values"),
        (lambda: table("k", "1", [300.0, 300.0], [1.0, 2.0]), "increase"),
        (lambda: table("k", "1", [300.0, nan], [1.0, 2.0]), "finite"),
        (lambda: table("k", "1", [300.0, 400.0], [1.0, inf], smooth=True), "finite"),
        (lambda: polynomial("k", "1", [1.0, nan]), "finite"),
        (lambda: polynomial("k", "1", []), "needs coefficients"),
        (lambda: polynomial("k", "1", [1.0], nan), "finite reference"),
        (lambda: polynomial("k", "1", [1.0], 0.0, 400.0, 300.0), "lower < upper"),
        (lambda: polynomial("k", "1", [1.0], 0.0, nan, 300.0), "lower < upper"),
    ],
)
def test_bad_data_are_refused(make, words):
    with pytest.raises(ValueError, match=f"^k: .*{words}"):
        make()


# --- every property of the library -----------------------------------------------------------


@each_property
def test_integral_against_quadrature(p):
    knots = p.curve.knots
    for a, b in ((p.lower, p.upper), (290.0, 300.0), (150.0, 450.0)):
        inside = knots[(knots > a) & (knots < b)]
        exact = quad(p, a, b, points=inside, epsabs=0.0, limit=1000)[0]
        assert p.integral(a, b) == pytest.approx(exact, rel=1e-12)


@each_property
def test_derivative_against_differences(p):
    T = np.linspace(max(p.lower, 30.0) + 0.5, p.upper - 0.5, 997)
    differences = (p(T + 1e-3) - p(T - 1e-3)) / 2e-3
    scale = np.abs(p.derivative(T)).max()
    assert p.derivative(T) == pytest.approx(differences, abs=1e-4 * scale + 1e-12 * abs(p(300.0)))


@each_property
def test_value_and_slope_are_continuous(p):
    inner = p.curve.knots[1:-1]
    assert p(inner - 1e-9) == pytest.approx(p(inner + 1e-9), rel=1e-8)
    slopes = p.derivative(np.linspace(p.lower, p.upper, 5000)[1:-1])
    assert p.derivative(inner - 1e-9) == pytest.approx(
        p.derivative(inner + 1e-9), abs=1e-6 * np.abs(slopes).max()
    )


@each_property
def test_range_and_source_are_stated(p):
    assert 0.0 < p.lower < 293.15 < p.upper < inf
    assert len(p.source) > 15
    assert p.unit in ("Pa", "1", "1/K", "W/(m K)", "J/(kg K)")


@pytest.mark.parametrize("name", library())
def test_enthalpy_can_be_inverted(name):
    material = library_material(name)
    lower, upper = material.heat_capacity.lower, material.heat_capacity.upper
    assert material.enthalpy(DATUM) == 0.0
    assert (np.diff(material.enthalpy(np.linspace(1.0, 1000.0, 2000))) > 0.0).all()
    for T in np.linspace(lower, upper, 7):
        h = material.enthalpy(T)
        found = brentq(lambda T, h=h: material.enthalpy(T) - h, lower - 1.0, upper + 1.0)
        assert found == pytest.approx(T, abs=1e-6)


@pytest.mark.parametrize("name", library())
def test_library_materials_are_named_and_kept(name):
    assert library_material(name).name == name
    assert library_material(name) is library_material(name)


def test_unknown_material():
    with pytest.raises(ValueError, match=r"no material 'unobtainium'.*al6061-paper, al6061"):
        library_material("unobtainium")


# --- sources ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "expected", "digits"),
    [
        ("youngs_modulus", (69.58e9, 69e9, 66.13e9), 0.005e9),
        ("poissons_ratio", (0.3263, 0.33, 0.3329), 5e-5),
        ("expansion", (22.58e-6, 23.1e-6, 23.50e-6), 0.006e-6),
        ("conductivity", (91.9, 167.0, 225.4), 0.051),
        ("heat_capacity", (694.0, 896.0, 1053.0), 0.5),
    ],
)
def test_paper_material_at_its_three_temperatures(name, expected, digits):
    p = getattr(library_material("al6061-paper"), name)
    assert p(np.array([73.15, 298.15, 473.15])) == pytest.approx(expected, abs=digits)
    assert (p.lower, p.upper) == (73.15, 473.15)


def test_paper_thermal_strain_is_the_integral():
    """From 25 °C to -200 °C: integral -5.139e-3 (secant reading of the law: -5.081e-3)."""
    material = library_material("al6061-paper")
    assert material.thermal_strain(73.15, 298.15) == pytest.approx(-5.139e-3, abs=5e-7)
    assert material.density == 2700.0


def test_al6061_check_numbers_of_nist():
    m = library_material("al6061")
    T = np.array([100.0, 200.0])
    assert m.conductivity(T) == pytest.approx([97.701, 136.025], abs=6e-4)
    assert m.heat_capacity(T) == pytest.approx([492.20, 835.24], abs=6e-3)
    assert m.youngs_modulus(T) == pytest.approx([76.611e9, 73.559e9], abs=1e6)
    from_293 = m.thermal_strain(T, 293.0)
    assert from_293 == pytest.approx([-3.65445e-3, -2.02621e-3], abs=5e-7)
    assert m.thermal_strain(200.0, 100.0) == pytest.approx(
        elongation(200.0) - elongation(100.0), rel=1e-12
    )


def test_al6061_check_numbers_of_eurocode():
    m = library_material("al6061")
    T = 273.15 + np.array([100.0, 150.0, 200.0])
    assert m.youngs_modulus(T) == pytest.approx([67.9e9, 65.1e9, 60.2e9])
    assert m.conductivity(T) == pytest.approx([197.0, 200.5, 204.0])
    assert m.heat_capacity(T) == pytest.approx([944.0, 964.5, 985.0])
    strain = [1e-8 * t**2 + 22.5e-6 * t for t in (100.0, 200.0)]
    assert m.thermal_strain(T[2], T[0]) == pytest.approx(strain[1] - strain[0])


def test_al6061_elongation_across_the_join_stays_close_to_eurocode():
    """EN 1999-1-2 counts from 20 °C: 2.45e-3 at 120 °C; NIST's smaller alpha takes 1 % off."""
    m = library_material("al6061")
    strain = 1e-8 * 120**2 + 22.5e-6 * 120 - 4.5e-4
    strain -= 1e-8 * 20**2 + 22.5e-6 * 20 - 4.5e-4
    assert m.thermal_strain(393.15, 293.15) == pytest.approx(strain, rel=0.01)


@pytest.mark.parametrize("name", ["al6061", "steel-304"])
def test_joins_do_not_overshoot(name):
    m = library_material(name)
    T = np.linspace(100.0, 650.0, 5501)
    assert (np.diff(m.youngs_modulus(T)) < 0.0).all()
    for p in (m.conductivity, m.heat_capacity, m.expansion):
        assert (np.diff(p(T)) > 0.0).all()


def test_steel_between_its_sources():
    m = library_material("steel-304")
    assert m.conductivity(77.0) == pytest.approx(7.921, abs=1e-3)
    assert m.youngs_modulus(293.15) == pytest.approx(200e9, rel=0.005)
    assert m.heat_capacity(773.15) == pytest.approx(450 + 140 - 72.75 + 16.75)
    warm = [1e-6 * (16 + 4.79e-3 * t - 1.243e-6 * t * t) * (t - 20) for t in (150.0, 500.0)]
    assert m.thermal_strain(773.15, 423.15) == pytest.approx(warm[1] - warm[0])


@pytest.mark.parametrize(
    ("name", "celsius", "mean", "error"),
    [
        ("steel-304", 100.0, 16.0e-6, 0.02),  # EN 10088-1
        ("titanium-6al4v", 100.0, 8.6e-6, 0.01),
        ("titanium-6al4v", 315.0, 9.2e-6, 0.01),
        ("invar", 100.0, 1.5e-6, 0.1),
        ("invar", 200.0, 2.6e-6, 0.05),
    ],
)
def test_mean_expansion_from_20_celsius(name, celsius, mean, error):
    strain = library_material(name).thermal_strain(273.15 + celsius, 293.15)
    assert strain / (celsius - 20.0) == pytest.approx(mean, rel=error)


# --- materials --------------------------------------------------------------------------------


def test_shear_modulus():
    m = constant_material("m", 2700.0, 70e9, 0.25, 2e-5, 200.0, 900.0)
    assert m.shear_modulus(300.0) == pytest.approx(28e9)
    assert m.shear_modulus(np.array([200.0, 300.0])) == pytest.approx([28e9, 28e9])


def test_constant_material():
    m = constant_material("m", 2700.0, 70e9, 0.25, 2e-5, 200.0, 900.0)
    assert all(p.is_constant for p in m.properties)
    assert m.thermal_strain(np.array([280.0, 310.0]), 300.0) == pytest.approx([-4e-4, 2e-4])
    assert m.enthalpy(299.15) == pytest.approx(900.0)
    assert m.range_problems(0.0, 1e5) == []


def test_range_problems_name_property_and_ends():
    m = library_material("al6061-paper")
    assert m.range_problems(73.15, 473.15) == []
    problems = m.range_problems(73.15, 500.0)
    assert len(problems) == 5
    assert problems[0] == "youngs_modulus: needed from 73.15 K to 500 K, its data end at 473.15 K"
    assert m.range_problems(50.0, 500.0)[3] == (
        "conductivity: needed from 50 K to 500 K, its data begin at 73.15 K and end at 473.15 K"
    )


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"density": 0.0}, "density must be positive"),
        ({"density": nan}, "density must be positive"),
        ({"youngs_modulus": -1.0}, "youngs_modulus must be positive"),
        ({"conductivity": 0.0}, "conductivity must be positive"),
        ({"heat_capacity": -900.0}, "heat_capacity must be positive"),
        ({"poissons_ratio": 0.5}, "poissons_ratio must stay between"),
    ],
)
def test_impossible_constants(change, words):
    good = {
        "density": 2700.0,
        "youngs_modulus": 70e9,
        "poissons_ratio": 0.33,
        "expansion": -1e-6,
        "conductivity": 200.0,
        "heat_capacity": 900.0,
    }
    with pytest.raises(ValueError, match=f"material m: {words}"):
        constant_material("m", **{**good, **change})


def test_a_modulus_that_reaches_zero_inside_its_range():
    m = library_material("al6061-paper")
    modulus = polynomial("youngs_modulus", "Pa", [70e9, -1e9], 300.0, 200.0, 400.0)
    with pytest.raises(ValueError, match="youngs_modulus must be positive in its whole range"):
        Material("m", 2700.0, modulus, *m.properties[1:])
