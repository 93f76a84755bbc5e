"""What motion and time decide for the heat besides friction.

Sunlight by the pose, conductance of joints by what their contacts did, heat of deformation.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coupling.joint_conductance import JointConductance
from coupling.transfer import Transfer
from mechanics import march

Array = NDArray[np.float64]
NONE: Mapping[str, Array] = {}


class Around:
    """See ``coupling.manager.Surroundings``; each of the three may be None.

    exposure : takes a time and a mechanical motion, gives irradiation by condition
    joints : conductance of joints
    elastic : takes both states of a window and their temperatures, gives heat (n,) [J]

    Attributes
    ----------
    lit : bool  whether light falls on anything
    """

    def __init__(
        self,
        transfer: Transfer,
        exposure: Any = None,
        joints: JointConductance | None = None,
        elastic: Any = None,
    ) -> None:
        self._transfer, self._exposure, self._joints = transfer, exposure, joints
        self._elastic, self.lit = elastic, exposure is not None
        self.held = frozenset() if joints is None else frozenset(j.name for j in joints.joints)

    def at(self, t: float, motion: Any, T: Array) -> Mapping[str, Array]:
        """Irradiation of a state, or of the reference (None); joints are open at the start."""
        joints = {} if self._joints is None else self._joints.start(self._means(T))
        return self._irradiation(t, motion) | joints

    def after(
        self, t: float, h: float, before: Any, motion: Any, T: Array, rows: Sequence[Any]
    ) -> Mapping[str, Array]:
        """Irradiation at the end of a window, mean conductance over it."""
        irradiation = self._irradiation(t + h, motion)
        if self._joints is None:
            return irradiation
        durations = np.diff(np.concatenate([[t], *(r.t for r in rows)]))
        response = np.concatenate([r.response for r in rows])
        force = response[..., march.ELASTIC] + response[..., march.DISSIPATIVE]
        gap = np.maximum(0.0, -response[..., march.DEPTH])
        means = self._means(0.5 * (before.T + T))
        return irradiation | self._joints.mean(before.outside, durations, force, gap, means)

    def released(self, before: Any, after: Any, T0: Array, T1: Array) -> Array | None:
        """(n,) [J] of heat that deformation releases."""
        return None if self._elastic is None else self._elastic(before, after, T0, T1)

    def _irradiation(self, t: float, motion: Any) -> dict[str, Array]:
        return {} if self._exposure is None else dict(self._exposure.at(t, motion))

    def _means(self, T: Array) -> Array:
        """(m,) [K]  at the mechanical points."""
        return self._transfer.read(T)[:, 0]
