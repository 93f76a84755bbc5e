"""What designs tell: effects of factors and their interactions, and quadratic response surfaces.

The effect of a factor is the mean response where it is high less that where it is low; that of an
interaction is the same of the product of its factors (Yates 1937; Box, Hunter & Hunter 2005, ch.
5). Without scatter, what stands out is judged by the pseudo standard error of all effects (Lenth,
Technometrics 31, 1989, 469-473).
"""

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Words = tuple[int, ...]


class Effect(NamedTuple):
    """A contrast of a two-level design.

    factors : of the product, by number;  size : in the unit of the response
    aliases : further products that cannot be told from it, and whether their sign is the other one
    """

    factors: Words
    size: float
    aliases: tuple[tuple[Words, bool], ...] = ()


class Surface(NamedTuple):
    """A least-squares polynomial in the coded factors.

    terms : factors of each term, () the constant;  coefficients : (m,) in the unit of the response
    r2 : part of the variance that it explains
    q2 : the same of points left out of the fit one by one; nan where a point decides a term alone
    """

    terms: tuple[Words, ...]
    coefficients: Array
    r2: float
    q2: float

    def at(self, coded: Array) -> Array:
        """(n,) responses at coded points (n, k)."""
        return products(coded, self.terms) @ self.coefficients


def products(coded: Array, terms: Sequence[Words]) -> Array:
    """(n, m) products of columns."""
    return np.column_stack([np.prod(coded[:, list(term)], axis=1) for term in terms])


def is_two_level(coded: Array) -> bool:
    """Whether the points but those in the middle are corners, each as often, with no factor bound.

    Then contrasts of the factors are at right angles.
    """
    cube = _corners(coded)
    if len(cube) < 4 or not np.all(np.abs(cube) == 1.0):
        return False
    middle = coded[~np.all(np.abs(coded) == 1.0, axis=1)]
    return not middle.any() and np.allclose(cube.T @ cube, len(cube) * np.eye(cube.shape[1]))


def _corners(coded: Array) -> Array:
    return coded[np.all(np.abs(coded) == 1.0, axis=1)]


def effects(coded: Array, y: Array, highest: int | None = None) -> list[Effect]:
    """Main effects and interactions of a two-level design, of as many factors each as there are.

    Parameters
    ----------
    coded : (n, k) corners, and points in the middle, which are left out
    y : (n,) responses; where one is missing (nan) nothing can be told: no effects
    highest : factors in a product, at most; None: all
    """
    corners = np.all(np.abs(coded) == 1.0, axis=1)
    cube, response = coded[corners], y[corners]
    if not np.all(np.isfinite(response)):
        return []
    found: dict[tuple[float, ...], list[tuple[Words, bool]]] = {}
    k = cube.shape[1]
    for order in range(1, (highest or k) + 1):
        for word in combinations(range(k), order):
            column = np.prod(cube[:, word], axis=1)
            if abs(column.sum()) == len(column):
                continue  # a word of the defining relation
            sign = float(column[0])
            found.setdefault(tuple(sign * column), []).append((word, sign < 0.0))
    return [_effect(words, np.array(column), response) for column, words in found.items()]


def _effect(words: list[tuple[Words, bool]], column: Array, y: Array) -> Effect:
    (first, turned), *others = words
    size = float(column @ y) * 2.0 / len(y) * (-1.0 if turned else 1.0)
    return Effect(first, size, tuple((word, other != turned) for word, other in others))


def margin(sizes: Array) -> float:
    """Lenth's margin of error at 95 %: effects within it do not stand out; nan of fewer than 3."""
    from scipy.stats import t

    sizes = np.abs(sizes)
    if len(sizes) < 3:
        return np.nan
    first = 1.5 * float(np.median(sizes))
    small = sizes[sizes < 2.5 * first]
    error = 1.5 * float(np.median(small)) if len(small) else 0.0
    return float(t.ppf(0.975, len(sizes) / 3.0)) * error


def half_normal(count: int) -> Array:
    """(count,) quantiles at which absolute effects are drawn, rising (Daniel 1959)."""
    from scipy.stats import norm

    return np.asarray(norm.ppf(0.5 + 0.5 * (np.arange(count) + 0.5) / count))


# -------------------------------------------------------------------------------- surfaces


def surface(coded: Array, y: Array) -> tuple[Surface | None, str]:
    """The polynomial of the highest order, up to the second, that the points determine.

    Parameters
    ----------
    coded : (n, k);  y : (n,)  points with nan are left out

    Returns
    -------
    surface, reason : None and why there is none; of a lower order than the second why so
    """
    there = np.isfinite(y)
    coded, y = coded[there], y[there]
    k = coded.shape[1]
    linear = [(), *((i,) for i in range(k))]
    crossed = [*linear, *combinations(range(k), 2)]
    squares = [*crossed, *((i, i) for i in range(k))]
    orders = {"": squares, "linear with interactions: ": crossed, "linear: ": linear}
    for said, terms in orders.items():
        made = _fitted(coded, y, tuple(terms))
        if made is not None:
            why = said + f"{len(y)} points do not determine {len(squares)} terms" if said else ""
            return made, why
    return None, f"{len(y)} points do not determine {len(linear)} terms"


def _fitted(coded: Array, y: Array, terms: tuple[Words, ...]) -> Surface | None:
    """The least-squares polynomial; None where terms cannot be told from each other."""
    if len(y) <= len(terms):
        return None
    X = products(coded, terms)
    if np.linalg.matrix_rank(X, tol=1e-8 * len(y) ** 0.5) < len(terms):
        return None
    left, _ = np.linalg.qr(X)
    coefficients = np.asarray(np.linalg.lstsq(X, y, rcond=None)[0], float)
    rest, leverage = y - X @ coefficients, np.sum(left**2, axis=1)
    total = float(np.sum((y - y.mean()) ** 2))
    if total == 0.0:
        return Surface(terms, coefficients, 1.0, 1.0)
    r2 = 1.0 - float(rest @ rest) / total
    if np.any(leverage > 1.0 - 1e-9):
        return Surface(terms, coefficients, r2, np.nan)
    press = float(np.sum((rest / (1.0 - leverage)) ** 2))
    return Surface(terms, coefficients, r2, 1.0 - press / total)


def level_means(coded: Array, y: Array) -> list[tuple[Array, Array]]:
    """Levels of each factor, rising, and the mean response at each, points with nan left out."""
    there = np.isfinite(y)
    found = []
    for column in coded[there].T:
        levels = np.unique(np.round(column, 9))
        means = [float(y[there][np.isclose(column, level)].mean()) for level in levels]
        found.append((levels, np.array(means)))
    return found


def cells(coded: Array, y: Array, a: int, b: int) -> tuple[Array, Array, Array]:
    """Levels of two factors, and the mean response (n_a, n_b) at each pair; nan where none is."""
    there = np.isfinite(y)
    pair = np.round(coded[there][:, [a, b]], 9)
    first, second = (np.unique(column) for column in pair.T)
    means = np.full((len(first), len(second)), np.nan)
    for i, u in enumerate(first):
        for j, w in enumerate(second):
            here = (pair[:, 0] == u) & (pair[:, 1] == w)
            if here.any():
                means[i, j] = y[there][here].mean()
    return first, second, means
