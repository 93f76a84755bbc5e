"""Sections against integrals over their area and published values."""

from math import inf, nan, pi

import numpy as np
import pytest
from scipy.integrate import dblquad

from meshes.sections import Section, circle, general, rectangle, tube


def test_tube_numbers_of_the_thin_boom():
    section = tube(0.27, 0.002)
    assert section.area == pytest.approx(3.393e-3, rel=5e-4)
    assert section.second_moment_2 == pytest.approx(1.2367e-4, rel=5e-5)
    assert section.outer_perimeter == pytest.approx(2 * pi * 0.271)
    assert (section.radius, section.thickness) == (0.27, 0.002)
    assert section.height == section.width == pytest.approx(0.542)


@pytest.mark.parametrize("ratio", [1e-6, 0.1, 1.0, 1.999])
def test_tube_is_the_exact_annulus(ratio):
    section = tube(0.3, 0.3 * ratio)
    outer, inner = 0.3 + 0.15 * ratio, 0.3 - 0.15 * ratio
    cancellation = 1e-15 / ratio
    assert section.area == pytest.approx(pi * (outer**2 - inner**2), rel=1e-12 + cancellation)
    assert section.second_moment_3 == pytest.approx(
        pi / 4 * (outer**4 - inner**4), rel=1e-12 + cancellation
    )
    assert section.torsion_constant == pytest.approx(section.polar_moment)


def test_rectangle_moments_by_quadrature():
    height, width = 0.3, 0.1
    section = rectangle(height, width)
    limits = (-width / 2, width / 2, -height / 2, height / 2)
    assert section.second_moment_2 == pytest.approx(dblquad(lambda y, z: y * y, *limits)[0])
    assert section.second_moment_3 == pytest.approx(dblquad(lambda y, z: z * z, *limits)[0])
    assert section.second_moment_2 > section.second_moment_3
    assert section.outer_perimeter == pytest.approx(0.8)


@pytest.mark.parametrize(("ratio", "factor"), [(1, 0.1406), (2, 0.229), (5, 0.291), (10, 0.312)])
def test_rectangle_torsion_table(ratio, factor):
    """Timoshenko & Goodier (1970), Art. 109, k1 of J = k1 a b^3."""
    assert rectangle(0.01 * ratio, 0.01).torsion_constant == pytest.approx(
        factor * ratio * 1e-8, rel=3e-3
    )


@pytest.mark.parametrize(("height", "width"), [(1.0, 1.0), (0.4, 1.0), (3.0, 0.5)])
def test_rectangle_torsion_by_double_fourier_series(height, width):
    """Prandtl's stress function as a double sine series, which converges independently."""
    m, n = np.meshgrid(np.arange(1, 1001, 2), np.arange(1, 1001, 2))
    terms = 1.0 / (m**2 * n**2 * ((m / height) ** 2 + (n / width) ** 2))
    reference = 256.0 / pi**6 * height * width * terms.sum()
    assert rectangle(height, width).torsion_constant == pytest.approx(reference, rel=1e-7)


def test_thin_strip_torsion_does_not_overflow():
    assert rectangle(1.0, 1e-6).torsion_constant == pytest.approx(1e-18 / 3, rel=1e-5)


def _flexure(nu, a, b):
    """Cowper's harmonic function for flexure along x of a hollow circle, radii a > b."""

    def chi(r, angle):
        radial = -(3 + 2 * nu) / 4 * ((a * a + b * b) * r + a * a * b * b / r)
        return radial * np.cos(angle) + r**3 / 4 * np.cos(3 * angle)

    return chi


@pytest.mark.parametrize("nu", [0.0, 0.33])
def test_flexure_function_meets_its_boundary_condition(nu):
    """Cowper (1966), eq. 15: what the next test integrates solves Saint-Venant's problem."""
    chi, angle = _flexure(nu, 1.0, 0.6), np.linspace(0, 2 * pi, 13)
    for r, outward in ((1.0, 1.0), (0.6, -1.0)):
        x, y = r * np.cos(angle), r * np.sin(angle)
        nx, ny = outward * np.cos(angle), outward * np.sin(angle)
        slope = outward * (chi(r + 1e-6, angle) - chi(r - 1e-6, angle)) / 2e-6
        required = -nx * (nu * x * x / 2 + (1 - nu / 2) * y * y) - ny * (2 + nu) * x * y
        assert slope == pytest.approx(required, abs=1e-8)


@pytest.mark.parametrize("thickness", [0.05, 0.4, 1.2])
@pytest.mark.parametrize("nu", [0.0, 0.33])
def test_tube_shear_factor_by_cowpers_integral(thickness, nu):
    """Cowper (1966), eq. 20, by quadrature over the annulus."""
    section = tube(1.0, thickness, nu)
    a, b = 1.0 + thickness / 2, 1.0 - thickness / 2
    chi = _flexure(nu, a, b)

    def integrand(angle, r):
        x, y = r * np.cos(angle), r * np.sin(angle)
        return x * (chi(r, angle) + x * y * y) * r

    integral = dblquad(integrand, b, a, 0.0, 2 * pi)[0]
    second_moment = section.second_moment_2
    factor = -2 * (1 + nu) * second_moment**2 / (section.area * integral)
    assert section.shear_factor_2 == pytest.approx(factor, rel=1e-8)
    assert section.shear_factor_3 == section.shear_factor_2


def test_shear_factors_of_table_1():
    """Cowper (1966): thin tube, circle, and rectangle at nu = 0, where it is Timoshenko's 5/6."""
    nu = 0.3
    assert tube(1.0, 1e-5, nu).shear_factor_2 == pytest.approx(2 * (1 + nu) / (4 + 3 * nu))
    assert circle(0.1, nu).shear_factor_2 == pytest.approx(6 * (1 + nu) / (7 + 6 * nu))
    assert rectangle(0.1, 0.2, 0.0).shear_factor_2 == pytest.approx(5 / 6)
    assert rectangle(0.1, 0.2, nu).shear_factor_3 == pytest.approx(13 / 15.3)


def test_circle_is_a_tube_without_bore():
    solid, closed = circle(0.1), tube(0.05, 0.1 - 1e-12)
    for name in ("area", "second_moment_2", "torsion_constant", "shear_factor_2", "height"):
        assert getattr(solid, name) == pytest.approx(getattr(closed, name))


def test_general_section_falls_back_on_the_equal_rectangle():
    box = rectangle(0.2, 0.1)
    same = general(box.area, box.second_moment_2, box.second_moment_3, box.torsion_constant)
    assert (same.height, same.width) == pytest.approx((0.2, 0.1))
    assert same.outer_perimeter == pytest.approx(box.outer_perimeter)
    told = general(1.0, 1.0, 1.0, 1.0, outer_perimeter=7.0, height=2.0, width=3.0)
    assert (told.outer_perimeter, told.height, told.width) == (7.0, 2.0, 3.0)


def _area(outline):
    y, z = outline.T
    return 0.5 * np.sum(y * np.roll(z, -1) - z * np.roll(y, -1))


@pytest.mark.parametrize("section", [tube(0.1, 0.02), circle(0.11)])
def test_round_outline(section):
    outline = section.outline(360)
    assert np.hypot(*outline.T) == pytest.approx(0.11)
    assert outline[0] == pytest.approx([0.11, 0.0])
    assert outline[90] == pytest.approx([0.0, 0.11])
    assert _area(outline) == pytest.approx(pi * 0.11**2, rel=1e-4)


@pytest.mark.parametrize("n", [4, 5, 6, 7, 8, 23])
def test_rectangle_outline_keeps_its_corners(n):
    outline = rectangle(0.3, 0.1).outline(n)
    assert outline.shape == (n, 2)
    assert _area(outline) == pytest.approx(0.03)
    assert len(np.unique(np.round(outline, 12), axis=0)) == n


@pytest.mark.parametrize(("section", "n"), [(circle(1.0), 2), (rectangle(1.0, 1.0), 3)])
def test_outline_of_too_few_points(section, n):
    with pytest.raises(ValueError, match="at least"):
        section.outline(n)


@pytest.mark.parametrize("bad", [0.0, -1.0, nan, inf])
@pytest.mark.parametrize(
    ("make", "arguments"),
    [
        (tube, {"mean_radius": 0.1, "thickness": 0.01}),
        (circle, {"radius": 0.1}),
        (rectangle, {"height": 0.1, "width": 0.1}),
        (
            general,
            {
                "area": 1.0,
                "second_moment_2": 1.0,
                "second_moment_3": 1.0,
                "torsion_constant": 1.0,
                "shear_factor_2": 1.0,
                "shear_factor_3": 1.0,
                "outer_perimeter": 1.0,
                "height": 1.0,
                "width": 1.0,
            },
        ),
    ],
)
def test_impossible_numbers_are_named(make, arguments, bad):
    for name in arguments:
        with pytest.raises(ValueError, match=f"{name} must be positive and finite"):
            make(**{**arguments, name: bad})


def test_wall_thicker_than_the_tube():
    with pytest.raises(ValueError, match="no bore"):
        tube(0.1, 0.2)


@pytest.mark.parametrize("nu", [-1.0, 0.51, nan])
@pytest.mark.parametrize("make", [lambda nu: tube(1, 0.1, nu), lambda nu: circle(1, nu)])
def test_impossible_poissons_ratio(make, nu):
    with pytest.raises(ValueError, match="poissons_ratio"):
        make(nu)


def test_sections_compare_and_hash_by_value():
    assert tube(0.27, 0.002) == tube(0.27, 0.002)
    assert isinstance(hash(circle(0.1)), int)
    assert isinstance(circle(0.1), Section)
