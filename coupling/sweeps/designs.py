"""Designs of experiments: coded points, -1 for the low value of a factor and 1 for the high one.

Factorial designs come in standard order: the first factor changes from point to point, the last
one slowest (Box, Hunter & Hunter 2005, Statistics for Experimenters, 2nd ed., ch. 5).
"""

from collections.abc import Sequence
from functools import reduce
from itertools import combinations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Words = tuple[str, ...]

GENERATORS: dict[int, tuple[Words, ...]] = {
    3: (("AB",),),
    4: (("ABC",),),
    5: (("ABCD",), ("AB", "AC")),
    6: (("ABCDE",), ("ABC", "BCD"), ("AB", "AC", "BC")),
    7: (("ABCDEF",), ("ABCD", "ABDE"), ("ABC", "BCD", "ACD"), ("AB", "AC", "BC", "ABC")),
    8: (("ABCDEFG",), ("ABCD", "ABEF"), ("ABC", "ABD", "BCDE"), ("BCD", "ACD", "ABC", "ABD")),
    9: (
        ("ACDFG", "BCEFG"),
        ("ABCD", "ACEF", "CDEF"),
        ("BCDE", "ACDE", "ABDE", "ABCE"),
        ("ABC", "BCD", "ACD", "ABD", "ABCD"),
    ),
    10: (
        ("ABCG", "BCDE", "ACDF"),
        ("BCDF", "ACDF", "ABDE", "ABCE"),
        ("ABCD", "ABCE", "ABDE", "ACDE", "BCDE"),
        ("ABC", "BCD", "ACD", "ABD", "ABCD", "AB"),
    ),
    11: (
        ("ABCG", "BCDE", "ACDF", "ABCDEFG"),
        ("CDE", "ABCD", "ABF", "BDEF", "ADEF"),
        ("ABC", "BCD", "CDE", "ACD", "ADE", "BDE"),
        ("ABC", "BCD", "ACD", "ABD", "ABCD", "AB", "AC"),
    ),
}
"""Products of the basic factors that set the further ones, by number of factors, fewer and fewer
points: Box, Hunter & Hunter (1978), Table 12.15."""
TRIPLES = {6: 6, 7: 7}
"""Numbers of factors of Box and Behnken (1960) whose blocks are {1, 2, 4}, moved on cyclically."""


def coded(design: Any, factors: Sequence[Any]) -> Array:
    """(n, k) points of a design.

    Parameters
    ----------
    design : ``coupling.sweep_tables.Design``;  factors : (k,) of ``coupling.sweep_tables.Factor``

    Raises
    ------
    ValueError : there is no such design for so many factors
    """
    k = len(factors)
    match design.kind:
        case "full-factorial":
            levels = [[f.coded(i) for i in range(f.count)] for f in factors]
            return _with_centre(grid(levels), design.centre or 0)
        case "fractional-factorial":
            chosen = generators(k, design.runs, design.resolution or 4)
            return _with_centre(fraction(k, chosen), design.centre or 0)
        case "central-composite":
            return central_composite(k, design.axial or "faced", _one(design.centre))
        case "box-behnken":
            return box_behnken(k, _one(design.centre))
    return spread(design.kind, k, design.runs, 1 if design.seed is None else design.seed)


def _one(centre: int | None) -> int:
    return 1 if centre is None else centre


def _with_centre(points: Array, count: int) -> Array:
    return np.vstack([points, np.zeros((count, points.shape[1]))])


# ------------------------------------------------------------------------------- factorials


def grid(levels: Sequence[Sequence[float]]) -> Array:
    """(n, k) all combinations, the first factor changing fastest."""
    rows = product(*reversed(levels))
    return np.array([row[::-1] for row in rows], dtype=float).reshape(-1, len(levels))


def corners(k: int) -> Array:
    """(2^k, k) in standard order."""
    return grid([(-1.0, 1.0)] * k)


def fraction(k: int, words: Words) -> Array:
    """(2^(k - p), k) corners where each of the last p factors is a product of basic ones."""
    basic = corners(k - len(words))
    further = [np.prod(basic[:, [_number(letter) for letter in word]], axis=1) for word in words]
    return np.column_stack([basic, *further])


def _number(letter: str) -> int:
    return ord(letter) - ord("A")


def generators(k: int, runs: int | None, least: int) -> Words:
    """The published generators of a fraction: of so many points, or the smallest of a resolution.

    Raises
    ------
    ValueError : there is none, with what there is
    """
    known = {2 ** (k - len(words)): words for words in GENERATORS.get(k, ())}
    if not known:
        last = max(GENERATORS)
        raise ValueError(f"fractional-factorial takes 3 to {last} factors, got {k}")
    if runs is not None and runs in known:
        return known[runs]
    fine = [n for n, words in known.items() if resolution(k, words) >= least]
    if runs is None and fine:
        return known[min(fine)]
    there = ", ".join(f"{n} points of {resolution(k, w)}" for n, w in sorted(known.items()))
    wanted = f"{runs} points" if runs is not None else f"resolution {least}"
    raise ValueError(f"no fraction of {k} factors has {wanted}; there are (resolution): {there}")


def defining(k: int, words: Words) -> list[frozenset[int]]:
    """Products of factors that are 1 at every point of a fraction."""
    first = k - len(words)
    own = [frozenset(map(_number, word)) | {first + i} for i, word in enumerate(words)]
    chosen = (c for n in range(1, len(own) + 1) for c in combinations(own, n))
    return [reduce(frozenset.symmetric_difference, c, frozenset()) for c in chosen]


def resolution(k: int, words: Words) -> int:
    """Length of the shortest word of the defining relation; k + 1 of a full factorial."""
    return min(map(len, defining(k, words)), default=k + 1)


# ------------------------------------------------------------------------ quadratic designs


def central_composite(k: int, axial: str, centre: int) -> Array:
    """Corners, two points on each axis and points in the middle (Box & Wilson 1951).

    Of five factors and more the corners are the smallest fraction of resolution 5. Rotatable ones
    have their axial points at the fourth root of the number of corners.
    """
    cube = corners(k) if k < 5 or k not in GENERATORS else fraction(k, generators(k, None, 5))
    far = 1.0 if axial == "faced" else len(cube) ** 0.25
    points = np.vstack([cube, *(far * sign * np.eye(k)[i] for i in range(k) for sign in (-1, 1))])
    return _with_centre(points / far if axial == "inscribed" else points, centre)


def box_behnken(k: int, centre: int) -> Array:
    """Middles of edges, or of faces, and points in the middle (Box & Behnken 1960)."""
    if not 3 <= k <= max(TRIPLES):
        raise ValueError(f"box-behnken takes 3 to {max(TRIPLES)} factors, got {k}")
    blocks = [*combinations(range(k), 2)]
    if k in TRIPLES:
        blocks = [tuple((i + j) % k for j in (0, 1, 3)) for i in range(k)]  # type: ignore[misc]
    points = []
    for block in blocks:
        rows = np.zeros((2 ** len(block), k))
        rows[:, sorted(block)] = corners(len(block))
        points.append(rows)
    return _with_centre(np.vstack(points), centre)


# --------------------------------------------------------------------------- filling space


def spread(kind: str, k: int, runs: int, seed: int) -> Array:
    """(runs, k) points that fill the cube: latin-hypercube, or sobol (scrambled)."""
    from scipy.stats import qmc

    engine: Any = qmc.Sobol if kind == "sobol" else qmc.LatinHypercube
    return 2.0 * engine(k, seed=seed).random(runs) - 1.0
