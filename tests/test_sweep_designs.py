"""Designs of experiments: published counts, resolutions and generators; values between units."""

import numpy as np
import pytest

from coupling.scales import scale
from coupling.sweep_tables import Design, Factor
from coupling.sweeps import designs


def factors(k: int, **given) -> list[Factor]:
    given = given or {"low": 0.0, "high": 1.0}
    return [Factor(entries=[f"body.b{i}.mass"], **given) for i in range(k)]


def points(kind: str, k: int, **given) -> np.ndarray:
    return designs.coded(Design(kind=kind, **given), factors(k))


def test_a_full_factorial_is_in_standard_order():
    """Box, Hunter & Hunter (2005), Table 5.1: - - -, + - -, - + -, + + -, ..."""
    signs = ["".join("-+"[int(x > 0)] for x in row) for row in points("full-factorial", 3)]
    assert signs == ["---", "+--", "-+-", "++-", "--+", "+-+", "-++", "+++"]


def test_levels_of_a_full_factorial():
    some = [*factors(1, levels=["a", "b", "c"]), *factors(1)]
    rows = designs.coded(Design(kind="full-factorial"), some)
    assert rows.shape == (6, 2)
    assert [some[0].value(x) for x in rows[:3, 0]] == ["a", "b", "c"]


@pytest.mark.parametrize(
    ("k", "runs", "resolution"),
    [
        (3, 4, 3), (4, 8, 4), (5, 16, 5), (5, 8, 3), (6, 32, 6), (6, 16, 4), (6, 8, 3), (7, 64, 7),
        (7, 32, 4), (7, 16, 4), (7, 8, 3), (8, 64, 5), (8, 32, 4), (8, 16, 4), (9, 128, 6),
        (9, 64, 4), (9, 32, 4), (9, 16, 3), (10, 128, 5), (10, 64, 4), (10, 32, 4), (10, 16, 3),
        (11, 128, 5), (11, 64, 4), (11, 32, 4), (11, 16, 3),
    ],
)  # fmt: skip
def test_fractions_have_the_published_resolution(k, runs, resolution):
    """Box, Hunter & Hunter (1978), Table 12.15."""
    words = designs.generators(k, runs, 0)
    assert designs.resolution(k, words) == resolution
    rows = points("fractional-factorial", k, runs=runs)
    assert rows.shape == (runs, k)
    assert np.allclose(rows.T @ rows, runs * np.eye(k)), "columns are at right angles"
    assert len(np.unique(rows, axis=0)) == runs


def test_the_smallest_fraction_of_a_resolution():
    assert len(points("fractional-factorial", 7, resolution=4)) == 16
    assert len(points("fractional-factorial", 7, resolution=3)) == 8
    with pytest.raises(ValueError, match="no fraction of 4 factors has resolution 5"):
        points("fractional-factorial", 4, resolution=5)


@pytest.mark.parametrize(("k", "count"), [(3, 12), (4, 24), (5, 40), (6, 48), (7, 56)])
def test_box_behnken_counts(k, count):
    """Box & Behnken (1960): 12, 24, 40, 48, 56 points besides the middle; balanced."""
    rows = points("box-behnken", k, centre=0)
    assert rows.shape == (count, k)
    assert len(np.unique(rows, axis=0)) == count
    assert set(np.unique(rows)) == {-1.0, 0.0, 1.0}
    assert len({*np.sum(rows != 0.0, axis=0)}) == 1, "each factor as often"
    assert np.allclose(rows.T @ rows, np.diag(np.diag(rows.T @ rows)))


def test_a_rotatable_composite_predicts_equally_well_in_all_directions():
    """The variance of the prediction depends on the distance alone (Box & Hunter 1957)."""
    rows = points("central-composite", 2, axial="circumscribed", centre=5)
    assert np.abs(rows).max() == pytest.approx(2**0.5)

    def terms(x):
        a, b = x.T
        return np.column_stack([np.ones(len(x)), a, b, a * b, a * a, b * b])

    inverse = np.linalg.inv(terms(rows).T @ terms(rows))
    angle = np.linspace(0.0, 6.0, 7)
    ring = terms(0.8 * np.column_stack([np.cos(angle), np.sin(angle)]))
    variance = np.einsum("ij,jk,ik->i", ring, inverse, ring)
    assert np.ptp(variance) < 1e-12


@pytest.mark.parametrize(("k", "count"), [(2, 9), (3, 15), (4, 25), (5, 27), (6, 45), (7, 79)])
def test_composites_stay_within_the_bounds(k, count):
    for axial in ("faced", "inscribed"):
        rows = points("central-composite", k, axial=axial)
        assert len(rows) == count
        assert np.abs(rows).max() == pytest.approx(1.0)


def test_a_latin_hypercube_has_one_point_in_each_layer():
    rows = points("latin-hypercube", 3, runs=10, seed=4)
    layers = np.floor((rows + 1.0) / 2.0 * 10).astype(int)
    assert all(sorted(column) == list(range(10)) for column in layers.T)
    assert np.array_equal(rows, points("latin-hypercube", 3, runs=10, seed=4))
    assert not np.array_equal(rows, points("latin-hypercube", 3, runs=10, seed=5))


def test_sobol_points_are_a_net():
    """Of 16 points in a plane one lies in each box of 1/16, of any shape."""
    rows = (points("sobol", 2, runs=16) + 1.0) / 2.0
    for i in range(5):
        boxes = np.floor(rows * [2**i, 2 ** (4 - i)]).astype(int)
        assert len(np.unique(boxes, axis=0)) == 16


def test_values_between_low_and_high():
    assert scale("10 um", "0.1 mm", "logarithmic").written(0.5) == "31.6227766017 um"
    assert scale("10 um", "0.1 mm", "linear").written(1.0) == "100.0 um"
    assert scale("-100 degC", "50 degC", "linear").written(0.5) == "-25.0 degC"
    assert scale("0 degC", "300 K", "linear").written(1.0) == "26.85 degC"
    assert scale(1.0, 100.0, "logarithmic").written(0.5) == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("low", "high", "course", "text"),
    [
        ("10 um", 5.0, "linear", "has a unit, the other none"),
        ("10 um", "5 s", "linear", "do not fit"),
        ("-1 m", "5 m", "logarithmic", "positive"),
        ("hot", "5 m", "linear", "expected a number"),
        ("1 m", "1000 mm", "linear", "the same"),
    ],
)
def test_values_that_have_nothing_between_them(low, high, course, text):
    with pytest.raises(ValueError, match=text):
        scale(low, high, course)
