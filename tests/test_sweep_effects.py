"""Effects of published experiments, and of responses that are made."""

import numpy as np
import pytest

from coupling.sweeps import designs, effects


def by_factors(found):
    return {e.factors: e.size for e in found}


def test_the_pilot_plant():
    """Box, Hunter & Hunter (2005), Table 5.3: temperature, concentration, catalyst on yield."""
    y = np.array([60.0, 72.0, 54.0, 68.0, 52.0, 83.0, 45.0, 80.0])
    found = by_factors(effects.effects(designs.corners(3), y))
    assert found == pytest.approx(
        {(0,): 23.0, (1,): -5.0, (2,): 1.5, (0, 1): 1.5, (0, 2): 10.0, (1, 2): 0.0,
         (0, 1, 2): 0.5}
    )  # fmt: skip


def test_the_reactor_and_its_half():
    """Box, Hunter & Hunter (2005), Tables 6.1 and 6.2: the half fraction tells the same."""
    y = np.array([
        61, 53, 63, 61, 53, 56, 54, 61, 69, 61, 94, 93, 66, 60, 95, 98,
        56, 63, 70, 65, 59, 55, 67, 65, 44, 45, 78, 77, 49, 42, 81, 82.0,
    ])  # fmt: skip
    whole = by_factors(effects.effects(designs.corners(5), y))
    rounded = {(1,): 19.5, (3,): 10.75, (4,): -6.25, (1, 3): 13.25, (3, 4): -11.0, (0,): -1.375}
    assert {key: whole[key] for key in rounded} == pytest.approx(rounded)
    half = designs.fraction(5, ("ABCD",))
    rows = [int(sum(2**i * (x > 0) for i, x in enumerate(row))) for row in half]
    told = effects.effects(half, y[rows])
    assert len(told) == 15
    said = by_factors(told)
    assert said[(1,)] == pytest.approx(20.5)
    assert said[(3,)] == pytest.approx(12.25)
    assert said[(3, 4)] == pytest.approx(-9.5)
    for effect in told:
        added = whole[effect.factors] + sum(
            (-1.0 if turned else 1.0) * whole[word] for word, turned in effect.aliases
        )
        assert effect.size == pytest.approx(added), "an effect and what it cannot be told from"


def test_a_fraction_with_a_negative_generator_keeps_signs():
    """Seen with D = -ABC: effects of a response that is linear are twice its coefficients."""
    half = designs.fraction(4, ("ABC",)) * [1, 1, 1, -1]
    y = half @ [1.0, 2.0, -3.0, 4.0]
    found = effects.effects(half, y)
    assert by_factors(found)[(3,)] == pytest.approx(8.0)
    aliases = {e.factors: dict(e.aliases) for e in found}
    assert aliases[(3,)] == {(0, 1, 2): True}


def test_missing_points_give_no_effects():
    y = np.array([1.0, 2.0, np.nan, 4.0])
    assert effects.effects(designs.corners(2), y) == []


def test_which_designs_have_two_levels():
    assert effects.is_two_level(designs.corners(3))
    assert effects.is_two_level(np.vstack([designs.corners(2), np.zeros((2, 2))]))
    assert not effects.is_two_level(designs.central_composite(2, "faced", 1))
    assert not effects.is_two_level(designs.spread("latin-hypercube", 2, 8, 1))


def test_the_margin_of_lenth():
    """By hand: median 0.15, of those below 2.5 x 0.225 again 0.15; 0.225 times Student's 2.571."""
    sizes = np.array([0.13, -0.15, 0.30, 0.15, 0.40, -0.03, 0.38, 0.15, -0.05, 0.43, 0.13, 0.13,
                      -0.38, 2.15, 3.10])  # fmt: skip
    assert effects.margin(sizes) == pytest.approx(0.225 * 2.5706, rel=1e-4)


def test_a_quadratic_response_is_found_exactly():
    rng = np.random.default_rng(3)
    coded = designs.box_behnken(3, 2)
    true = rng.normal(size=10)
    terms = [(), (0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 0), (1, 1), (2, 2)]
    y = effects.products(coded, terms) @ true
    made, why = effects.surface(coded, y)
    assert why == ""
    assert made.terms == tuple(terms)
    assert made.coefficients == pytest.approx(true)
    assert made.r2 == pytest.approx(1.0)
    assert made.q2 == pytest.approx(1.0)


def test_leaving_points_out_one_by_one():
    rng = np.random.default_rng(5)
    coded = designs.spread("latin-hypercube", 2, 14, 1)
    y = np.exp(coded[:, 0]) * np.cos(2.0 * coded[:, 1]) + 0.1 * rng.normal(size=14)
    made, _ = effects.surface(coded, y)
    missed = 0.0
    for i in range(14):
        others = np.arange(14) != i
        X = effects.products(coded, made.terms)
        c = np.linalg.lstsq(X[others], y[others], rcond=None)[0]
        missed += (y[i] - X[i] @ c) ** 2
    assert made.q2 == pytest.approx(1.0 - missed / np.sum((y - y.mean()) ** 2))
    assert made.q2 < made.r2


def test_too_few_points_give_less_of_a_surface():
    made, why = effects.surface(designs.corners(3)[:5], np.arange(5.0))
    assert len(made.terms) == 4
    assert "linear: 5 points do not determine 10 terms" in why
    none, why = effects.surface(designs.corners(3)[:3], np.arange(3.0))
    assert none is None
    assert why


def test_means_at_pairs_of_levels():
    y = np.array([60.0, 72.0, 54.0, 68.0, 52.0, 83.0, 45.0, 80.0])
    first, second, means = effects.cells(designs.corners(3), y, 0, 2)
    assert list(first) == list(second) == [-1.0, 1.0]
    assert means == pytest.approx(np.array([[57.0, 48.5], [70.0, 81.5]]))
