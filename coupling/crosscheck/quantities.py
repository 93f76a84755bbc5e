"""What a stage yields, and how far two models are from one another in it."""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Measure = Literal["value", "rms", "most", "nothing", "told"]


class Quantity(NamedTuple):
    """A value of one model.

    value : () number, (k,) vector, or (w, k) history
    measure : "value": relative to the size of the reference; "rms", "most": of a history, relative
        to its peak; "nothing": it should vanish, and is its own deviation;
        "told": not compared, as one of the models cannot know it
    scale : what deviations are relative to, instead of the size of the reference; 0: that size
    """

    name: str
    unit: str
    value: Array
    measure: Measure = "value"
    scale: float = 0.0

    @property
    def shown(self) -> float:
        """One number for the table: a component, the length of a vector, the peak of a history."""
        if self.value.ndim == 0:
            return float(self.value)
        return float(np.linalg.norm(self.value, axis=-1).max())


def deviation(one: Quantity, reference: Quantity) -> float:
    """How far a value is from a reference, relative to its size [-]; of numbers with a sign."""
    if one.measure == "nothing":
        return float(abs(one.value))
    size = reference.scale or abs(reference.shown)
    if one.value.shape != reference.value.shape:
        return float("nan")
    apart = one.value - reference.value
    if apart.ndim == 0:
        return _over(float(apart), size)
    lengths = np.linalg.norm(apart, axis=-1)
    if one.measure == "rms":
        return _over(float(np.sqrt(np.mean(lengths**2))), size)
    return _over(float(np.max(lengths)), size)


def _over(apart: float, size: float) -> float:
    if apart == 0.0:
        return 0.0
    return apart / size if size > 0.0 else float("inf")


ASSUMED = 1.0 / 4.0
"""What halving a mesh leaves of its error, where two meshes leave it open: second order [-]."""
SLOW = 0.9
"""Ratio of two changes above which they show no convergence [-]."""


def remaining(values: list[Quantity]) -> float:
    """Error that the last of several meshes leaves, relative to its value, after Richardson (1911).

    Of three meshes and more the last two changes say how fast they fall; of two it is assumed that
    halving takes three quarters of the error. Where changes do not fall, the last one itself.
    """
    if len(values) < 2:
        return float("nan")
    last = abs(deviation(values[-2], values[-1]))
    if values[-1].measure == "nothing":
        return abs(float(values[-1].value) - float(values[-2].value))
    if len(values) == 2:
        return last * ASSUMED / (1.0 - ASSUMED)
    before = abs(deviation(values[-3], values[-2]))
    ratio = last / before if before > 0.0 else 0.0
    return last * ratio / (1.0 - ratio) if ratio < SLOW else last
