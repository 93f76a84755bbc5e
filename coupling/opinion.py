"""What another program makes of a scene."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.scene import Scene

Array = NDArray[np.float64]


class Opinion(NamedTuple):
    """One stage of a scene by another program; what it was not asked for is empty.

    program : and its version, where it says so
    dof : int  coordinates;  seconds : float [s]  run time of the program
    mass : float [kg]
    displacements : probe -> (3,) [m]  at rest
    reaction : (3,) float [N]  on all that joints hold
    frequencies : (m,) float [Hz]
    times : (k,) float [s];  courses : probe -> (k, 3) [m]  displacement over time
    turns : probe -> (3,) [rad]  rotation of its section at rest, or (k, 3) over time
    temperatures : probe -> [K]  at the end
    warnings : what is not to be trusted
    """

    program: str
    dof: int
    seconds: float
    mass: float = float("nan")
    displacements: Mapping[str, Array] = {}
    reaction: Array = np.empty(0)
    frequencies: Array = np.empty(0)
    times: Array = np.empty(0)
    courses: Mapping[str, Array] = {}
    turns: Mapping[str, Array] = {}
    temperatures: Mapping[str, float] = {}
    warnings: tuple[str, ...] = ()


def at_rest(scene: Scene, kind: str) -> Scene:
    """The same scene under another analysis, from the reference on."""
    analysis = scene.analysis.model_copy(update={"kind": kind, "start": "reference"})
    return scene.model_copy(update={"analysis": analysis})
