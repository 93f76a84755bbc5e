"""Numbers of the beam of ``mechanics.beam3243``: its rows, and the sums of products they are.

They are baked into the compiled kernels of ``beam3243_kernels``; they and what they are made of
are pure numbers (Hermite, Gauss, Legendre), not parameters.
"""

import numpy as np
from numpy.typing import NDArray

from mechanics.line_elements import (
    AXIAL_FORM,
    LEGENDRE,
    WEIGHT3,
    XI2,
    XI3,
    curvature_weights,
    tangent_weights,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Table = tuple[Indices, Indices, Indices, Array]

C, A1, A2, A3, B1, B2, B3 = range(7)
"""Vectors X."""
AXIAL, BENDING, SHEAR, TORSION, SECTION, NORMAL, TURN, ONE = 0, 3, 7, 11, 12, 18, 20, 21
"""First row of each kind of strain; bending, shear and section: k = 2 at both places, then k = 3.

Three kinds of rows are no strains: ``NORMAL``, Gamma_1^2 at the bending points; ``TURN``, the
sine of the turn of one end against the other; ``ONE``, the number 1, so that products hold
linear terms too. Rows ``BENDING`` hold the bending b of directors that need not be orthogonal;
the strain is in rows ``BENT``.
"""
BENT, MEAN, CROSS, ANGLE = 22, 26, 28, 29
"""First rows of the bending of orthonormal directors; of the means (2) of b over both points; of
their product/12; of a sixth of the square of the turn of one end against the other."""
CHORD = np.sqrt(3.0) / 240.0
"""Linear Legendre part of (r'.r' - 1)/2 in the cubic through two points of an inextensible curve:
- kappa kappa' L^3/120 from its error -r_xxxx x^2 (L - x)^2/24, as r_x.r_xxxx = -3 kappa kappa';
with the bending b, c at both points it is -CHORD times the sum of c_k^2 - b_k^2."""
MAGNUS = np.sqrt(3.0) / 12.0
"""Turn of the ends about the axis for bending (b_2, b_3) at one Gauss point, (c_2, c_3) at the
other: MAGNUS (b_2 c_3 - b_3 c_2), the second term of the expansion of Magnus (1954) for a
curvature that is linear in x."""
STRAINS, ROWS = 18, 30
INNER = 12
"""Number of measures on which later sweeps act: bending, shear, normal, turn and one."""
LONG = 24
"""Length of a row in X, with three zeros at its end."""
AXIS = np.array([C, A1, B1], dtype=np.intp)
"""Vectors on which the axis depends."""


def _products_of_vectors() -> Table:
    """Row, J, K, factor."""
    slopes = tangent_weights(XI2)
    forms = [*AXIAL_FORM, *(2.0 * slopes[:, :, None] * slopes[:, None, :])]
    terms = []
    for row, form in zip((*range(AXIAL, BENDING), NORMAL, NORMAL + 1), forms, strict=True):
        for i, j in zip(*np.triu_indices(3), strict=True):
            terms += [(row, AXIS[i], AXIS[j], form[i, j] * (0.5 if i == j else 1.0))]
    for k in range(2):
        row = SECTION + 2 * k
        terms += [(row, A2 + k, A2 + k, 0.5), (row + 1, B2 + k, B2 + k, 0.5)]
    terms += [(SECTION + 4, A2, A3, 1.0), (SECTION + 5, B2, B3, 1.0)]
    return _columns([*terms, (TURN, A3, B2, 0.5), (TURN, A2, B3, -0.5)])


def _products_of_strains() -> Table:
    """Row, p, q, factor: the third sweep, then the last."""
    ends = [1 - XI3, XI3]
    forms = np.einsum("kg,ig,jg->kij", LEGENDRE * WEIGHT3, ends, ends)
    forms = [*forms, *(2.0 * ENDS[:2, :, None] * ENDS[:2, None, :])]
    terms = []
    for k in range(2):
        a, b = SHEAR + 2 * k, SHEAR + 2 * k + 1
        for row, form in zip((*range(AXIAL, BENDING), NORMAL, NORMAL + 1), forms, strict=True):
            terms += [(row, a, b, -form[0, 1])]
            terms += [(row, a, a, -0.5 * form[0, 0]), (row, b, b, -0.5 * form[1, 1])]
        for g in range(2):
            own, other, sign = BENDING + 2 * k + g, BENDING + 2 * (1 - k) + g, 2.0 * k - 1.0
            terms += [(own, a, ONE, 1.0), (own, b, ONE, -1.0)]
            terms += [(other, TURN, p, sign * ENDS[g, i]) for i, p in enumerate((a, b))]
    return _columns([*terms, *_products_of_bending()])


def _products_of_bending() -> list[tuple[int, int, int, float]]:
    """The last sweep; no row is a factor before it is complete."""
    terms = [(MEAN + i // 2, BENDING + i, ONE, 0.5) for i in range(4)]
    terms += [(CROSS, MEAN, MEAN + 1, 1.0 / 12.0)]
    terms += [(BENT + i, BENDING + i, ONE, 1.0) for i in range(4)]
    terms += [(BENT + i, BENDING + (i + 2) % 4, CROSS, 1.0) for i in range(4)]
    terms += [(ANGLE, p, p, 1.0 / 6.0) for p in (TURN, MEAN, MEAN + 1)]
    terms += [(AXIAL + 1, BENDING + i, BENDING + i, CHORD * (2 * (i % 2) - 1)) for i in range(4)]
    terms += [(TORSION, TURN, ONE, 1.0), (TORSION, TURN, ANGLE, 1.0)]
    return [*terms, (TORSION, BENT, BENT + 3, -MAGNUS), (TORSION, BENT + 2, BENT + 1, MAGNUS)]


def _columns(terms: list[tuple[int, int, int, float]]) -> Table:
    rows, left, right = (np.array([t[i] for t in terms], dtype=np.intp) for i in range(3))
    return rows, left, right, np.array([t[3] for t in terms])


AHEAD = np.vstack([curvature_weights(XI2), [[0, 1, 0], [0, 0, 1]]])
"""(4, 3) weights of the vectors AXIS in u at the four points."""
ENDS = np.vstack([np.stack([1 - XI2, XI2], axis=-1), np.eye(2)])
"""(4, 2) weights of the directors of both nodes in d_k at the four points."""
POINT_ROW = np.array([[3, 5], [4, 6], [7, 9], [8, 10]], dtype=np.intp)
"""(4, 2) row of the strain of each point and k."""
ROW, LEFT, RIGHT, FACTOR = _products_of_vectors()
MIX_ROW, MIX_P, MIX_Q, MIX_FACTOR = _products_of_strains()
SWEEP = np.array([0, np.argmax(MIX_ROW == MEAN), MIX_FACTOR.size], dtype=np.intp)
"""Where the third sweep begins, and the last, and where it ends."""
INSIDE = np.array([*range(BENDING, TORSION), NORMAL, NORMAL + 1, TURN, ONE], dtype=np.intp)
"""(12,) the inner measures."""
OF = np.arange(STRAINS)
OF[BENDING:SHEAR] = np.arange(BENT, BENT + 4)
"""Row of each strain."""
PLACE = np.full(ROWS, -1, dtype=np.intp)
PLACE[INSIDE] = np.arange(INNER)
"""(22,) place of a row among the inner measures."""
OUTER = np.array([*range(AXIAL, BENDING), *range(SECTION, NORMAL)], dtype=np.intp)
"""Rows on which no other row depends."""
OWED_ROW = np.array([AXIAL] * 4 + [AXIAL + 1] * 11 + [AXIAL + 2] * 4, dtype=np.intp)
OWED_TO = np.concatenate([INSIDE[4:8], INSIDE[:11], INSIDE[4:8]])
"""Axial strains and the inner measures on which they depend: shear, the linear one on all."""
FIRST = np.array([0, 0, 3, 6, 0], dtype=np.intp)
"""First column in which four gradients, from rows 0, 4, ... on, have entries."""
