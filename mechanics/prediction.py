"""The stress that Newton's method predicts, in place of the one at the new coordinates.

Seen as unknowns of their own, stresses follow the linear prediction S + D B dq of the last step.
Newton's method for (q, S), stresses eliminated, differs from the ordinary one only in the stress
of the geometric stiffness (mixed integration point Newton; Magisano, Leonetti & Garcea 2017, Int.
J. Numer. Meth. Engng 109:1237). The ordinary one takes the stress of a rod that a large step of
rotation has stretched by its square: much too large for what is slender.

No kernel has to know: the stress of a term is D (strain - free strain), hence its tangent with
free strains shifted by strain - predicted strain is the one wanted. A term that can do this has
``predicted(coef, y, step, new)``, which returns such coefficients; most call ``shifted``.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from mechanics.system import Coefficients, System

Array = NDArray[np.float64]


def predicted(
    system: "System", coef: "Coefficients", y: Array, step: Array, new: Array
) -> "Coefficients":
    """Coefficients whose stresses at ``new`` are those predicted at ``y`` for ``step``."""
    return tuple(
        _shifted(term, c, y, step, new) for term, c in zip(system.terms, coef, strict=True)
    )


def separated(
    system: "System", coef: "Coefficients", base: "Coefficients", y: Array, step: Array
) -> tuple["Coefficients", "Coefficients"]:
    """Coefficients with which stresses, and with which all else, follow the change ``step``.

    The first leave at ``y`` the stresses that ``coef`` and the step predict, where that is known,
    and are ``base`` elsewhere. The second are ``coef``, without stiffness where that is known.
    """
    stressed, rest = [], []
    for term, c, b in zip(system.terms, coef, base, strict=True):
        known = _shifted(term, c, y, step, y)
        stressed.append(b if known is c else known)
        rest.append(c if known is c else np.zeros_like(c))
    return tuple(stressed), tuple(rest)


def shifted(
    coef: Array,
    free: slice,
    strains: Callable[[Array, Array], tuple[Array, Array]],
    y: Array,
    step: Array,
    new: Array,
) -> Array:
    """``coef`` with other free strains, so that stresses at ``new`` are those predicted.

    Parameters
    ----------
    coef : (n_e, n_c) float
    free : its columns with free strains
    strains : strains at y and their rates with velocities v, both as many as there are columns
    """
    before, change = strains(y, step)
    after, _ = strains(new, step)
    moved = coef.copy()
    moved[:, free] += after - before - change
    return moved


def _shifted(term: Any, coef: Array, y: Array, step: Array, new: Array) -> Array:
    return term.predicted(coef, y, step, new) if hasattr(term, "predicted") else coef
