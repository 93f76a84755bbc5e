"""Which vibration of one model is which of another: by the modal assurance criterion."""

import numpy as np
from numpy.typing import NDArray

from coupling.crosscheck.quantities import Quantity
from coupling.crosscheck.solved import Vibrations

Array = NDArray[np.float64]

NEAR = 0.02
"""Frequencies this near count as one: any mixture of their shapes is a shape, too [-]."""
ALIKE = 0.5
"""Least share of a shape that is found in another for the two to be a pair [-]."""


def paired(found: Vibrations, reference: Vibrations, count: int) -> list[tuple[float, float]]:
    """Frequency [Hz] of each of the first modes of the reference, and likeness of the shapes.

    Each shape of the reference is sought among those that lie in one cluster of frequencies, of
    which all combinations are shapes; nan where nothing is alike.
    """
    free, pairs = list(range(len(found.frequencies))), []
    for frequency, shape in list(zip(reference.frequencies, reference.shapes, strict=True))[:count]:
        scores = [_likeness(found, k, shape) for k in free]
        best = max(scores, default=0.0)
        if best < ALIKE:
            pairs.append((float("nan"), best))
            continue
        near = [k for k, s in zip(free, scores, strict=True) if s > best - 1e-3]
        chosen = min(near, key=lambda k: abs(found.frequencies[k] - frequency))
        free.remove(chosen)
        pairs.append((float(found.frequencies[chosen]), best))
    return pairs


def _likeness(found: Vibrations, k: int, shape: Array) -> float:
    """Share of a shape that the cluster about mode ``k`` spans, 0 to 1."""
    f = found.frequencies
    cluster = np.abs(f - f[k]) <= NEAR * np.abs(f[k])
    basis = np.linalg.qr(found.shapes[cluster].T)[0]
    return float(np.linalg.norm(basis.T @ shape) ** 2 / (shape @ shape))


def spectrum(pairs: list[tuple[float, float]]) -> list[Quantity]:
    """The frequencies as quantities."""
    return [
        Quantity(f"mode {k}", "Hz", np.array(frequency))
        for k, (frequency, _) in enumerate(pairs, 1)
    ]
