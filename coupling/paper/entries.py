"""What the report on the paper consists of."""

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

VERDICTS = (
    "reproduced",
    "trend reproduced",
    "does not follow",
    "not determined",
)
"""First words of verdicts: the printed number follows from the inputs; its direction and size do;
it contradicts the inputs, itself, or the physics; the paper does not give what it depends on."""


class Entry(NamedTuple):
    """One statement of the paper, and what became of it.

    place : such as "Table 6", "Fig. 13", "Sec. 3.5", "Abstract"
    claim : what is compared, in words, with units
    printed : what the paper prints
    inputs : what its inputs give here, with its laws and its material
    corrected : what the corrected physics gives
    verdict : in words; its first ones are of ``VERDICTS``
    rows : numbers of the checklist of components that this answers
    pictures : files
    """

    place: str
    claim: str
    printed: str
    inputs: str
    corrected: str
    verdict: str
    rows: tuple[int, ...] = ()
    pictures: tuple[Path, ...] = ()

    @property
    def kind(self) -> str:
        """Which of ``VERDICTS`` it is. Raises ValueError if it is none."""
        for kind in VERDICTS:
            if self.verdict.startswith(kind):
                return kind
        raise ValueError(f"{self.place}: a verdict begins with one of {', '.join(VERDICTS)}")


class Section(NamedTuple):
    """Entries of a part of the paper, and how long they took [s], with what they took from before.

    failure : "" or why it could not be finished
    """

    name: str
    entries: list[Entry]
    seconds: float
    failure: str = ""


def number(value: float, unit: str = "", digits: int = 4) -> str:
    """A number in words: ``number(0.0019, "m") == "0.0019 m"``."""
    return f"{value:.{digits}g} {unit}".strip()


def numbers(values: Iterable[float], unit: str = "", digits: int = 4) -> str:
    """Numbers in a row, with their unit once."""
    return f"{', '.join(number(value, digits=digits) for value in values)} {unit}".strip()


def away(value: float, reference: float) -> str:
    """How far a value is from another, in per cent of that."""
    if not np.isfinite(value) or not reference:
        return "not to be compared"
    return f"{100.0 * (value / reference - 1.0):+.3g} %"
