"""A driven hinge: what it demands, and what the body that it turns does."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.reading import Results

Array = NDArray[np.float64]


class Drive(NamedTuple):
    """Demanded rotation of a body about a fixed axis.

    time, angle : (n,) float [s], [rad]
    axis, position : (3,) float  unit vector and a point [m] of the axis in the first frame
    body : the one that is turned
    """

    joint: str
    time: Array
    angle: Array
    axis: Array
    position: Array
    body: str

    def demanded(self, time: Array) -> Array:
        """Angle [rad] at other times."""
        return np.interp(time, self.time, self.angle)


def find_drive(results: Results) -> Drive | None:
    """The first joint whose prescribed angle changes, None when there is none."""
    for joint in results.names("joints"):
        attributes = results.attributes(f"joints/{joint}")
        if f"joints/{joint}/angle" not in results or "axis" not in attributes:
            continue
        angle = results[f"joints/{joint}/angle"]
        body = str(attributes.get("journal_body", ""))
        if len(angle) > 1 and np.ptp(angle) > 0.0 and f"bodies/{body}/position" in results:
            axis = attributes["axis"] / np.linalg.norm(attributes["axis"])
            time = results[f"joints/{joint}/time"]
            return Drive(joint, time, angle, axis, attributes["position"], body)
    return None


def outermost_probe(results: Results, drive: Drive) -> str | None:
    """The probe that is farthest from the axis at first, None when there are no probes."""
    reach: dict[str, float] = {}
    for probe in results.names("probes"):
        if f"probes/{probe}/position" in results:
            position = results[f"probes/{probe}/position"]
            arm = np.cross(drive.axis, position[:1] - drive.position)
            reach[probe] = float(np.linalg.norm(arm))
    return max(reach, key=lambda probe: reach[probe]) if reach else None


def turned(vectors: Array, axis: Array, angle: Array) -> Array:
    """(n, 3) vectors, each turned about ``axis`` by its (n,) ``angle`` (Rodrigues)."""
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = np.sum(vectors * axis, axis=1, keepdims=True) * axis
    return along + cosine * (vectors - along) + sine * np.cross(axis, vectors)


def departure(time: Array, position: Array, drive: Drive) -> Array:
    """How far a point is from where the demanded rotation would carry it, rigidly.

    Parameters
    ----------
    time : (n,) float [s]
    position : (n, 3) float [m]

    Returns
    -------
    (n, 3) float [m]  away from the axis, in the sense of the rotation, along the axis
    """
    start = np.broadcast_to(position[0] - drive.position, position.shape)
    angle = drive.demanded(time) - drive.demanded(time[:1])
    rigid = turned(start, drive.axis, angle)
    outward = rigid - np.sum(rigid * drive.axis, axis=1, keepdims=True) * drive.axis
    outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-300)
    gap = position - drive.position - rigid
    directions = (outward, np.cross(drive.axis, outward), np.broadcast_to(drive.axis, gap.shape))
    return np.column_stack([np.sum(gap * direction, axis=1) for direction in directions])


def chord_angle(position: Array, axis: Array) -> Array:
    """Rotation (f,) [rad] about ``axis`` of the chord of a body since the first frame.

    position : (f, n, 3) float [m]
    """
    chord = position[:, -1] - position[:, 0]
    first = np.broadcast_to(chord[0], chord.shape)
    flat = first - np.sum(first * axis, axis=1, keepdims=True) * axis
    across = np.sum(np.cross(axis, flat) * chord, axis=1)
    return np.unwrap(np.arctan2(across, np.sum(flat * chord, axis=1)))
